"""The data of a body for the library coal: its triangles, round shapes, convex hull and bounding ball."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import coal
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array, Integers
from kabo.scene import Element, Mesh
from kabo.verify.motion.shapes import Shape, round_shape, triangles

DISTANCE_ERROR = 1e-7  # [m] by which a distance of coal may be too large (4e-8 measured on healthy meshes)
ROUND_ERROR = 2e-6  # [m] the same for round shapes (8e-7 measured, two cylinders of a metre)
SAME_AREA = 1e-9  # share of the hull's area
_REQUEST, _FINE = coal.DistanceRequest(), coal.DistanceRequest()
_FINE.gjk_tolerance, _FINE.gjk_max_iterations = 1e-9, 300


@dataclass(frozen=True)
class Surface:
    """A body for distance queries, in its own frame; its mesh, hull, ball and box lie around round shapes."""

    mesh: Mesh  # all triangles, those around round shapes, too
    rounds: tuple[Shape, ...]
    others: tuple[Mesh, ...]  # what is not round
    hull: Any  # coal convex hull, or None for flat or tiny meshes, and where a corner has too many neighbours
    hull_vertices: Array  # (H, 3)
    is_convex: bool  # its triangles are those of the hull, as far as areas tell
    centre: Array  # (3,) of a ball around it
    radius: float  # [m]
    lower: Array  # (3,) of its box
    upper: Array
    witnesses: Array  # (C, 3) one point of every connected component and of every round shape
    corners: Array  # (F, 3, 3) the triangles of what is not round
    digest: str  # of the mesh
    identity: bytes  # of the mesh and the round shapes

    @cached_property
    def triangles(self) -> Any:
        """All triangles, as coal's tree; most bodies never need it, as hulls tell enough of them."""
        return triangles(self.mesh)

    @cached_property
    def shapes(self) -> tuple[Shape, ...]:
        """What the body is: round shapes, and the triangles of all else."""
        trees = (triangles(each) for each in self.others) if self.rounds else [self.triangles]
        return *self.rounds, *(Shape(tree, np.eye(4)) for tree in trees)


def surface(mesh: Mesh, elements: Sequence[Element] = ()) -> Surface:
    """The data of a body for distance queries.

    Args:
        mesh: the mesh of the body.
        elements: of what the body consists; without round ones it is the mesh.
    """
    vertices, faces = np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.faces)
    lower, upper = vertices.min(axis=0), vertices.max(axis=0)
    centre = (lower + upper) / 2
    radius = float(np.linalg.norm(vertices - centre, axis=1).max())
    rounds = [shape for shape in map(round_shape, elements) if shape is not None]
    others = [each.mesh for each in elements if each.rounding is None] if rounds else [mesh]
    hull, hull_vertices, area = _hull(vertices)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    own = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    return Surface(
        mesh,
        tuple(rounds),
        tuple(others),
        hull,
        hull_vertices,
        not rounds and abs(0.5 * own - area) <= SAME_AREA * area,
        centre,
        radius,
        lower,
        upper,
        np.concatenate(
            [*(_witnesses(m.vertices, m.faces) for m in others), *(r.body_T[None, :3, 3] for r in rounds)]
        ),
        np.concatenate([np.empty((0, 3, 3)), *(m.vertices[m.faces] for m in others)]),
        mesh.digest,
        identity(mesh, elements),
    )


def identity(mesh: Mesh, elements: Sequence[Element]) -> bytes:
    """What tells a body from all that have another shape."""
    digest = hashlib.sha256(mesh.digest.encode())
    for each in elements:
        if each.rounding is not None and each.corners is not None:
            digest.update(each.corners.tobytes() + repr(each.rounding).encode())
    return digest.digest()


def _hull(vertices: Array) -> tuple[Any, Array, float]:
    """The convex hull for coal, its vertices, and its area; None, all vertices, and 0 if they span no volume.

    None, too, if a corner has more neighbours than coal counts (255), as the tip of a fine cone: the mesh tells all then.
    """
    try:
        found = ConvexHull(vertices)
        corners = np.ascontiguousarray(vertices[found.vertices])
        points = coal.StdVec_Vec3s()
        for corner in corners:
            points.append(corner)
        return coal.Convex.convexHull(points, False, "Qt"), corners, float(found.area)
    except (QhullError, RuntimeError):
        return None, vertices, 0.0


def _witnesses(vertices: Array, faces: Integers) -> Array:
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    graph = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(len(vertices),) * 2)
    count, label = connected_components(graph, directed=False)
    used = np.unique(faces)
    first = [used[np.argmax(label[used] == piece)] for piece in range(count) if (label[used] == piece).any()]
    return np.asarray(vertices[first])


def encloses(outer: Surface, world_T_outer: Array, inner: Surface, world_T_inner: Array) -> bool:
    """Whether a component of `inner` lies inside the body of the closed surface `outer`; they must not cross."""
    outer_T_inner = inverse(world_T_outer) @ world_T_inner
    points = inner.witnesses @ outer_T_inner[:3, :3].T + outer_T_inner[:3, 3]
    boxed = ((points >= outer.lower) & (points <= outer.upper)).all(axis=1)
    return any(
        abs(_winding_number(outer.corners, point)) > 0.5 or any(shape.holds(point) for shape in outer.rounds)
        for point in points[boxed]
    )


def _winding_number(corners: Array, point: Array) -> float:
    """The winding number of a surface around a point: 0 outside, ±1 inside [van Oosterom and Strackee 1983]."""
    a, b, c = (corners[:, k] - point for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    determinant = np.einsum("ij,ij->i", a, np.cross(b, c))
    denominator = la * lb * lc
    denominator += np.einsum("ij,ij->i", a, b) * lc + np.einsum("ij,ij->i", b, c) * la
    denominator += np.einsum("ij,ij->i", c, a) * lb
    return float(np.arctan2(determinant, denominator).sum() / (2 * np.pi))


def hull_gap(first: Surface, world_T_first: Array, second: Surface, world_T_second: Array) -> float:
    """A proven lower bound of the distance of two surfaces, from their hulls [m]; 0 if none was found.

    coal proposes an axis; the gap along it is computed here from all hull vertices, so coal need not be trusted.
    """
    if first.hull is None or second.hull is None:
        return 0.0
    result = _measured(first.hull, world_T_first, second.hull, world_T_second, _REQUEST)
    axis = np.asarray(result.getNearestPoint2()) - np.asarray(result.getNearestPoint1())
    length = float(np.linalg.norm(axis))
    if not length > 0.0 or not result.min_distance > 0.0:
        return 0.0
    axis /= length
    reach = (first.hull_vertices @ (world_T_first[:3, :3].T @ axis)).max() + world_T_first[:3, 3] @ axis
    start = (second.hull_vertices @ (world_T_second[:3, :3].T @ axis)).min() + world_T_second[:3, 3] @ axis
    return max(0.0, float(start - reach) - 1e-12)


def hull_depth(first: Surface, world_T_first: Array, second: Surface, world_T_second: Array) -> float:
    """An estimate of how deep two hulls overlap [m], 0 if they do not; for messages only."""
    if first.hull is None or second.hull is None:
        return 0.0
    result = _measured(first.hull, world_T_first, second.hull, world_T_second, _REQUEST)
    return max(0.0, -float(result.min_distance))


def mesh_distance(first: Surface, world_T_first: Array, second: Surface, world_T_second: Array) -> float:
    """The distance of two bodies [m] less coal's possible error; 0 or less if they touch or cross.

    The meshes around round shapes bound it, too, and more closely where they lie on the shapes.
    """
    around = _distance(first.triangles, world_T_first, second.triangles, world_T_second) - DISTANCE_ERROR
    if not (first.rounds or second.rounds):
        return around
    exact = min(
        _distance(a.geometry, world_T_first @ a.body_T, b.geometry, world_T_second @ b.body_T)
        for a in first.shapes
        for b in second.shapes
    )
    return max(around, exact - ROUND_ERROR)


def _distance(first: Any, world_T_first: Array, second: Any, world_T_second: Array) -> float:
    return float(_measured(first, world_T_first, second, world_T_second, _FINE).min_distance)


def _measured(first: Any, world_T_first: Array, second: Any, world_T_second: Array, request: Any) -> Any:
    poses = [coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in (world_T_first, world_T_second)]
    result = coal.DistanceResult()
    coal.distance(first, poses[0], second, poses[1], request, result)
    return result


def inverse(matrix: Array) -> Array:
    """The inverse of a pose (4, 4)."""
    result = np.eye(4)
    result[:3, :3] = matrix[:3, :3].T
    result[:3, 3] = -matrix[:3, :3].T @ matrix[:3, 3]
    return result
