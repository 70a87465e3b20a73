"""The bundles of arrays and numbers that the kernels of edge contraction take."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers
from kabo.geometry.triangles.kernels.octree import Octree
from kabo.geometry.triangles.triangle_trees import TriangleTree


class ContractionSettings(NamedTuple):
    """The parameters of edge contraction; lengths in metres."""

    cost: int  # which cost function (quadrics)
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
    """The arrays of a mesh under contraction, of V vertices and F faces (layout: `star`)."""

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
    """The lists of original triangles assigned to each face (layout: `carried_triangles`)."""

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
    """Edges that may be contracted: a heap by cost, and a table of those that were refused."""

    costs: Array  # (H,)
    edges: Integers  # (H, 3) both end vertices, and a stamp
    refused: Integers  # (R, 4) both end vertices, the time of the refusal, and the stamp


class Work(NamedTuple):
    """The scratch arrays that several kernels share."""

    pieces: Array  # (64, 16)
    found: Integers  # (F,)
    stack: Integers
    pair: Array  # (6, 3)
    exact: Array
    budget: Integers  # (1,) work left for the proofs of one contraction


class Evidence(NamedTuple):
    """What the proofs of contractions read and write."""

    original: TriangleTree
    octree: Octree  # of the faces of the net
    carried: Carried
    draft: CarriedDraft
    work: Work


class Trial(NamedTuple):
    """A contraction on trial: an edge, and the point that would replace it [m]."""

    a: int
    b: int
    size: int  # faces of its star
    x: float
    y: float
    z: float
