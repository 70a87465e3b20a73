"""Projection of many seeds onto constraint rows in one call, with random aims inside intervals and repeated seeds."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array
from kabo.compilation import kernel, lean_kernel
from kabo.kinematics.kernels.descent import ARRIVED, FREEZES, LOST, RETURNS, WRAPS, Target, Work, descend, scratch
from kabo.kinematics.kernels.rows import FIRST, LOWER, SECOND, UPPER, differentiate, evaluate, find_signs
from kabo.kinematics.kernels.streams import stratified, uniform
from kabo.scene.kernels.poses import forward_kinematics
from kabo.scene.tree import KinematicTree

__all__ = ["FREEZES", "RETURNS", "WRAPS", "descend", "project_seeds", "row_jacobian", "row_values", "scratch"]

AIM_ITERATIONS = 20  # for each try to reach the aims; successful tries need about ten


class Wanted(NamedTuple):
    """The rows that seeds are projected onto."""

    rows: Array  # (R, W)
    required: int  # the rows before this one must hold; the others only have aims
    aims: Array  # (N, R) the value that each seed aims at inside an interval; NaN for none
    inset: float  # how far inside a violated interval the projection aims [m or rad]


class Rule(NamedTuple):
    """How long and how often seeds are projected, and what happens at limits."""

    iterations: int
    policy: int  # WRAPS, FREEZES, RETURNS
    key: np.uint64  # of the stream from which further seeds are drawn
    first: int  # the number of the first seed in the stream
    tries: int  # seeds for one sample, while it misses its aims


@kernel  # (R, W) f8, KinematicTree -> (R, W) f8, KinematicTree of the joints that the rows depend on
def restricted(rows, tree):
    """The rows and the tree without joints that no row depends on (grippers, other branches)."""
    parent, kind, source, ratio, shift, placement, lower, upper, velocity = tree
    joints = parent.shape[0]
    number = np.full(joints, -1, np.int64)
    number[0] = 0
    for i in range(rows.shape[0]):
        for column in (FIRST, SECOND):
            j = int(rows[i, column])
            while j > 0 and number[j] < 0:
                number[j] = 1
                j = parent[j]
    count = 0
    kept = np.empty(joints, np.int64)
    for j in range(joints):
        if number[j] >= 0:
            kept[count], number[j] = j, count
            count += 1
    less = rows.copy()
    for i in range(rows.shape[0]):
        less[i, FIRST], less[i, SECOND] = number[int(rows[i, FIRST])], number[int(rows[i, SECOND])]
    parents, kinds, sources = np.zeros(count, np.int64), np.zeros(count, np.int64), np.zeros(count, np.int64)
    ratios, shifts, placements = np.zeros(count), np.zeros(count), np.zeros((count, 12))
    for k in range(1, count):
        j = kept[k]
        parents[k], kinds[k], sources[k], ratios[k], shifts[k] = (
            number[parent[j]],
            kind[j],
            source[j],
            ratio[j],
            shift[j],
        )
        for c in range(12):
            placements[k, c] = placement[j, c]
    return less, KinematicTree(parents, kinds, sources, ratios, shifts, placements, lower, upper, velocity)


@kernel  # i8, (J,) i8, (J,) i8, (J,) f8 -> (n,) bool
def find_turning(size, kind, source, ratio):
    """Marks the values of q that may change by whole turns: those that drive only revolute joints, with ratio 1."""
    turning = np.zeros(size, np.bool_)
    for j in range(1, kind.shape[0]):
        turning[source[j]] = True
    for j in range(1, kind.shape[0]):
        if kind[j] != 0 or abs(ratio[j]) != 1.0:
            turning[source[j]] = False
    return turning


@lean_kernel  # (W,) f8 -> bool
def is_interval(row):
    """Whether the row may take any value between two different bounds, so that samples can aim at values inside."""
    return row[LOWER] < row[UPPER] and row[UPPER] - row[LOWER] < np.inf


@lean_kernel  # u8, i8, (R, W) f8, (N, R) f8 -> writes aims
def draw_aims(key, first, rows, aims):
    """Writes an aim inside each interval, evenly spread over samples from `first` on; NaN for rows without one."""
    intervals = 0
    for i in range(rows.shape[0]):
        intervals += 1 if is_interval(rows[i]) else 0
    number = 0
    for i in range(rows.shape[0]):
        for k in range(aims.shape[0]):
            aims[k, i] = np.nan
        if is_interval(rows[i]):
            for k in range(aims.shape[0]):
                share = stratified(key, first + k, number, intervals)
                aims[k, i] = rows[i, LOWER] + share * (rows[i, UPPER] - rows[i, LOWER])
            number += 1


@lean_kernel  # (R, W) f8, i8, (R,) f8, f8, Target -> bool; writes target
def set_bounds(rows, required, aims, inset, target):
    """Writes the interval that one descent aims at for each constraint row; returns whether any row has an aim.

    A row with an aim (a value, NaN for none) gets that value as both bounds, any other row its own bounds; from
    row `required` on, rows without an aim are unbounded. The rows of the target receive these bounds, `low` and
    `high` the same bounds moved inwards by `inset`, at most to the middle.
    """
    aimed, low, high = target.rows, target.low, target.high
    any_aim = False
    for i in range(rows.shape[0]):
        aimed[i, LOWER], aimed[i, UPPER] = rows[i, LOWER], rows[i, UPPER]
        if aims[i] == aims[i]:
            aimed[i, LOWER], aimed[i, UPPER] = aims[i], aims[i]
            any_aim = True
        elif i >= required:
            aimed[i, LOWER], aimed[i, UPPER] = -np.inf, np.inf
        shift = min(inset, 0.5 * (aimed[i, UPPER] - aimed[i, LOWER]))
        low[i], high[i] = aimed[i, LOWER] + shift, aimed[i, UPPER] - shift
    return any_aim


@kernel  # u8, i8, i8, (n,) f8 x 2, (n,) bool, (n,) f8 -> writes q
def draw_again(key, index, attempt, lower, upper, active, q):
    """Writes the seed of attempt 1, 2 … for a sample (`streams.draw` gives attempt 0); unbounded joints span one turn."""
    for j in range(q.shape[0]):
        if active[j]:
            low = lower[j] if lower[j] > -np.inf else -np.pi
            high = upper[j] if upper[j] < np.inf else np.pi
            q[j] = low + uniform(key, index, attempt * q.shape[0] + j) * (high - low)


@lean_kernel  # (n,) f8, (n,) bool -> writes (n,) f8, (n,) bool
def keep(q, active, kept, free):
    """Copies values and a mask in a loop, since numba takes seconds to compile assigned slices."""
    for j in range(q.shape[0]):
        kept[j], free[j] = q[j], active[j]


@kernel  # (N, n) f8, (N,) bool, Wanted, KinematicTree with the limits to keep, (n,) bool, Rule -> writes Q, succeeded
def project_seeds(Q, succeeded, wanted, tree, active, rule):
    """Projects each row of Q in place; writes whether it succeeded: the required rows hold and q is within limits.

    Row i is sample `rule.first` + i of the stream `rule.key`. Its aims are tried from up to `rule.tries` seeds: first
    Q[i], then seeds from the stream. If all tries fail, the result is the projection of Q[i] onto the bounds without
    aims; if this projection does not fulfil the rows even outside the limits, only the first try is made.
    """
    aims, inset, required = wanted.aims, wanted.inset, wanted.required
    iterations, policy, lower, upper = rule.iterations, rule.policy, tree.lower, tree.upper
    turning = find_turning(Q.shape[1], tree.kind, tree.source, tree.ratio)
    rows, less = restricted(wanted.rows, tree)
    signs = np.zeros((rows.shape[0], less.parent.shape[0]))
    find_signs(rows, less.parent, less.ratio, signs)
    work, seed = scratch(rows.shape[0], less.parent.shape[0], Q.shape[1]), np.empty(Q.shape[1])
    free, no_aims = active.copy(), np.full(rows.shape[0], np.nan)
    target = Target(rows.copy(), np.empty(rows.shape[0]), np.empty(rows.shape[0]), signs)
    spare = np.empty(Q.shape[1])
    for i in range(Q.shape[0]):
        q, reached, spared = Q[i], LOST, LOST
        aiming = set_bounds(rows, required, aims[i], inset, target)
        for attempt in range(rule.tries if aiming else 1):
            if attempt > 0:
                draw_again(rule.key, rule.first + i, attempt, lower, upper, active, q)
            keep(q, active, seed, free)
            budget = AIM_ITERATIONS if aiming else iterations
            reached = descend(q, seed, free, turning, target, less, work, budget, policy)
            if reached == ARRIVED or not aiming:
                break
            if attempt == 0:
                keep(seed, active, spare, free)
                set_bounds(rows, required, no_aims, inset, target)
                spared = descend(spare, seed, free, turning, target, less, work, iterations, policy)
                if spared == LOST:
                    break
                set_bounds(rows, required, aims[i], inset, target)
        if reached != ARRIVED and spared == ARRIVED:
            keep(spare, active, q, free)
        succeeded[i] = reached == ARRIVED or spared == ARRIVED


class Pull(NamedTuple):
    """What one projection without aims needs, made once: the rows, the joints they depend on, and scratch arrays."""

    target: Target
    tree: KinematicTree
    active: NDArray[np.bool_]
    turning: NDArray[np.bool_]
    work: Work
    seed: Array  # (n,)
    free: NDArray[np.bool_]  # (n,)


@kernel  # (R, W) f8, f8, KinematicTree with the limits to keep, (n,) bool -> Pull
def pull_of(rows, inset, tree, active):
    """Allocates what `pulled` needs."""
    size = active.shape[0]
    turning = find_turning(size, tree.kind, tree.source, tree.ratio)
    given, less = restricted(rows, tree)
    signs = np.zeros((given.shape[0], less.parent.shape[0]))
    find_signs(given, less.parent, less.ratio, signs)
    work = scratch(given.shape[0], less.parent.shape[0], size)
    target = Target(given.copy(), np.empty(given.shape[0]), np.empty(given.shape[0]), signs)
    set_bounds(given, given.shape[0], np.full(given.shape[0], np.nan), inset, target)
    return Pull(target, less, active, turning, work, np.empty(size), active.copy())


@lean_kernel  # (n,) f8, Pull, i8, i8 -> bool; writes q
def pulled(q, pull, iterations, policy):
    """Projects q onto the rows as `project_seeds` does without aims; returns whether it succeeded."""
    for j in range(q.shape[0]):
        pull.seed[j], pull.free[j] = q[j], pull.active[j]
    reached = descend(q, pull.seed, pull.free, pull.turning, pull.target, pull.tree, pull.work, iterations, policy)
    return reached == ARRIVED


@kernel  # (n,) f8, (R, W) f8, KinematicTree -> (R,) f8
def row_values(q, rows, tree):
    """The value of every row at q, in the unit of the row."""
    work = scratch(rows.shape[0], tree.parent.shape[0], q.shape[0])
    forward_kinematics(
        q, tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement, work.world_T
    )
    evaluate(rows, work.world_T, work.values, work.wrenches)
    return work.values


@kernel  # (n,) f8, (R, W) f8, KinematicTree -> (R, n) f8
def row_jacobian(q, rows, tree):
    """The derivative of every row by every value of q, in the unit of the row."""
    work = scratch(rows.shape[0], tree.parent.shape[0], q.shape[0])
    signs = np.zeros((rows.shape[0], tree.parent.shape[0]))
    find_signs(rows, tree.parent, tree.ratio, signs)
    forward_kinematics(
        q, tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement, work.world_T
    )
    evaluate(rows, work.world_T, work.values, work.wrenches)
    differentiate(
        work.wrenches, work.held, rows.shape[0], signs, tree.kind, tree.source, work.world_T, work.jacobian
    )
    return work.jacobian
