"""Projection onto constraint rows: damped Gauss-Newton with a capped step, many seeds in one call [K Algorithm 3].

What differs from the thesis, and why [docs/decisions/001-kernels.md]: Jacobians are analytic; the damping vanishes
with the error instead of a pseudo-inverse that jumps; the step is capped, since full steps end outside the limits;
what ends outside all the same goes back to its seed, and the other joints make up for it.
"""

import numpy as np

from kabo.compilation import kernel, lean_kernel
from kabo.kinematics.kernels.rows import (
    FIRST,
    LOWER,
    SCALE,
    SECOND,
    TOLERANCE,
    UPPER,
    differentiate,
    evaluate,
    find_signs,
)
from kabo.kinematics.kernels.streams import stratified
from kabo.scene.kernels.poses import forward_kinematics

STEP = 0.5  # the largest change of a joint in one iteration [rad or m]
BASE_DAMPING, DAMPING = 1e-9, 1e-3  # lambda = base + damping * min(|F|^2, 1) [m^2]
# What to do with a joint outside its limits: whole turns back; then hold it at the limit, or at its seed.
WRAPS, FREEZES, RETURNS = 1, 2, 4
PATIENCE = 8  # iterations that the others have, each time joints were returned to their seed


@kernel  # (R, W) f8, tree -> (R, W) f8, tree of the joints that the rows depend on
def restricted(rows, parent, kind, source, ratio, shift, placement):
    """The rows and the tree without the joints that no row depends on (grippers, links beside)."""
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
    return less, (parents, kinds, sources, ratios, shifts, placements)


@kernel  # i8, (J,) i8, (J,) i8, (J,) f8 -> (n,) bool
def find_turning(size, kind, source, ratio):
    """Which values of q may change by whole turns: those that move revolute joints at full ratio only."""
    turning = np.zeros(size, np.bool_)
    for j in range(1, kind.shape[0]):
        turning[source[j]] = True
    for j in range(1, kind.shape[0]):
        if kind[j] != 0 or abs(ratio[j]) != 1.0:
            turning[source[j]] = False
    return turning


@kernel  # i8, i8, i8 -> tuple of arrays
def scratch(rows, joints, size):
    """The arrays that `descend` works in, for so many rows, joints and values of q."""
    world_T = np.zeros((joints, 12))
    world_T[0, 0], world_T[0, 4], world_T[0, 8] = 1.0, 1.0, 1.0
    return (
        world_T,
        np.empty(rows),
        np.empty((rows, 6)),
        np.arange(rows),
        np.empty(rows),
        np.zeros((rows, size)),
        np.empty((rows, rows)),
        np.empty(size),
    )


@lean_kernel  # (R, W) f8, (R,) f8 x 3, (R,) i8, (R,) f8 -> bool, f8, i8; writes held and residuals
def find_residuals(rows, values, inner_lower, inner_upper, held, residuals):
    """Writes which rows hold something, and how far each of those is from its inner bounds [m].

    A row is at rest inside an interval; outside it aims at the inner bounds. Answers whether all rows are fulfilled,
    the sum of squares, and how many rows hold something.
    """
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
    """Whether q is within its limits, after whole turns, and how many values are free then.

    As `policy` says, what is outside stops at its limit, or goes back to where it was in the seed, and is free no more.
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


@kernel  # (n,) f8 x 2, (R, W) f8, (R,) f8 x 2, (n,) f8 x 2, (n,) bool x 2, tuples, i8, i8 -> bool; writes q, free
def descend(
    q, seed, rows, inner_lower, inner_upper, lower, upper, free, turning, tree, signs, work, iterations, policy
):
    """Moves q until every row holds within its own tolerance and q is within its limits; whether it got there.

    Only values that are `free` move. Where `policy` is not content with whole turns, `free` is written: what came
    outside its limits stays at the limit (FREEZES) or where it was in `seed` (RETURNS), and the others make up for it.
    """
    parent, kind, source, ratio, shift, placement = tree
    world_T, values, wrenches, held, residuals, jacobian, factor, steps = work
    left = iterations
    while left > 0:
        left -= 1
        forward_kinematics(q, parent, kind, source, ratio, shift, placement, world_T)
        evaluate(rows, world_T, values, wrenches)
        fulfilled, square, count = find_residuals(rows, values, inner_lower, inner_upper, held, residuals)
        if fulfilled:
            inside, able = bring_within_limits(q, seed, lower, upper, free, turning, policy)
            if inside:
                return True
            if policy & RETURNS and able > count:
                left = PATIENCE
            elif not policy & FREEZES:
                return False
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
        move(q, jacobian, count, residuals, steps, STEP)
    return False


@lean_kernel  # (W,) f8 -> bool
def is_interval(row):
    """Whether the row may take any value between two bounds: what can be aimed at."""
    return row[LOWER] < row[UPPER] and row[UPPER] - row[LOWER] < np.inf


@lean_kernel  # u8, i8, (R, W) f8, (N, R) f8 -> writes aims
def draw_aims(key, first, rows, aims):
    """Writes a value inside each interval, evenly spread over samples from `first` on; NaN for no interval."""
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


@lean_kernel  # (R, W) f8, i8, (R,) f8, f8, i8 -> bool; writes aimed, low, high
def set_bounds(rows, required, aims, inset, aimed, low, high):
    """Writes the bounds that one descent works towards: of each row its aim if it has one, else its own, moved in.

    Rows from `required` on without an aim are at rest everywhere. Answers whether there is any aim.
    """
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


@kernel  # (N, n) f8, (N,) bool, (R, W) f8, i8, (N, R) f8, f8, (n,) f8 x 2, (n,) bool, tree x 6, i8, i8
def project_seeds(
    Q,
    succeeded,
    rows,
    required,
    aims,
    inset,
    lower,
    upper,
    active,
    parent,
    kind,
    source,
    ratio,
    shift,
    placement,
    iterations,
    policy,
):
    """Projects each line of Q in place, and writes whether it arrived: `rows[:required]` hold, q is within limits.

    What misses its aims is projected again with the bounds alone.
    """
    turning = find_turning(Q.shape[1], kind, source, ratio)
    rows, tree = restricted(rows, parent, kind, source, ratio, shift, placement)
    signs = np.zeros((rows.shape[0], tree[0].shape[0]))
    find_signs(rows, tree[0], tree[3], signs)
    work, seed = scratch(rows.shape[0], tree[0].shape[0], Q.shape[1]), np.empty(Q.shape[1])
    aimed, free, no_aims = rows.copy(), active.copy(), np.full(rows.shape[0], np.nan)
    low, high = np.empty(rows.shape[0]), np.empty(rows.shape[0])
    for i in range(Q.shape[0]):
        succeeded[i] = False
        for j in range(free.shape[0]):
            seed[j] = Q[i, j]
        for attempt in range(2):
            aiming = set_bounds(rows, required, aims[i] if attempt == 0 else no_aims, inset, aimed, low, high)
            for j in range(free.shape[0]):
                free[j] = active[j]
            succeeded[i] = descend(
                Q[i], seed, aimed, low, high, lower, upper, free, turning, tree, signs, work, iterations, policy
            )
            if succeeded[i] or not aiming:
                break


@kernel  # (n,) f8, (R, W) f8, tree x 6 -> (R,) f8
def row_values(q, rows, parent, kind, source, ratio, shift, placement):
    """The value of every row at q, in its own unit."""
    work = scratch(rows.shape[0], parent.shape[0], q.shape[0])
    forward_kinematics(q, parent, kind, source, ratio, shift, placement, work[0])
    evaluate(rows, work[0], work[1], work[2])
    return work[1]


@kernel  # (n,) f8, (R, W) f8, tree x 6 -> (R, n) f8
def row_jacobian(q, rows, parent, kind, source, ratio, shift, placement):
    """The derivative of every row by every value of q, in the row's own unit."""
    work = scratch(rows.shape[0], parent.shape[0], q.shape[0])
    signs = np.zeros((rows.shape[0], parent.shape[0]))
    find_signs(rows, parent, ratio, signs)
    forward_kinematics(q, parent, kind, source, ratio, shift, placement, work[0])
    evaluate(rows, work[0], work[1], work[2])
    differentiate(work[2], work[3], rows.shape[0], signs, kind, source, work[0], work[5])
    return work[5]
