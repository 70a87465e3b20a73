"""The shapes of links and bodies in the view document: their meshes, what encloses them for planning, their hulls."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from kabo.arrays import Array
from kabo.errors import MeshError
from kabo.meshes import Mesh, Rounding, hull_of
from kabo.scene import Element, Scene, one_mesh
from kabo.viewer.content.meshes import Detail, Meshes, reduced

if TYPE_CHECKING:
    from kabo.geometry import Enclosure
    from kabo.geometry_server import SceneEnclosures

ROUND_SIDES = 24  # of the polygon that is drawn for a disc, and about of a ball


class Shapes:
    """The shapes of a scene's links and bodies; meshes that several of them have are kept once."""

    def __init__(self, scene: Scene, meshes: Meshes, detail: Detail, enclosures: "SceneEnclosures | None") -> None:
        self._meshes, self._detail, self._enclosures = meshes, detail, enclosures
        self._prepared = set(scene.bodies) | {
            f"{r.name}.{link}" for r in scene.robots.values() for link in r.links
        }
        self._known: dict[tuple[str, str], Mesh | None] = {}  # by kind and digest

    def of(self, name: str, elements: Sequence[Element]) -> dict[str, Any]:
        """The shapes of a thing in layers, and how far its enclosing parts stick out of it [m], None if not known."""
        shapes = {"original": [self._meshes.shape(self._shown(each.mesh)) for each in elements]}
        hull = self._hull(elements)
        if hull is not None:
            shapes["hull"] = [self._meshes.shape(hull)]
        enclosure = self._enclosure(name)
        if enclosure is not None:
            shapes["enclosing"] = [self._meshes.shape(each) for each in parts_of(enclosure)]
        return {
            "shapes": shapes,
            "deviation": None if enclosure is None else enclosure.deviation_of_roots,
            "faces": sum(len(each.mesh.faces) for each in elements),
        }

    def _shown(self, mesh: Mesh) -> Mesh:
        if self._detail == "original":
            return mesh
        key = "low", mesh.digest
        if key not in self._known:
            self._known[key] = reduced(mesh)
        return self._known[key] or mesh

    def _hull(self, elements: Sequence[Element]) -> Mesh | None:
        """The hull of a thing with meshes; None if it is flat, or if its primitive shapes are convex already."""
        mesh = one_mesh([each.mesh for each in elements])
        if mesh is None or (len(elements) == 1 and elements[0].kind != "mesh"):
            return None
        key = "hull", mesh.digest
        if key not in self._known:
            try:
                self._known[key] = reduced(hull_of(mesh))
            except MeshError:
                self._known[key] = None
        return self._known[key]

    def _enclosure(self, name: str) -> "Enclosure | None":
        """The enclosure of a thing, if all its parts are there: none is made."""
        if self._enclosures is None or name not in self._prepared:
            return None
        try:
            elements = self._enclosures.elements(name)
        except MeshError:
            return None
        if not elements or not all(self._enclosures.known(each) for each in elements):
            return None
        return self._enclosures.of(name)


def parts_of(enclosure: "Enclosure") -> list[Mesh]:
    """The meshes of the parts that enclose a body, in its frame: those that no other part contains."""
    return [part_mesh(enclosure.parts[number], enclosure.rounding_of(number)) for number in enclosure.root_parts]


def part_mesh(corners: Array, rounding: Rounding) -> Mesh:
    """The mesh of a convex part: the hull of its corners (V, 3) with its rounding [m]."""
    points = corners
    if rounding.disc:
        points = _sum(points, rounding.disc * _circle(rounding.axis))
    if rounding.radius:
        points = _sum(points, rounding.radius * _ball())
    return hull_of(Mesh(np.ascontiguousarray(points), np.zeros((0, 3), dtype=np.int64)))


def _sum(points: Array, offsets: Array) -> Array:
    return np.asarray((points[:, None, :] + offsets[None, :, :]).reshape(-1, 3))


def _circle(axis: Sequence[float]) -> Array:
    """Points (N, 3) of the unit circle across an axis."""
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    angles = 2.0 * np.pi * np.arange(ROUND_SIDES) / ROUND_SIDES
    return np.outer(np.cos(angles), first) + np.outer(np.sin(angles), np.cross(axis, first))


def _ball() -> Array:
    """Points (N, 3) of the unit sphere: circles of latitude."""
    rings = []
    for latitude in np.linspace(-np.pi / 2, np.pi / 2, ROUND_SIDES // 2 + 1):
        ring = np.cos(latitude) * _circle((0.0, 0.0, 1.0)) + np.array([0.0, 0.0, np.sin(latitude)])
        rings.append(ring if abs(np.cos(latitude)) > 1e-9 else ring[:1])
    return np.concatenate(rings)
