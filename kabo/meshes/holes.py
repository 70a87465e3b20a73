"""Fills holes that can be filled in one way only: those of three edges, and flat convex ones of four."""

import numpy as np

from kabo.displays import counted
from kabo.meshes.mesh import Faces, Vertices
from kabo.meshes.topology import edges_of

_MAX_QUAD_EDGE = 0.1  # share of the mesh's diagonal: a hole of four longer edges may be intended


def fill_small_holes(vertices: Vertices, faces: Faces, tolerance: float, done: list[str]) -> Faces:
    """The faces, with new faces that fill holes of three edges and flat convex holes of four, oriented like neighbours."""
    longest = _MAX_QUAD_EDGE * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    patches = [patch for loop in _loops(faces) if (patch := _patch(vertices, loop, tolerance, longest))]
    if not patches:
        return faces
    made = [triangle for patch in patches for triangle in patch]
    done.append(f"filled {counted(len(patches), 'hole')} with {counted(len(made), 'triangle')}")
    return np.concatenate([faces, np.array(made, dtype=np.int64)])


def _loops(faces: Faces) -> list[list[int]]:
    """Border loops of three or four edges, opposite in direction to the adjacent faces, where borders do not branch.

    A loop of which two edges belong to one face is left out: it is the outline of a lone triangle, not a hole.
    """
    edges = edges_of(faces)
    sides = np.flatnonzero(edges.border[edges.of_side])
    starts = faces.reshape(-1)[sides]
    ends = np.roll(faces, -1, axis=1).reshape(-1)[sides]
    names, counts = np.unique(np.concatenate([starts, ends]), return_counts=True)
    simple = set(names[counts == 2].tolist())
    after = dict(zip(ends.tolist(), starts.tolist(), strict=True))
    beside = dict(zip(ends.tolist(), (sides // 3).tolist(), strict=True))
    loops: list[list[int]] = []
    seen: set[int] = set()
    for first in sorted(after):
        loop = [first]
        while len(loop) <= 4 and loop[-1] in after and loop[-1] in simple:
            following = after[loop[-1]]
            if following == first:
                break
            loop.append(following)
        closes = after.get(loop[-1]) == first
        several = len({beside.get(vertex) for vertex in loop}) == len(loop)
        if closes and several and 3 <= len(loop) <= 4 and not seen & set(loop) and simple.issuperset(loop):
            loops.append(loop)
            seen |= set(loop)
    return loops


def _patch(vertices: Vertices, loop: list[int], tolerance: float, longest: float) -> list[tuple[int, int, int]]:
    """The triangles that fill a loop; none if it can be filled in more than one way."""
    if len(loop) == 3:
        return [(loop[0], loop[1], loop[2])]
    points = vertices[loop]
    if np.linalg.norm(points - np.roll(points, -1, axis=0), axis=1).max() > longest:
        return []
    centre = points.mean(axis=0)
    normal = np.linalg.svd(points - centre)[2][2]
    turns = np.cross(np.roll(points, -1, axis=0) - points, points - np.roll(points, 1, axis=0)) @ normal
    if np.abs((points - centre) @ normal).max() > tolerance or not (np.all(turns > 0) or np.all(turns < 0)):
        return []
    return [(loop[0], loop[1], loop[2]), (loop[0], loop[2], loop[3])]
