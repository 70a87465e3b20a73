"""The search for ways between two configurations: proven free, shortened, the same for the same key.

All work is done by one kernel [kabo.ways.kernels.search] on arrays that it is given again until it is done: it stops for
what only Python can answer, for more room, and now and then, so that a search can be cut off.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array, Integers
from kabo.geometry import Budget, CollisionView, KernelChecks
from kabo.kinematics import KeptRows
from kabo.kinematics.kernels import rows as columns
from kabo.scene import KinematicTree
from kabo.streams import Key
from kabo.ways.kernels import bundles as places
from kabo.ways.kernels.bundles import Effort, Grown, Journal, Kept, Space
from kabo.ways.kernels.search import run

FreeSegment = Callable[[Array, Array], int]  # -1: proven free; else the number of the pair that is hit
FreeConfigurations = Callable[[Array], Integers]  # (N, n) -> (N,), each as above

CHECK_SPACING = 0.2  # [rad, L2] between configurations that are looked at before the proof
MAX_CONSTRAINED_STEP = 0.15  # [rad, L2] the longest edge under a constraint: a longer chord would leave it
MAX_EXTENSION, LEAST_EXTENSION = 0.7, 0.5  # [rad, L2] of a tree by one step, and of one that was blocked before
WIDE, NEAR = 8, 2.0  # one of so many samples is drawn anywhere, the others so near a node, by joint [rad or m]
RESTART_SAMPLES = 3000  # after so many samples both trees start anew, since run times have a heavy tail
BATCH = 512  # samples, or attempts to shorten, between two looks at the clock
ROOM, ANSWERS = 256, 256  # nodes of a tree, and answers for one sample, at first


@dataclass(frozen=True)
class NoPath:
    """The result if no path was found within the budget: the hits of each pair, and the number of samples drawn."""

    hits: Counter[int]
    samples: int


@dataclass(frozen=True)
class FreeSpace:
    """What a way must avoid and keep.

    Attributes:
        configurations: for configurations (N, n) the number of a pair that is hit, or -1, each; cheaper than a proof
            and asked first; None: there is no such look.
        segment: -1 if the straight segment is proven free, else the number of a pair that is hit.
        pairs: how many pairs there are; the number after the last one stands for the constraint.
        checks: returns what the kernel needs to answer itself; None: it asks the functions.
        kept: the constraint that must hold throughout, if there is one.
        projects: whether configurations are pulled onto the constraint, or are only rejected where it does not hold.
        look: called now and then; an exception ends the search.
    """

    configurations: FreeConfigurations | None
    segment: FreeSegment
    pairs: int
    checks: Callable[[], KernelChecks | None] = lambda: None
    kept: KeptRows | None = None
    projects: bool = True
    look: Callable[[], None] = lambda: None


def find_way(
    start: ArrayLike,
    goal: ArrayLike,
    space: FreeSpace,
    lower: ArrayLike,
    upper: ArrayLike,
    key: Key,
    *,
    samples: int,
    attempts: int = 0,
    patience: int | None = None,
    restart: int = RESTART_SAMPLES,
) -> Array | NoPath:
    """Way points (m, n) from start to goal, every segment between them proven free, or `NoPath`.

    The straight segment is tried first. The answer depends on the arguments only.

    Args:
        start, goal: configurations (n,) within the limits, which fulfil the constraint if there is one.
        space: what the way avoids and keeps.
        lower, upper: (n,) finite bounds of the samples.
        key: the key of the random numbers.
        samples: the greatest total number of samples.
        attempts: the number of pairs of points of the path that are tried as shortcuts.
        patience: the number of attempts in a row that may fail; None for no limit.
        restart: the number of samples after which new trees are started.

    Raises:
        ValueError: shapes do not fit, or a bound is not finite.
    """
    ends = np.array([start, goal], np.float64)
    low, high = np.array(lower, np.float64), np.array(upper, np.float64)
    if not low.shape == high.shape == ends[0].shape or not np.all(np.isfinite([*ends, low, high])):
        raise ValueError("start, goal and limits must be finite and of one shape")
    effort = _effort(samples, restart, attempts, patience)
    search = _Search(space, ends.shape[1], effort)
    search.grown.nodes[:, 0] = ends
    search.grown.parents[:, 0] = -1
    search.state[places.COUNTS : places.COUNTS + 2] = 1
    search.grown.columns[:, :, 0] = ends
    found = search.run(low, high, key)
    if found is not None:
        return found
    hits = search.journal.hits
    counts = Counter({int(i): int(hits[i]) for i in np.flatnonzero(hits)})
    return NoPath(counts, int(search.state[places.SPENT]))


def shortened(
    waypoints: ArrayLike, space: FreeSpace, key: Key, attempts: int, *, patience: int | None = None
) -> Array:
    """A path (m, n) with the same ends that is no longer (L2) and whose segments are all proven free.

    Args:
        waypoints: (k, n), each segment proven free.
        space: what the path avoids and keeps.
        key: the key of the random numbers; attempt i depends on (key, i) and the path before it only.
        attempts: the number of pairs of points to try.
        patience: the number of attempts in a row that may fail; None for no limit.
    """
    path = np.array(waypoints, np.float64)
    if len(path) < 3 or attempts < 1:
        return path
    search = _Search(space, path.shape[1], _effort(0, 1, attempts, patience), room=max(ROOM, len(path)))
    grown, state = search.grown, search.state
    grown.path[0, : len(path)] = grown.path[2, : len(path)] = path
    grown.flags[0, : len(path)] = 1
    state[places.PATH] = state[places.SAFE] = len(path)
    state[places.PHASE] = places.CUT
    found = search.run(path[0], path[0], key)
    assert found is not None
    return found


def _effort(samples: int, restart: int, attempts: int, patience: int | None) -> Effort:
    enough = attempts + 1 if patience is None else patience
    return Effort(
        batch=BATCH,
        samples=samples,
        restart=restart,
        extension=MAX_EXTENSION,
        spacing=CHECK_SPACING,
        step=MAX_CONSTRAINED_STEP,
        attempts=attempts,
        patience=enough,
        least=LEAST_EXTENSION,
        wide=WIDE,
        near=NEAR,
    )


class _Search:
    """The arrays of one search, and the calls of its kernel."""

    def __init__(self, space: FreeSpace, size: int, effort: Effort, room: int = ROOM) -> None:
        self.space, self.size, self.effort, self.grown = space, size, effort, _room(room, size)
        self.kept = _kept(space.kept)
        self.state = np.zeros(places.STATE_PLACES, np.int64)
        self.state[places.PROJECTS] = space.kept is not None and space.projects
        self.state[places.CONSTRAINT] = space.pairs
        self.state[places.LOOKS] = space.configurations is not None
        self.journal = Journal(
            self.state,
            np.zeros(space.pairs + 1, np.int64),
            np.zeros(4096, np.int64),
            np.zeros(ANSWERS, np.int64),
            np.zeros((2, size)),
            np.zeros((4, size)),
        )

    def run(self, low: Array, high: Array, key: Key) -> Array | None:
        """The way points of the path that is found, or None."""
        while True:
            self.space.look()
            checks = self.space.checks()
            self.state[places.FREE_COUNTS] = checks is not None and checks.free_counts
            self.state[places.HIT_COUNTS] = checks is not None and checks.hit_counts
            arrays = _nothing() if checks is None else checks
            space = Space(*(arrays.memory, *arrays.sweep, self.kept))
            outcome: int = run(low, high, np.uint64(key), self.effort, space, self.grown, self.journal)
            if outcome == places.FOUND:
                path: Array = self.grown.path[0, : self.state[places.PATH]].copy()
                return path
            if outcome == places.BLOCKED:
                return None
            if outcome == places.FULL:
                self.grown = _larger(self.grown)
            elif outcome == places.ASK:
                self._answer(checks)

    def _answer(self, checks: KernelChecks | None) -> None:
        """Writes the answer to the question in the journal."""
        place, (a, b) = self.state[places.ANSWERED], self.journal.question.copy()
        if place == len(self.journal.answers):
            longer = np.concatenate([self.journal.answers, np.zeros(place, np.int64)])
            self.journal = self.journal._replace(answers=longer)
        look = self.space.configurations if checks is None else checks.configurations_hit
        proof = self.space.segment if checks is None else checks.segment_hit
        if self.state[places.KIND] == places.LOOK:
            assert look is not None
            answer = _looked(a, b, look)
        else:
            answer = proof(a, b)
        self.journal.answers[place] = answer
        self.state[places.ANSWERED] = place + 1


def _looked(a: Array, b: Array, configurations: FreeConfigurations) -> int:
    """The first pair hit at configurations of an edge, or -1, in the kernel's order, a call for each level."""
    pieces, count = int(np.ceil(np.linalg.norm(b - a) / CHECK_SPACING)), 1
    found = configurations(b[None])
    while found.max() < 0 and count < pieces:
        shares = (np.arange(count) + 0.5) / count
        found = configurations(a + shares[:, None] * (b - a))
        count *= 2
    hits = found[found >= 0]
    return int(hits[0]) if len(hits) else -1


def _room(count: int, size: int) -> Grown:
    return Grown(
        np.zeros((2, count, size)),
        np.zeros((2, size, count)),
        np.zeros(count),
        np.zeros((2, count), np.int64),
        np.zeros((3, 2 * count, size)),
        np.zeros((2, 2 * count), np.int64),
        np.zeros(2 * count),
    )


def _larger(grown: Grown) -> Grown:
    """The same with twice the room."""
    larger = _room(2 * len(grown.away), grown.nodes.shape[2])
    for array, old in zip(larger, grown, strict=True):
        array[tuple(slice(0, length) for length in old.shape)] = old
    return larger


def _kept(rows: KeptRows | None) -> Kept:
    """The constraint for kernels; without one no rows."""
    if rows is None:
        return _free()
    return Kept(rows.rows, rows.tolerances, rows.tree, rows.pieces, rows.pull, rows.iterations, rows.policy)


@cache
def _free() -> Kept:
    """No constraint: no rows."""
    return _kept(KeptRows.of(_still(), np.empty((0, columns.WIDTH)), [True], 0.0))


@cache
def _still() -> KinematicTree:
    """A tree of one joint, where no tree is needed."""
    whole, one = np.zeros(2, np.int64), np.ones(1)
    placement = np.tile([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (2, 1))
    return KinematicTree(whole, whole, whole, np.array([0.0, 1.0]), np.zeros(2), placement, -one, one, one)


@cache
def _nothing() -> KernelChecks:
    """Checks of no bodies: arrays of the right types, for kernels that ask Python everything."""
    nothing: Sequence[Any] = ()
    view = CollisionView(_still(), nothing, nothing, np.empty((0, 2), np.int64), Budget.share(0.01))
    return view.kernel_checks
