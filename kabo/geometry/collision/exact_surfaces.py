"""Bodies for python-fcl as they are: triangles, and points and segments with a ball around them.

Of python-fcl's own shapes, only spheres have right distances: those of capsules and cylinders were up to 1 mm too
large beside other shapes. Its distances of triangles are right to rounding, also of those without area. So a sphere is
a point, and a capsule a segment, whose distances are less by the radius; a cylinder is a prism around it with sides so
many that it lies at most 2e-5 of the radius outside.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import fcl
import numpy as np
import numpy.typing as npt

from kabo.arrays import Array, Integers
from kabo.content_cache import ContentCache
from kabo.geometry.parts import FixedGroup, Mesh, MovingGroup
from kabo.geometry.triangles.solids import Solid
from kabo.meshes.topology import labels
from kabo.scene import Element

TRIANGLE_BYTES = 1000  # of memory for a triangle: two nodes of fcl's tree, the solid's tree, arrays
PRISM_SIDES = 512  # of the prism around a cylinder, whose corners are 1.9e-5 of the radius outside of it


@dataclass(frozen=True)
class Core:
    """All points that are at most `radius` [m] from an fcl model of triangles."""

    model: fcl.BVHModel
    radius: float
    ends: Array  # (N, 2, 3) of the segments; none of a body's triangles


@dataclass(frozen=True)
class Surface:
    """A body for fcl: its cores, with the box of its mesh, a point of each component, and the solid of its triangles."""

    cores: tuple[Core, ...]
    vertices: Array  # (V, 3) of its mesh, which lies around it
    low: Array  # (3,)
    high: Array  # (3,)
    corners: Array  # (C, 3)
    solid: Solid | None  # of what has no ball


@dataclass(frozen=True, eq=False)
class _Arrays:
    """A key for surfaces: a mesh compared by identity, since its arrays never change, and the balls in it."""

    mesh: Mesh
    elements: tuple[Element, ...]

    def __hash__(self) -> int:
        return hash((id(self.mesh[0]), id(self.mesh[1])))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, _Arrays) or len(self.elements) != len(other.elements):
            return False
        ours, theirs = (*self.mesh, *self.elements), (*other.mesh, *other.elements)
        return all(a is b for a, b in zip(ours, theirs, strict=True))


_SURFACES: ContentCache[Surface] = ContentCache(64 << 20, lambda made: TRIANGLE_BYTES * len(made.vertices) * 2)


def surface_of(group: MovingGroup | FixedGroup) -> Surface:
    """The surface of a group, computed once for each mesh and its elements.

    Raises:
        ValueError: the group has no mesh.
    """
    mesh, elements = group.mesh, group.elements
    if mesh is None:
        raise ValueError("exact geometry needs the mesh of every body")
    return _SURFACES.get_or_make(_Arrays(mesh, elements), lambda: _surface(mesh, elements))


def surrounds(outer: Surface, points: Array) -> bool:
    """Whether a body contains any of the points (P, 3), given in its own frame."""
    return bool(holds(outer, points).any())


def holds(outer: Surface, points: Array) -> npt.NDArray[np.bool_]:
    """Which of the points (P, 3), given in its own frame, a body contains (P,)."""
    found = np.asarray(((outer.low <= points) & (points <= outer.high)).all(axis=1), np.bool_)
    if not found.any():
        return found
    within, kept = points[found], np.zeros(int(found.sum()), bool)
    if outer.solid is not None:
        kept |= outer.solid.insides(within)
    for core in outer.cores:
        for start, end in core.ends:
            kept |= _segment_distances(within, start, end) <= core.radius
    found[found] = kept
    return found


def distance(
    first: Surface, ours: Sequence[fcl.CollisionObject], second: Surface, theirs: Sequence[fcl.CollisionObject]
) -> float:
    """The distance of two bodies whose cores are placed [m]; not positive where they touch."""
    request = fcl.DistanceRequest()
    return min(
        float(fcl.distance(a, b, request, fcl.DistanceResult()) - core.radius - other.radius)
        for core, a in zip(first.cores, ours, strict=True)
        for other, b in zip(second.cores, theirs, strict=True)
    )


def touch(
    first: Surface, ours: Sequence[fcl.CollisionObject], second: Surface, theirs: Sequence[fcl.CollisionObject]
) -> bool:
    """Whether the surfaces of two bodies whose cores are placed share a point; a body may lie wholly in a ball."""
    for core, a in zip(first.cores, ours, strict=True):
        for other, b in zip(second.cores, theirs, strict=True):
            reach = core.radius + other.radius
            if reach == 0.0:
                met = fcl.collide(a, b, fcl.CollisionRequest(), fcl.CollisionResult()) > 0
            else:
                met = bool(fcl.distance(a, b, fcl.DistanceRequest(), fcl.DistanceResult()) <= reach)
            if met:
                return True
    return False


def placed(surface: Surface, pose: Array) -> list[fcl.CollisionObject]:
    """The cores of a body at a pose (12,)."""
    at = fcl.Transform(pose[:9].reshape(3, 3), pose[9:])
    return [fcl.CollisionObject(core.model, at) for core in surface.cores]


def _surface(mesh: Mesh, elements: Sequence[Element]) -> Surface:
    around = np.ascontiguousarray(mesh[0], np.float64)
    rounds = [each for each in elements if each.rounding is not None]
    sharp = [mesh] if not rounds else [_triangles(each) for each in elements if not _is_ball(each)]
    cores, corners, solid = [], [np.empty((0, 3))], None
    if sharp:
        counts = np.cumsum([0, *(len(vertices) for vertices, _ in sharp)])
        vertices = np.ascontiguousarray(np.concatenate([own for own, _ in sharp]), np.float64)
        faces = np.concatenate([own + count for (_, own), count in zip(sharp, counts, strict=False)])
        faces = np.ascontiguousarray(faces, np.int64)
        cores.append(Core(_model(vertices, faces), 0.0, np.empty((0, 2, 3))))
        corners.append(_corners(vertices, faces))
        solid = Solid(vertices, faces)
    balls: dict[float, list[Array]] = {}
    for each in rounds:
        if _is_ball(each) and each.corners is not None and each.rounding is not None:
            balls.setdefault(each.rounding.radius, []).append(each.corners[[0, -1]])
    for radius, found in balls.items():
        ends = np.array(found)
        numbers = 2 * np.arange(len(ends))
        faces = np.column_stack([numbers, numbers + 1, numbers + 1])
        cores.append(Core(_model(ends.reshape(-1, 3), faces), radius, ends))
        corners.append(ends[:, 0])
    return Surface(tuple(cores), around, around.min(axis=0), around.max(axis=0), np.concatenate(corners), solid)


def _is_ball(element: Element) -> bool:
    """Whether an element is a sphere or a capsule."""
    return element.rounding is not None and element.rounding.disc == 0.0


def _triangles(element: Element) -> Mesh:
    """The triangles of an element, of a fine prism around a cylinder."""
    if element.rounding is None or element.corners is None:
        return element.mesh.vertices, element.mesh.faces
    axis = np.array(element.rounding.axis)
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    angle = 2.0 * np.pi * np.arange(PRISM_SIDES) / PRISM_SIDES
    rim = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * np.cross(axis, first)
    rim *= element.rounding.disc / np.cos(np.pi / PRISM_SIDES)
    low, high = sorted(element.corners, key=lambda end: float(end @ axis))
    here = np.arange(PRISM_SIDES)
    there = (here + 1) % PRISM_SIDES
    ends = np.full(PRISM_SIDES, 2 * PRISM_SIDES)
    faces = [
        np.column_stack([here, there, there + PRISM_SIDES]),
        np.column_stack([here, there + PRISM_SIDES, here + PRISM_SIDES]),
        np.column_stack([there, here, ends]),
        np.column_stack([here + PRISM_SIDES, there + PRISM_SIDES, ends + 1]),
    ]
    return np.concatenate([low + rim, high + rim, [low, high]]), np.concatenate(faces)


def _model(vertices: Array, faces: Integers) -> fcl.BVHModel:
    model = fcl.BVHModel()
    model.beginModel(len(vertices), len(faces))
    model.addSubModel(vertices, faces)
    model.endModel()
    return model


def _corners(vertices: Array, faces: Integers) -> Array:
    """A vertex of each component."""
    edges = faces[:, [0, 1, 1, 2]].reshape(-1, 2)
    component = labels(len(vertices), *edges.T)[faces[:, 0]]
    return np.asarray(vertices[faces[np.unique(component, return_index=True)[1], 0]])


def _segment_distances(points: Array, start: Array, end: Array) -> Array:
    """The distances of points (P, 3) from a segment (P,)."""
    along, away = end - start, points - start
    square = float(along @ along)
    share = np.clip(away @ along / square, 0.0, 1.0) if square > 0.0 else np.zeros(len(points))
    return np.asarray(np.linalg.norm(away - share[:, None] * along, axis=1))
