"""Named tuples of the arrays for the kernels of edge contraction, and functions that allocate them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from kabo.arrays import Array, Integers
from kabo.geometry.triangles.kernels.octree import STACK_SIZE
from kabo.geometry.triangles.kernels.orientation import SCRATCH_SIZE

MAX_STAR_FACES = 20_000  # larger stars are not contracted


class ContractionSettings(NamedTuple):
    """The parameters of edge contraction; lengths in metres."""

    cost: int  # which cost function (kernels.quadrics)
    certify: bool  # whether distances are proven and crossings avoided
    vertices: int  # contraction stops at this number
    alive: int  # vertices at the beginning
    epsilon: float
    limit: float  # epsilon minus the rounding of distances
    dearest: float  # the greatest cost
    facing: float  # the least cosine between a face's normals before and after
    patience: float  # factor by which an edge may exceed its estimated cost and still be next
    regular: float  # share of the quadric's trace that regularises a new point towards the edge's middle
    slack: float  # distance of new points from the planes that they must be outside of
    diagonal: float
    x: float  # the middle of the mesh: quadrics are relative to it
    y: float
    z: float


class Net(NamedTuple):
    """The arrays of a mesh under contraction, of V vertices and F faces (layout: `kernels.star`)."""

    vertices: Array  # (V + 1, 3): the last row is for a point on trial
    faces: Integers  # (F, 3)
    normals: Array  # (F, 3)
    first: Integers  # (V,)
    following: Integers  # (3 F,)
    quadrics: Array  # (V, 10), or (1, 10) without memory
    locked: NDArray[np.bool_]  # (V,) must not move
    dead: NDArray[np.bool_]  # (V,)
    marks: Integers  # (V,)
    moved: Integers  # (V,) number of the contraction that put the vertex where it is
    changed: Integers  # (V,) number of the last contraction that changed a face at the vertex
    face_marks: Integers  # (F,)
    errors: Array  # (F,) proven bound of the face's distance to the original
    hints: Integers  # (F,) an original triangle near the face
    waits: Integers  # (V,) the greatest star of the vertex, in faces, that is tried
    components: Integers  # (V,) the connected component of a vertex
    volumes: Array  # (C, 2) the signed volume of each: now, and at the beginning
    clock: Integers  # (3,) last vertex mark, last face mark, number of refused edges


class Star(NamedTuple):
    """The scratch arrays for one star of at most S faces."""

    faces: Integers  # (S,)
    corners: Integers  # (S,)
    places: Integers  # (S,) which of the new triangles replaces the face
    errors: Array  # (S,)
    planes: Array  # (S, 4)
    bounds: Array  # (S, 4) the planes of faces that have an area
    turned: Array  # (S, 5)
    triangles: Array  # (S, 3, 3) the new faces
    slots: Integers  # (S,) the face that each of these becomes
    ring: Integers  # (S,)
    lower: Array  # (6,)
    holding: Integers  # (4,)
    quadric: Array  # (10,)
    scratch: Array  # (13, 10)


class Carried(NamedTuple):
    """The lists of original triangles assigned to each face (layout: `kernels.carried_triangles`)."""

    heads: Integers  # (F,)
    items: Integers  # (N,)
    bounds: Array  # (N,)
    stamps: Integers  # (N,)
    following: Integers  # (N,)
    valid: Integers  # (T,)
    marks: Integers  # (T,)
    marks_used: Integers  # (1,)
    free: Integers  # (3,) first free node, number of free nodes, number of them below which stale nodes are freed


class CarriedDraft(NamedTuple):
    """The assignments of original triangles to faces that a contraction would change."""

    nodes: Integers  # (M,)
    faces: Integers  # (M,)
    bounds: Array  # (M,)
    again: Integers  # (T, 2) triangles that need a new proof, and a new face near each
    proven: Integers  # (3,) moves by bound, all moves, triangles with a new proof


class Queue(NamedTuple):
    """A heap of edges by cost: costs (H,) and rows (H, 3) of two end vertices and a stamp."""

    costs: Array  # (H,)
    edges: Integers  # (H, 3)


class Work(NamedTuple):
    """The scratch arrays that several kernels share."""

    pieces: Array  # (64, 16)
    found: Integers  # (F,)
    stack: Integers
    pair: Array  # (6, 3)
    exact: Array
    budget: Integers  # (1,) work left for the proofs of one contraction


def _zeros(*shape: int) -> Integers:
    return np.zeros(shape, np.int64)


def net_of(vertices: Array, faces: Integers, locked: NDArray[np.bool_], hints: Integers, quadrics: int) -> Net:
    """The `Net` arrays of a mesh, with space for `quadrics` quadrics."""
    v, f = len(vertices), len(faces)
    edges = coo_array((np.ones(2 * f), (faces[:, [0, 1]].ravel(), faces[:, [1, 2]].ravel())), shape=(v, v))
    many, components = connected_components(edges, directed=False)
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
        volumes=np.zeros((many, 2)),
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


def queue_of(edges: int) -> Queue:
    """Allocates a heap for the given number of entries."""
    return Queue(np.empty(edges), np.empty((edges, 3), np.int64))


def refused_of(edges: int) -> Integers:
    """Allocates the table of refused edges; a row holds both end vertices, the time of the refusal and the stamp."""
    return np.zeros((edges, 4), np.int64)
