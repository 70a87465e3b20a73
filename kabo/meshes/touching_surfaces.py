"""Separates surfaces that only touch in a vertex or along an edge, by copying vertices; no point moves.

Around an edge of four faces or more, sorted by angle, the solid begins at a face that passes the edge backwards
and ends at the next one that passes it forwards: these two faces are joined.
"""

import numpy as np

from kabo.displays import counted
from kabo.meshes.mesh import Faces, Vertices
from kabo.meshes.topology import Edges, edges_of, fans, fans_around, neighbours


def separated(vertices: Vertices, faces: Faces, done: list[str]) -> tuple[Vertices, Faces]:
    """The same triangles, with a copy of a vertex for each separate fan of faces around it."""
    if not len(faces):
        return vertices, faces
    edges = edges_of(faces)
    first, second = _joined_sides(vertices, faces, edges)
    fan = fans(faces, edges, first, second)
    touching = int((fans_around(faces, fan) > 1).sum())
    if not touching:
        return vertices, faces
    pairs, index = np.unique(np.stack([faces.reshape(-1), fan], axis=1), axis=0, return_inverse=True)
    done.append(f"separated surfaces that only touched, in {counted(touching, 'vertex', 'vertices')}")
    return np.ascontiguousarray(vertices[pairs[:, 0]]), index.reshape(-1, 3).astype(np.int64)


def _joined_sides(vertices: Vertices, faces: Faces, edges: Edges) -> tuple[Faces, Faces]:
    """Pairs of joined face sides: both sides of an edge, or, at an edge with more faces, those around the same solid."""
    crowded = edges.count > 2
    first, second = neighbours(edges, ~crowded | (edges.balance != 0))
    order = np.argsort(edges.of_side, kind="stable")
    starts = np.searchsorted(edges.of_side[order], np.arange(len(edges.ends) + 1))
    matched = [
        pair
        for edge in np.flatnonzero(crowded & (edges.balance == 0))
        for pair in _around(vertices, faces, edges, order[starts[edge] : starts[edge + 1]])
    ]
    if not matched:
        return first, second
    extra = np.array(matched, dtype=np.int64)
    return np.concatenate([first, extra[:, 0]]), np.concatenate([second, extra[:, 1]])


def _around(vertices: Vertices, faces: Faces, edges: Edges, sides: Faces) -> list[tuple[int, int]]:
    """Pairs of a backward side of one edge and the forward side where its solid ends, in order of angle."""
    low, high = vertices[edges.ends[edges.of_side[sides[0]]]]
    axis = (high - low) / np.linalg.norm(high - low)
    tips = vertices[faces[sides // 3, (sides % 3 + 2) % 3]] - low
    across = tips - np.outer(tips @ axis, axis)
    right = across[0] / np.linalg.norm(across[0])
    angles = np.arctan2(across @ np.cross(axis, right), across @ right)
    circle = sides[np.lexsort((edges.forward[sides], angles))]
    begins = ~edges.forward[circle]
    depth = np.cumsum(np.where(begins, 1, -1))
    start = (int(np.argmin(depth)) + 1) % len(circle)  # from here on, no end comes before its beginning
    waiting: list[int] = []
    pairs = []
    for side in np.roll(circle, -start).tolist():
        if edges.forward[side]:
            pairs.append((waiting.pop(), side))
        else:
            waiting.append(side)
    return pairs
