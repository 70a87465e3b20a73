"""Removes faces without area and keeps the surface closed, by flipping their longest edge.

A face whose corner b lies on its long side from a to c cannot just be dropped: the neighbour over that side would
keep an edge that belongs to no other face. So the edge a-c is flipped: the flat face and its neighbour become two
faces with area.
"""

import numpy as np

from kabo.displays import counted
from kabo.meshes.mesh import Faces, Vertices
from kabo.meshes.soundness import flat

_MAX_ROUNDS = 8


def without_flat_faces(vertices: Vertices, faces: Faces, done: list[str]) -> Faces:
    """The faces of the mesh after removing faces without area by edge flips, as far as the mesh stays a manifold."""
    gone = 0
    for _ in range(_MAX_ROUNDS):
        wrong = np.flatnonzero(flat(vertices, faces))
        if not len(wrong):
            break
        faces, flipped = _flipped(vertices, faces, wrong)
        gone += flipped
        if not flipped:
            break
    if gone:
        done.append(f"flipped away {counted(gone, 'triangle')} without area")
    return faces


def _flipped(vertices: Vertices, faces: Faces, wrong: Faces) -> tuple[Faces, int]:
    """The faces after one round of flips, which leaves out neighbours already changed in it; and the number of flips."""
    faces = faces.copy()
    sides = {(int(a), int(b)): (face, k) for face, row in enumerate(faces) for k, (a, b) in enumerate(_sides(row))}
    touched: set[int] = set()
    count = 0
    for face in wrong.tolist():
        start, between, end = _along(vertices, faces[face])
        found = sides.get((start, end))
        if found is None or face in touched or found[0] in touched or found[0] == face:
            continue
        other, k = found
        tip = int(faces[other, (k + 2) % 3])
        if tip == between or (between, tip) in sides or (tip, between) in sides:
            continue
        touched |= {face, other}
        faces[face], faces[other] = (start, between, tip), (between, end, tip)
        count += 1
    return faces, count


def _sides(row: Faces) -> list[tuple[int, int]]:
    a, b, c = row.tolist()
    return [(a, b), (b, c), (c, a)]


def _along(vertices: Vertices, row: Faces) -> tuple[int, int, int]:
    """The corners of a flat face, cyclically shifted so that the corner that lies between the others is the second."""
    corners = vertices[row]
    lengths = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1)
    k = int(np.argmax(lengths))  # the long side leads from corner k to k + 1, so k + 2 lies between
    return int(row[(k + 1) % 3]), int(row[(k + 2) % 3]), int(row[k])
