"""Closed meshes that are hard to simplify: thin, pointed, noisy, hollow, slit, coplanar; all from a seed.

A shape is small enough for exact arithmetic and has a bounding box of diagonal 1. Its vertices are exact numbers, so
a placement by powers of two and whole metres can be undone without rounding.
"""

from dataclasses import dataclass

import manifold3d
import numpy as np
import trimesh
from hypothesis import strategies as st

Solid = manifold3d.Manifold


@dataclass(frozen=True)
class Shape:
    """A closed mesh; `simple` if no faces cross, so that constructive geometry can judge it."""

    vertices: np.ndarray
    faces: np.ndarray
    simple: bool = True

    @property
    def diagonal(self) -> float:
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))


def arrays(solid):
    """Vertices and faces of a manifold."""
    mesh = solid.to_mesh64()
    names = np.arange(len(mesh.vert_properties))
    names[np.asarray(mesh.merge_from_vert, np.int64)] = np.asarray(mesh.merge_to_vert, np.int64)
    used, faces = np.unique(names[np.asarray(mesh.tri_verts, np.int64)], return_inverse=True)
    return np.asarray(mesh.vert_properties, float)[used, :3], faces.reshape(-1, 3)


def joined(*parts):
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = [faces + start for (_, faces), start in zip(parts, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)


def _width(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _primitive(rng):
    choice, u = rng.integers(4), rng.uniform
    if choice == 0:
        made = Solid.cube((u(0.2, 1), u(0.2, 1), u(0.2, 1)), True)
    elif choice == 1:
        made = Solid.cylinder(u(0.2, 1.2), u(0.1, 0.5), u(0.02, 0.5), int(rng.integers(5, 24)), True)
    elif choice == 2:
        made = Solid.sphere(u(0.2, 0.6), int(rng.integers(8, 16)))
    else:
        made = Solid.hull_points(rng.normal(size=(int(rng.integers(5, 20)), 3)) * 0.4)
    return made.rotate(tuple(u(0, 360, 3))) if rng.random() < 0.7 else made


def carved(rng):
    """Unions and differences."""
    made = _primitive(rng)
    for _ in range(int(rng.integers(1, 4))):
        other = _primitive(rng).translate(tuple(rng.uniform(-0.4, 0.4, 3)))
        after = made + other if rng.random() < 0.5 else made - other
        made = made if after.is_empty() else after
    return arrays(made)


def plate(rng):
    """Flat or wavy, down to a millionth thick."""
    vertices, faces = arrays(
        Solid.cube((1, rng.uniform(0.3, 1), _width(rng, 1e-6, 0.1))).refine(int(rng.integers(3, 7)))
    )
    vertices[:, 2] += rng.uniform(0, 0.3) * np.sin(vertices[:, 0] * rng.uniform(0, 8)) * np.cos(vertices[:, 1] * 3)
    return vertices, faces


def needle(rng):
    """A prism or a cone, long and thin."""
    width = _width(rng, 1e-4, 3e-2)
    return arrays(Solid.cylinder(1, width, width * rng.uniform(0.1, 1), int(rng.integers(3, 16))).refine(2))


def apex(rng):
    """A star-shaped cone with a vertex of high degree."""
    count = int(rng.integers(20, 90))
    angle = 2 * np.pi * np.arange(count) / count
    radius = 1 + rng.uniform(0, 0.3) * np.cos(angle * int(rng.integers(1, 9)))
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)
    i = np.arange(count)
    k, top, foot = (i + 1) % count, 0 * i + count, 0 * i + count + 1
    faces = np.concatenate([np.stack([i, k, top], 1), np.stack([k, i, foot], 1)])
    return np.concatenate([rim, [[0, 0, rng.uniform(0.05, 2)], [0, 0, rng.uniform(-1, -0.3)]]]), faces


def noisy(rng):
    """A sphere whose vertices were moved in and out."""
    ball = trimesh.creation.icosphere(subdivisions=int(rng.integers(1, 3)))
    factors = np.exp(rng.normal(size=(len(ball.vertices), 1)) * rng.uniform(0.01, 0.4))
    return ball.vertices * factors, np.asarray(ball.faces)


def hollow(rng):
    """A solid with a hole inside: its second component is turned inwards."""
    outside = Solid.sphere(1, 16) if rng.random() < 0.5 else Solid.cube((2, 2, 2), True).refine(2)
    return arrays(outside - Solid.sphere(rng.uniform(0.3, 0.9), int(rng.integers(8, 16))))


def slit(rng):
    """A block with a slit, mostly narrower than epsilon."""
    gap = _width(rng, 1e-4, 0.05)
    cut = Solid.cube((gap, 0.8, 0.7)).translate(
        (rng.uniform(0.1, 0.85), -0.1, float(rng.choice([0.05, 0.2, -0.1])))
    )
    return arrays((Solid.cube((1, 0.6, 0.8)) - cut).refine(int(rng.integers(1, 4))))


def blocks(rng):
    """Boxes on a grid: everything is coplanar."""
    made = Solid()
    for corner in np.argwhere(rng.random((3, 3, 2)) < 0.5):
        made += Solid.cube((1.0001, 1.0001, 1.0001)).translate(tuple(map(float, corner)))
    return arrays(Solid.cube((1, 1, 1)) if made.is_empty() else made)


def overlapping(rng):
    """Two or three solids that may lie in each other."""
    parts = [arrays(_primitive(rng)) for _ in range(int(rng.integers(2, 4)))]
    return joined(*((vertices + rng.uniform(-0.3, 0.3, 3), faces) for vertices, faces in parts))


def smallest(rng):
    """Bodies with almost nothing to take away."""
    if rng.random() < 0.3:
        return arrays(Solid.tetrahedron())
    made = trimesh.creation.box([1, 2, 3]) if rng.random() < 0.5 else trimesh.creation.icosahedron()
    return np.asarray(made.vertices), np.asarray(made.faces)


KINDS = (carved, plate, needle, apex, noisy, hollow, slit, blocks, overlapping, smallest)
CROSSING = (overlapping,)  # kinds whose faces may cross


def shape(kind, seed) -> Shape:
    """A shape of a kind, with a bounding box of diagonal 1."""
    vertices, faces = kind(np.random.default_rng(seed))
    vertices = np.asarray(vertices, float) / np.linalg.norm(np.ptp(vertices, axis=0))
    return Shape(np.ascontiguousarray(vertices), np.ascontiguousarray(faces, np.int64), kind not in CROSSING)


def shapes():
    """Shapes of all kinds."""
    return st.builds(shape, st.sampled_from(KINDS), st.integers(0, 2**32 - 1))
