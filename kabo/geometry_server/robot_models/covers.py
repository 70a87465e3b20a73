"""Covers: coarse convex parts that enclose links, made in milliseconds. What they leave free is free.

Each slice of an element is enclosed by a polytope of 26 fixed directions. Answers "free" of covers hold for all finer
enclosures; where covers meet, the links' own enclosures decide.
"""

from collections.abc import Iterator

import numpy as np
from scipy.spatial import HalfspaceIntersection, QhullError

from kabo.arrays import Array
from kabo.errors import MeshError
from kabo.geometry import Budget, Enclosure
from kabo.geometry_server.answers import GeometryStatistics
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.meshes import Mesh, require_closed
from kabo.scene import Scene

SLICES = 6  # of a closed mesh, across its longest side
THICKNESS = 1e-4  # [m] by which covers are larger than what they cover: flat ones have an inside
SMALL_STEP = 1e-9  # [m] beyond the planes of a slice
WIDEST = 100.0  # [m]: a deviation that covers never reach


def _directions() -> Array:
    """The 26 directions (26, 3): of the faces, edges and corners of a cube."""
    grid = np.array(np.meshgrid([-1, 0, 1], [-1, 0, 1], [-1, 0, 1])).reshape(3, -1).T
    chosen = grid[np.any(grid != 0, axis=1)].astype(float)
    return np.asarray(chosen / np.linalg.norm(chosen, axis=1, keepdims=True))


def cover_of(points: Array) -> Array:
    """The corners (V <= 48, 3) of a polytope that encloses points (N, 3) [m]."""
    directions = _directions()
    offsets = (points @ directions.T).max(axis=0) + THICKNESS
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    try:
        halves = np.column_stack([directions, -offsets])
        corners = HalfspaceIntersection(halves, middle).intersections
    except QhullError:  # the middle of the box is outside of the polytope: the box will do
        corners = _box(points)
    return np.ascontiguousarray(np.unique(corners.round(12), axis=0)) if len(corners) <= 64 else _box(points)


def _box(points: Array) -> Array:
    low, high = points.min(axis=0) - THICKNESS, points.max(axis=0) + THICKNESS
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])


def covers_of(mesh: Mesh) -> tuple[Array, ...]:
    """Corners of polytopes whose union encloses a mesh: of its slices if it is closed, else one for all of it."""
    try:
        require_closed(mesh)
    except MeshError:
        return (cover_of(mesh.vertices),)
    return tuple(cover_of(points) for points in _slices(mesh))


def _slices(mesh: Mesh) -> Iterator[Array]:
    """The points of a closed mesh in each slice, with the points where edges cross its planes.

    The solid within a slice lies in the hull of these: a point of it that is extreme lies on the surface, or on a plane
    at the border of the cut, which is on the surface as well.
    """
    low, high = mesh.bounds
    axis = int(np.argmax(high - low))
    planes = np.linspace(low[axis], high[axis], SLICES + 1)
    edges = np.unique(np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    starts, ends = mesh.vertices[edges[:, 0]], mesh.vertices[edges[:, 1]]
    cuts = [_crossings(starts, ends, axis, plane) for plane in planes]
    heights = mesh.vertices[:, axis]
    for k in range(SLICES):
        inside = (heights >= planes[k] - SMALL_STEP) & (heights <= planes[k + 1] + SMALL_STEP)
        points = np.concatenate([mesh.vertices[inside], cuts[k], cuts[k + 1]])
        if len(points):
            yield points


def _crossings(starts: Array, ends: Array, axis: int, plane: float) -> Array:
    """The points (C, 3) where edges cross a plane across an axis."""
    before, after = starts[:, axis] - plane, ends[:, axis] - plane
    crossing = before * after < 0.0
    share = before[crossing] / (before[crossing] - after[crossing])
    return np.asarray(starts[crossing] + share[:, None] * (ends[crossing] - starts[crossing]))


class CoverSurroundings(SceneSurroundings):
    """The surroundings of robots with covers in place of enclosures; bodies count as free only beyond `clearance` [m]."""

    def __init__(self, scene: Scene, clearance: float) -> None:
        """Covers of a scene's links and bodies, made when they are first used."""
        budget = Budget(geometry=WIDEST, sweep=0.0, clearance=clearance)
        super().__init__(scene, budget, False, GeometryStatistics())
        self._covers: dict[str, Enclosure] = scene.memory.setdefault("covers", {})

    def enclosure(self, name: str) -> Enclosure:
        """The cover of a body or `robot.link`, in its own frame."""
        if name not in self._covers:
            parts: list[Array] = []
            for element in self.enclosures.elements(name):
                whole = element.kind != "mesh"
                parts.extend([cover_of(element.mesh.vertices)] if whole else covers_of(element.mesh))
            self._covers[name] = Enclosure(tuple(parts), 0.0)
        return self._covers[name]
