"""Meshes that lie inside elements: what lies in them lies in the element. Round shapes need them, as containers."""

import numpy as np

from kabo.arrays import Array
from kabo.meshes import Mesh, Rounding, hull_of
from kabo.scene.elements import Element

SIDES = 64, 1024  # of the prism in a cylinder: the least and the most
SUBDIVISIONS = 4, 6  # of the icosahedron in a ball, likewise


def inner_mesh(element: Element, tolerance: float) -> tuple[Mesh, float]:
    """A mesh that lies inside an element, and how far points of the element may be from it [m].

    That is at most `tolerance` [m] unless it would take a huge mesh; for a mesh or a box it is 0.
    """
    if element.corners is None or element.rounding is None:
        return element.mesh, 0.0
    rounding = element.rounding
    if rounding.disc:
        around, deviation = _disc(rounding, tolerance)
    else:
        around, deviation = _ball(rounding.radius, tolerance)
    points = (element.corners[:, None] + around[None]).reshape(-1, 3)
    return hull_of(Mesh(points, np.zeros((0, 3), dtype=np.int64))), deviation


def _disc(rounding: Rounding, tolerance: float) -> tuple[Array, float]:
    """Points on the rim of a disc, and how far the disc reaches out of their polygon."""
    share = min(1.0, tolerance / rounding.disc)
    sides = int(np.clip(np.ceil(np.pi / np.arccos(1.0 - share)), *SIDES))
    axis = np.asarray(rounding.axis)
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    angle = 2.0 * np.pi * np.arange(sides) / sides
    rim = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * np.cross(axis, first)
    return rounding.disc * rim, rounding.disc * (1.0 - float(np.cos(np.pi / sides)))


def _ball(radius: float, tolerance: float) -> tuple[Array, float]:
    """Points on a sphere, and how far the ball reaches out of their hull."""
    import trimesh

    for subdivisions in range(SUBDIVISIONS[0], SUBDIVISIONS[1] + 1):
        made = trimesh.creation.icosphere(subdivisions=subdivisions, radius=1.0)
        inner = float(np.min(np.einsum("ij,ij->i", made.face_normals, made.triangles[:, 0])))
        deviation = radius * (1.0 - inner)
        if deviation <= tolerance:
            break
    return radius * np.asarray(made.vertices), deviation
