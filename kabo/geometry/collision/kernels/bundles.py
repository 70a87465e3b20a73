"""The bundles of arrays that collision kernels take, and the numbers of their columns, rows and places."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers

# Answers of checks: the number of a pair, or one of these; FIRST_OPEN - p: part p must have children to decide.
FREE, UNUSABLE, FIRST_OPEN = -1, -2, -3
# Rows of `Bodies.groups` and `Bodies.pairs`.
JOINT, PARTS, PAIRS, ROOTS_END = 0, 1, 2, 3
PARTNER, NUMBER = 0, 1
# Columns of `Hulls.rounds`: the radii of the ball and of the disc, and the disc's axis.
RADIUS, DISC, AXIS = 0, 1, 2
EXTENT_COLUMNS, BALL_OF_BOX, DISC_OF_BOX = 8, 6, 7  # of `Extents`
CORE_COLUMNS = 9  # of `Outlines.cores`
# Columns of `Tree.children`, and the number of children of a part that `Enclosure.finer` would divide.
FIRST_CHILD, CHILD_COUNT, OPEN = 0, 1, -1
# Places of `Search.counters`.
SEARCHES, ITERATIONS, UNDECIDED, MIDDLES, CHECKS, SWEEPS, POSITIVE = 0, 1, 2, 3, 4, 5, 6
COUNTER_PLACES = 8


class Chain(NamedTuple):
    """The kinematic tree as arrays for kernels."""

    joints: Integers  # (3, J) parent, kind, source
    factors: Array  # (2, J) ratio, shift
    placement: Array  # (J, 12)
    bound: Array  # (n,) greatest valid |q|


class Hulls(NamedTuple):
    """Convex parts, one a row: hulls of corners, with a ball and a flat disc added."""

    blocks: Array  # (B, 3, K) corners; unused columns repeat the first
    sizes: Integers  # (B,) how many columns to read
    rounds: Array  # (B, 5) radius, disc, and the disc's axis


class Bodies(NamedTuple):
    """Groups of convex parts, moving ones first, and the pairs to check, sorted by their first group."""

    groups: Integers  # (4, G+1) joint (0 for fixed groups), first part, first pair, the part after the last root
    pairs: Integers  # (2, P) second group, and the caller's number of the pair
    allowed: Integers  # (moving, W) a bit for each group that forms a pair with a group


class Extents(NamedTuple):
    """Boxes as centre and half extents, in the joint's frame; a row of eight is a line of the processor's cache."""

    parts: Array  # (B, 8) the box, and the radii of ball and disc
    groups: Array  # (G, 8) the box


class Outlines(NamedTuple):
    """As `Extents`, and how the corners of parts are spread."""

    parts: Array  # (B, 8)
    groups: Array  # (G, 8)
    cores: Array  # (B, 9) the corners' mean, and the spread: xx, xy, xz, yy, yz, zz


class Tree(NamedTuple):
    """Which parts have children that cover the body more closely, and how large parts are."""

    children: Integers  # (B, 2) first child, and how many; OPEN: not known yet
    diameters: Array  # (B,) [m] of the hull with its disc, without its ball, which no rotation moves
    stack: Integers  # (B + 1, 2) pairs of parts


class Checked(NamedTuple):
    """The bodies that a configuration check compares."""

    groups: Integers  # of `Bodies`
    listed: Integers  # (greatest number of roots,) those of one group that are near another group
    outlines: Outlines
    hulls: Hulls
    tree: Tree
    margin: float  # parts proven farther apart than this do not collide [m]


class Search(NamedTuple):
    """What a search for a separating axis needs, and writes."""

    offset: float  # for `farthest`: a power of two of at least twice every |vertex|
    axis: Array  # (3,)
    simplex: Array  # (4, 3)
    points: Array  # (4, 3)
    counters: Integers  # (8,) searches, iterations, undecided, poses inside sweeps, checks, sweeps, positive


class Tracks(NamedTuple):
    """Each group with each frame in which one of its pairs is swept (kabo.geometry.collision.kernels.tracks)."""

    tracks: Integers  # (2, T) group, frame
    pair_tracks: Integers  # (2, P)
    slacks: Array  # (P,) rest of the budget for `spread` [m]
    radii: Array  # (G,) how far corners and discs are from the joint's origin [m]
    kept: Array  # (2, G) what each group keeps from others beyond the margin [m], and the number of its hand


class Way(NamedTuple):
    """A straight joint-space segment, how its joints turn, and the frames at some of its nodes."""

    segment: Array  # (3, n) start, end, the node in work
    turned: Array  # (J,)
    lengths: Array  # (J,) of the placements' translations [m]
    motions: Array  # (T, 4) deviation, angle, path, stray
    strays: Array  # (n,) how far each value of a configuration may be from the segment [rad or m]
    frames: Array  # (SLOTS, J, 12)
    tags: Integers  # (SLOTS,)


class Nodes(NamedTuple):
    """The poses and boxes of tracks at the coarse nodes of a segment, and over all of it."""

    poses: Array  # (T * GRID, 12)
    boxes: Array  # (T * GRID, 6)
    marks: Integers  # (T * GRID,)
    whole_boxes: Array  # (T, 6)
    whole_marks: Integers  # (T,)


class Pool(NamedTuple):
    """What sweeps compute on first use and keep until there is no more room, and their scratch arrays."""

    keys: Integers  # (3, 2 * SWEEP_POOL_ROWS) key, mark, row of `Hulls`
    boxes: Array  # (B + SWEEP_POOL_ROWS, 6)
    interval_table: Integers  # (2, T * 2 * GRID) place in interval_boxes, mark
    interval_boxes: Array  # (.., 6)
    state: Integers  # (5,)
    stack: Integers  # (.., 4) node, width, both parts
    ends: Integers  # (4,)
    pose: Array  # (1, 12)
    united: Array  # (4, 6)
    known: Array  # (KNOWN_AXES, 3) along which two parts were apart last; zeros: not known. Pairs may share a row


class Scene(NamedTuple):
    """The bodies and joints that a segment moves."""

    chain: Chain
    groups: Integers  # of `Bodies`
    hulls: Hulls
    extents: Extents
    tree: Tree


class Sweep(NamedTuple):
    """What a sweep computes of a segment."""

    tracks: Tracks
    way: Way
    nodes: Nodes
    pool: Pool


class Limits(NamedTuple):
    """The distances that decide about a pair [m]."""

    slack: float  # rest of the budget for the spread of hulls
    pose_margin: float  # parts nearer than this at one pose collide
    margin: float  # parts proven farther apart than this do not


class Swept(NamedTuple):
    """A body that moves along a segment (kabo.geometry.collision.kernels.volumes)."""

    poses: Array  # (N + 1, 12) of its joint, at the nodes
    hulls: Hulls
    extents: Array  # (B, 8) as in `Extents`
    bounds: Array  # (B, 3) deviation, angle * diameter / 4, diameter / 4


class Surface(NamedTuple):
    """The triangles of a solid in a box tree."""

    boxes: Array  # (N, 6)
    children: Integers  # (N, 2)
    triangles: Array  # (T, 3, 3) in the order of the leaves
    stack: Integers  # (64,)


class Things(NamedTuple):
    """Bodies on joints, whose parts are ranges of rows (kabo.geometry.collision.kernels.witness)."""

    rows: Integers  # (3, T) joint, first part, part after the last
    radii: Array  # (T,) how far corners and discs are from the joint [m]
    joint_T: Array  # (T, 12)
    hulls: Hulls
    boxes: Array  # (B, 6) lower and upper


class Trail(NamedTuple):
    """A path from way point to way point, and where a pair of bodies is on it."""

    waypoints: Array  # (W, n)
    strays: Array  # (W - 1, n) how far each value of a configuration may be from each piece
    way: Way  # its frames (W + 1, J, 12): at the way points, and at another place
    poses: Array  # (2, W + 2, 12)
    bounds: Array  # (2, W - 1, 3) deviation, path and stray of each piece


class Sides(NamedTuple):
    """Bodies along a path, each in the frame of some of its pairs: what all of these pairs share."""

    numbers: Integers  # (T, J) of a body and a joint, whose frame it is; -1 if no pair has them
    keys: Integers  # (S, 2) the body and the joint of each number
    poses: Array  # (S, W, 12) at all way points; only the first one if it does not move
    bounds: Array  # (S, W - 1, 3) as those of `Trail`
    boxes: Array  # (S, 6) around all that it sweeps, lower and upper
    still: NDArray[np.bool_]  # (S,) whether it does not move on the path
    moves: NDArray[np.bool_]  # (S,) whether it moves, or strays


class Work(NamedTuple):
    """The scratch arrays of a proof."""

    ends: Integers  # (2, 4) first part, part after the last, first and last row of `Trail.poses`
    over: Array  # (2, 3) deviation, path and stray over a stretch
    still: NDArray[np.bool_]  # (2,) whether a body does not move
    box: Array  # (6,)
    swept: Array  # (2, 6)
    size: Array  # (2,)
    scratch: Array  # (2, 12)
    stack: Integers  # (.., 6)


class Proofs(NamedTuple):
    """The proofs of all pairs, one after the other."""

    codes: NDArray[np.uint8]  # (N,)
    axes: Array  # (N, 3)
    where: Integers  # (P,) the row after each pair's proof
    margins: Array  # (P + 1,) its least margin
    targets: Array  # (2, P) the margin that is wanted of each pair, and the one that it needs [m]
