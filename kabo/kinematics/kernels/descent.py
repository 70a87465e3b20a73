"""One descent onto constraint rows: damped Gauss-Newton with a capped step [K Algorithm 3].

Differences from the thesis, with reasons [docs/decisions/001-kernels.md]: Jacobians are analytic; the damping
vanishes with the error instead of a pseudo-inverse that jumps; the step is capped, since full steps end outside
the limits; a joint that nevertheless ends outside its limits returns to its seed, and the other joints compensate.
"""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.compilation import kernel, lean_kernel
from kabo.kinematics.kernels.rows import LOWER, SCALE, TOLERANCE, UPPER, differentiate, evaluate
from kabo.scene.kernels.poses import forward_kinematics

MAX_STEP = 0.5  # [rad or m] of a joint in one iteration
BASE_DAMPING, DAMPING = 1e-9, 1e-3  # lambda = base + damping * min(|F|^2, 1) [m^2]
# What to do with a joint outside its limits: whole turns back; then hold it at the limit, or at its seed.
WRAPS, FREEZES, RETURNS = 1, 2, 4
LOST, OUTSIDE, ARRIVED = 0, 1, 2  # how far a seed got
EXTRA_ITERATIONS = 8  # for the other joints, each time that some were returned to their seed


class Target(NamedTuple):
    """What one descent aims at: rows with their bounds, the bounds moved inwards, and the joints that move the rows."""

    rows: Array  # (R, W)
    low: Array  # (R,) inner bounds: a violated row aims at the nearer one
    high: Array  # (R,)
    signs: Array  # (R, J) from `find_signs`


class Work(NamedTuple):
    """The scratch arrays of `descend`."""

    world_T: Array  # (J, 12)  # noqa: N815
    values: Array  # (R,)
    wrenches: Array  # (R, 6)
    held: Integers  # (R,)
    residuals: Array  # (R,)
    jacobian: Array  # (R, n)
    factor: Array  # (R, R)
    steps: Array  # (n,)


@kernel  # i8, i8, i8 -> Work
def scratch(rows, joints, size):
    """Allocates the scratch arrays of `descend` for the given numbers of rows, joints and values of q."""
    world_T = np.zeros((joints, 12))
    world_T[0, 0], world_T[0, 4], world_T[0, 8] = 1.0, 1.0, 1.0
    return Work(
        world_T,
        np.empty(rows),
        np.empty((rows, 6)),
        np.arange(rows),
        np.empty(rows),
        np.zeros((rows, size)),
        np.empty((rows, rows)),
        np.empty(size),
    )


@lean_kernel  # Target, (R,) f8, (R,) i8, (R,) f8 -> bool, f8, i8; writes held and residuals
def find_residuals(target, values, held, residuals):
    """Writes which rows are active, and the distance of each active row from its inner bounds [m].

    A row is inactive inside its interval; outside it aims at the inner bounds. Returns whether all rows are
    fulfilled, the sum of squares, and the number of active rows.
    """
    rows, inner_lower, inner_upper = target.rows, target.low, target.high
    fulfilled, square, count = True, 0.0, 0
    for i in range(rows.shape[0]):
        value, low, high = values[i], rows[i, LOWER], rows[i, UPPER]
        if low < high and low <= value <= high:
            continue
        if not (low - rows[i, TOLERANCE] <= value <= high + rows[i, TOLERANCE]):
            fulfilled = False
        held[count] = i
        residuals[count] = rows[i, SCALE] * (value - min(max(value, inner_lower[i]), inner_upper[i]))
        square += residuals[count] * residuals[count]
        count += 1
    return fulfilled, square, count


@lean_kernel  # (R, n) f8, i8, (R,) f8, f8, (R, R) f8 -> writes residuals: (J J^T + damping I)^-1 residuals
def solve_damped(jacobian, rows, residuals, damping, factor):
    """Solves the damped normal equations of the first `rows` rows in place, by the factor L of L L^T."""
    for i in range(rows):
        for k in range(i + 1):
            total = damping if i == k else 0.0
            for j in range(jacobian.shape[1]):
                total += jacobian[i, j] * jacobian[k, j]
            for j in range(k):
                total -= factor[i, j] * factor[k, j]
            factor[i, k] = np.sqrt(max(total, 1e-16)) if i == k else total / factor[k, k]
    for i in range(rows):
        for j in range(i):
            residuals[i] -= factor[i, j] * residuals[j]
        residuals[i] /= factor[i, i]
    for i in range(rows - 1, -1, -1):
        for j in range(i + 1, rows):
            residuals[i] -= factor[j, i] * residuals[j]
        residuals[i] /= factor[i, i]


@lean_kernel  # (n,) f8, (R, n) f8, i8, (R,) f8, (n,) f8, f8 -> writes q and steps
def move(q, jacobian, rows, weights, steps, cap):
    """Takes the step -J^T weights, shortened so that no value changes by more than `cap`."""
    largest = 0.0
    for j in range(q.shape[0]):
        total = 0.0
        for i in range(rows):
            total += jacobian[i, j] * weights[i]
        steps[j] = total
        largest = max(largest, abs(total))
    share = 1.0 if largest <= cap else cap / largest
    for j in range(q.shape[0]):
        q[j] -= share * steps[j]


@lean_kernel  # (n,) f8 x 4, (n,) bool, (n,) bool, i8 -> bool, i8; writes q and free
def bring_within_limits(q, seed, lower, upper, free, turning, policy):
    """Adds whole turns to q; returns whether it is within its limits, and how many values are still free.

    A value outside its limits is set to the limit or to the seed's value, depending on `policy`, and is no longer
    free.
    """
    inside, count = True, 0
    for j in range(q.shape[0]):
        if not free[j]:
            continue
        if lower[j] <= q[j] <= upper[j]:
            count += 1
            continue
        if policy & WRAPS and turning[j]:
            if q[j] < lower[j]:
                q[j] += 2.0 * np.pi * np.ceil((lower[j] - q[j]) / (2.0 * np.pi))
            else:
                q[j] -= 2.0 * np.pi * np.ceil((q[j] - upper[j]) / (2.0 * np.pi))
        if lower[j] <= q[j] <= upper[j]:
            count += 1
            continue
        inside = False
        if policy & FREEZES:
            q[j] = min(max(q[j], lower[j]), upper[j])
            free[j] = False
        elif policy & RETURNS:
            q[j] = seed[j]
            free[j] = False
    return inside, count


@lean_kernel  # (n,) f8 x 2, (n,) bool x 2, Target, KinematicTree, Work, i8, i8 -> i8; writes q, free
def descend(q, seed, free, turning, target, tree, work, iterations, policy):
    """Moves q until every row holds within its own tolerance and q is within its limits; returns the outcome.

    The outcome is ARRIVED, OUTSIDE (all rows hold, but not within the limits) or LOST (the rows never held).

    Only values that are `free` move. Unless `policy` allows whole turns only, `free` is written: a value outside
    its limits stays at the limit (FREEZES) or returns to that of `seed` (RETURNS), and the others compensate.
    """
    parent, kind, source, ratio, shift, placement, lower, upper, _ = tree
    world_T, values, wrenches, held, residuals, jacobian, factor, steps = work
    rows, signs = target.rows, target.signs
    left, reached = iterations, LOST
    while left > 0:
        left -= 1
        forward_kinematics(q, parent, kind, source, ratio, shift, placement, world_T)
        evaluate(rows, world_T, values, wrenches)
        fulfilled, square, count = find_residuals(target, values, held, residuals)
        if fulfilled:
            inside, able = bring_within_limits(q, seed, lower, upper, free, turning, policy)
            if inside:
                return ARRIVED
            reached = OUTSIDE
            if policy & RETURNS and able > count:
                left = EXTRA_ITERATIONS
            elif not policy & FREEZES:
                return OUTSIDE
            continue
        for k in range(count):
            for c in range(6):
                wrenches[held[k], c] *= rows[held[k], SCALE]
        differentiate(wrenches, held, count, signs, kind, source, world_T, jacobian)
        for j in range(q.shape[0]):
            if not free[j]:
                for k in range(count):
                    jacobian[k, j] = 0.0
        solve_damped(jacobian, count, residuals, BASE_DAMPING + DAMPING * min(square, 1.0), factor)
        move(q, jacobian, count, residuals, steps, MAX_STEP)
    return reached
