"""Functions that allocate the arrays for the kernels of edge contraction."""

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers
from kabo.geometry.bounding.kernels.bundles import Carried, CarriedDraft, Net, Queue, Star, Work
from kabo.geometry.triangles.kernels.octree import STACK_SIZE
from kabo.geometry.triangles.kernels.orientation import SCRATCH_SIZE
from kabo.meshes.topology import labels

MAX_STAR_FACES = 20_000  # larger stars are not contracted


def _zeros(*shape: int) -> Integers:
    return np.zeros(shape, np.int64)


def net_of(vertices: Array, faces: Integers, locked: NDArray[np.bool_], hints: Integers, quadrics: int) -> Net:
    """The `Net` arrays of a mesh, with space for `quadrics` quadrics."""
    v, f = len(vertices), len(faces)
    components = labels(v, faces[:, [0, 1]].ravel(), faces[:, [1, 2]].ravel())
    return Net(
        vertices=np.vstack([vertices, np.zeros((1, 3))]),
        faces=faces.copy(),
        normals=np.empty((f, 3)),
        first=_zeros(v),
        following=_zeros(3 * f),
        quadrics=np.zeros((quadrics, 10)),
        locked=locked,
        dead=np.zeros(v, np.bool_),
        marks=_zeros(v),
        moved=_zeros(v),
        changed=_zeros(v),
        face_marks=_zeros(f),
        errors=np.zeros(f),
        hints=hints,
        waits=np.full(v, MAX_STAR_FACES, np.int64),
        components=components.astype(np.int64),
        volumes=np.zeros((int(components.max(initial=-1)) + 1, 2)),
        clock=_zeros(3),
    )


def star_of(faces: int) -> Star:
    """Allocates scratch arrays for stars of at most the given number of faces."""
    s = min(faces, MAX_STAR_FACES)
    return Star(
        faces=_zeros(s),
        corners=_zeros(s),
        places=_zeros(s),
        errors=np.empty(s),
        planes=np.empty((s, 4)),
        bounds=np.empty((s, 4)),
        turned=np.empty((s, 5)),
        triangles=np.empty((s, 3, 3)),
        slots=_zeros(s),
        ring=_zeros(s),
        lower=np.empty(6),
        holding=_zeros(4),
        quadric=np.empty(10),
        scratch=np.empty((13, 10)),
    )


def carried_of(faces: int, nodes: int) -> Carried:
    """Allocates the lists of original triangles for the given numbers of faces and list nodes."""
    return Carried(
        heads=_zeros(faces),
        items=_zeros(nodes),
        bounds=np.empty(nodes),
        stamps=_zeros(nodes),
        following=_zeros(nodes),
        valid=_zeros(faces),
        marks=_zeros(faces),
        marks_used=_zeros(1),
        free=_zeros(3),
    )


def draft_of(faces: int, moves: int) -> CarriedDraft:
    """Allocates a `CarriedDraft` for the given numbers of moves and original triangles."""
    return CarriedDraft(_zeros(moves), _zeros(moves), np.empty(moves), _zeros(faces, 2), _zeros(3))


def work_of(faces: int) -> Work:
    """Allocates the scratch arrays for a mesh of the given number of faces."""
    return Work(
        np.empty((64, 16)),
        _zeros(faces),
        _zeros(max(STACK_SIZE, 64)),
        np.empty((6, 3)),
        np.empty(SCRATCH_SIZE),
        _zeros(1),
    )


def queue_of(edges: int, refused: int) -> Queue:
    """Allocates a heap for the given number of entries, and the table of refused edges."""
    return Queue(np.empty(edges), np.empty((edges, 3), np.int64), _zeros(refused, 4))
