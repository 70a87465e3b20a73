"""Judges of bounding meshes that share nothing with kabo: exact signs, every pair looked at, constructive geometry.

Slow and obvious: fine for meshes of some hundred faces.
"""

from collections.abc import Iterator
from fractions import Fraction

import manifold3d
import numpy as np


def winding_number(point: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> int | None:
    """How often a closed mesh winds around a point, exactly; None if the point may lie on it.

    Counts the faces that a ray of a fixed, crooked direction meets. Signs of determinants come from floats where they
    are far above rounding, else from fractions; a ray that meets an edge or the point's own face says None.
    """
    ray = np.array([577.0, 333.0, 745.0]) / 1024
    a, b, c = (vertices[faces[:, k]] - point for k in range(3))
    around = [np.einsum("j,ij->i", ray, np.cross(p, q)) for p, q in ((a, b), (b, c), (c, a))]
    longest = np.max([np.linalg.norm(x, axis=1) for x in (a, b, c)], axis=0)
    unsure = 1e-13 * longest * (longest + np.abs(point).max())
    met = ~(np.any([x > unsure for x in around], axis=0) & np.any([x < -unsure for x in around], axis=0))
    exactly, total = [Fraction(x) for x in point.tolist()], 0
    way = [Fraction(x) for x in ray.tolist()]
    for face in faces[met]:
        corners = [[Fraction(x) - y for x, y in zip(vertices[k].tolist(), exactly, strict=True)] for k in face]
        sides = [_determinant(way, corners[i], corners[(i + 1) % 3]) for i in range(3)]
        if min(sides) < 0 < max(sides):
            continue
        volume = _determinant(*corners)
        if volume == 0 or 0 in sides:
            return None
        if (volume > 0) == (sides[0] > 0):
            total += 1 if sides[0] > 0 else -1
    return total


def _determinant(a: list[Fraction], b: list[Fraction], c: list[Fraction]) -> Fraction:
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


def distances_to_surface(points: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The distance of every point to the nearest triangle, every pair looked at [Ericson, 5.1.5]."""
    return np.array([_to_triangles(point, *(vertices[faces[:, k]] for k in range(3))).min() for point in points])


def _to_triangles(p: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    normal = np.cross(b - a, c - a)
    area = np.maximum(np.einsum("ij,ij->i", normal, normal), 1e-300)
    inside = np.ones(len(a), bool)
    nearest = np.full(len(a), np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ij,ij->i", np.cross(v - u, p - u), normal) >= 0
        length = np.maximum(np.einsum("ij,ij->i", v - u, v - u), 1e-300)
        t = np.clip(np.einsum("ij,ij->i", p - u, v - u) / length, 0, 1)
        nearest = np.minimum(nearest, np.linalg.norm(p - u - t[:, None] * (v - u), axis=1))
    above = np.abs(np.einsum("ij,ij->i", p - a, normal)) / np.sqrt(area)
    return np.where(inside & (area > 1e-290), np.minimum(above, nearest), nearest)


def crossing_pairs(vertices: np.ndarray, faces: np.ndarray) -> int:
    """How often an edge passes through the inside of a face that shares no vertex with it, exactly."""
    return sum(len(pierced) for _, pierced in _edges_through(vertices, faces))


def crossing_faces(vertices: np.ndarray, faces: np.ndarray) -> int:
    """How many faces have an edge that passes through another one's inside, or such an edge passes through theirs."""
    crossing = np.zeros(len(faces), bool)
    for edge, pierced in _edges_through(vertices, faces):
        if len(pierced):
            crossing[pierced] = True
            crossing |= np.isin(faces, edge).sum(axis=1) == 2
    return int(crossing.sum())


def _edges_through(vertices: np.ndarray, faces: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Every edge (2,) and the faces that share no vertex with it and whose inside it passes through, exactly."""
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    corners = vertices[faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    for first, second in edges:
        p, q = vertices[first], vertices[second]
        near = ((np.minimum(p, q) <= high) & (np.maximum(p, q) >= low)).all(axis=1)
        near &= ~np.isin(faces, (first, second)).any(axis=1)
        a, b, c = np.moveaxis(corners[near], 1, 0)
        through = _signs(a, b, c, p) * _signs(a, b, c, q) < 0
        a, b, c = a[through], b[through], c[through]
        around = [_signs(u, v, p, q) for u, v in ((a, b), (b, c), (c, a))]
        inside = np.all([x > 0 for x in around], axis=0) | np.all([x < 0 for x in around], axis=0)
        yield np.array([first, second]), np.flatnonzero(near)[through][inside]


def _signs(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """On which side of the plane through a, b, c the point d is, row by row: 1, 0 or -1."""
    a, b, c, d = np.broadcast_arrays(a, b, c, d)
    u, v, w = b - a, c - a, d - a
    value = np.einsum("ij,ij->i", np.cross(u, v), w)
    # Rounding of the determinant, and of the differences before it, which is coarser far from the origin.
    lengths = np.linalg.norm([u, v, w], axis=2)
    greatest = np.abs([a, b, c, d]).max(initial=0.0)
    doubtful = 1e-13 * (lengths.prod(axis=0) + greatest * lengths.max(axis=0) ** 2)
    signs = np.sign(value).astype(int)
    for i in np.flatnonzero(np.abs(value) <= doubtful):
        start = [Fraction(x) for x in a[i].tolist()]
        exact = [[Fraction(x) - y for x, y in zip(e[i].tolist(), start, strict=True)] for e in (b, c, d)]
        volume = _determinant(*exact)
        signs[i] = (volume > 0) - (volume < 0)
    return signs


def lonely_edges(faces: np.ndarray) -> int:
    """How many directed edges do not stand exactly once in each direction: none on a closed, oriented surface."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()
    counts: dict[tuple[int, int], int] = {}
    for a, b in edges:
        counts[a, b] = counts.get((a, b), 0) + 1
    return sum(counts[a, b] != 1 or counts.get((b, a)) != 1 for a, b in edges)


def volume_outside(inner: tuple[np.ndarray, np.ndarray], outer: tuple[np.ndarray, np.ndarray]) -> float:
    """The volume of what a solid has outside another; both without crossing faces."""
    first, second = (
        manifold3d.Manifold(manifold3d.Mesh64(np.ascontiguousarray(v), np.ascontiguousarray(f, np.uint64)))
        for v, f in (inner, outer)
    )
    return float((first - second).volume())
