"""The bundles of arrays that the kernels of a search take, and the numbers of their places."""

from typing import NamedTuple

from kabo.arrays import Array, Integers
from kabo.geometry.collision.kernels.bundles import Scene, Search, Sweep
from kabo.kinematics.kernels.motion_bounds import Pieces
from kabo.kinematics.kernels.projection import Pull
from kabo.scene.tree import KinematicTree

# What `run` returns. ASK: answer `Journal.question` and call again; FULL: give more room; PAUSE: look at the clock.
FOUND, BLOCKED, ASK, FULL, PAUSE = 1, 0, -9, -10, -11
LOOK, PROOF = 0, 1  # kinds of questions about an edge
STRAIGHT, GROW, CUT, SHORTEN, SETTLE, OVER = 0, 1, 2, 3, 4, 5  # phases
# Places of `Journal.state`.
(
    FREE_COUNTS, HIT_COUNTS, PROJECTS, CONSTRAINT, USED, ANSWERED, KIND, RECENT, SAMPLE, SPENT, RESTARTS, COUNTS,
    PHASE, PATH, SAFE, ATTEMPT, VAIN, LOOKS, CORNER, AHEAD,
) = (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 14, 15, 16, 17, 18, 19, 20)  # fmt: skip
STATE_PLACES = 21


class Kept(NamedTuple):
    """The constraint that every edge must keep; no rows if there is none."""

    rows: Array  # (R, W)
    tolerances: Array  # (R,)
    tree: KinematicTree
    pieces: Pieces
    pull: Pull
    iterations: int
    policy: int


class Space(NamedTuple):
    """The free space: bodies as configuration checks and sweeps take them, and the constraint."""

    memory: Array  # of `first_hit`
    margin: float
    clearance: float
    pairs: Integers
    scene: Scene
    sweep: Sweep
    search: Search
    kept: Kept


class Effort(NamedTuple):
    """How far a search goes, and in which steps."""

    batch: int  # samples, or attempts to shorten, in one call
    samples: int  # in all
    restart: int  # samples after which both trees start anew
    extension: float  # of a tree by one step [rad, L2]
    spacing: float  # between configurations that are looked at before the proof [rad, L2]
    step: float  # of a way under a constraint: a longer chord would leave it [rad, L2]
    attempts: int  # to shorten the path
    patience: int  # attempts in vain in a row
    least: float  # of an extension that is tried again, shorter, because it is blocked [rad, L2]
    wide: int  # one of so many samples is drawn between the bounds, the others near a node; 1: all
    near: float  # how far at most, along each joint [rad or m]


class Grown(NamedTuple):
    """The two trees, the path, and its way points' flags: whether the edge that leads there is proven."""

    nodes: Array  # (2, C, n)
    columns: Array  # (2, n, C) the same, turned: distances to all nodes are computed value by value
    away: Array  # (C,) scratch: squares of distances
    parents: Integers  # (2, C)
    path: Array  # (3, 2 C, n) the path, a scratch copy, and the last one that was proven whole
    flags: Integers  # (2, 2 C) of the path and the scratch copy
    lengths: Array  # (2 C,)


class Journal(NamedTuple):
    """Where the search is, what it asks, and which answers it has for the sample in work."""

    state: Integers  # (STATE_PLACES,)
    hits: Integers  # (P + 1,) edges rejected, by the pair that was hit; the last: by the constraint
    recent: Integers  # (A,) hits of the sample in work: taken back if it is done again
    answers: Integers  # (A,)
    question: Array  # (2, n) the ends of an edge
    points: Array  # (4, n) scratch
