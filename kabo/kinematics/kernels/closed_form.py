"""Closed-form inverse kinematics of many poses: solves a chain's form, confirms and refines the solutions.

Every solution is confirmed by forward kinematics of the tree; errors from rounding, or from a robot file with few
decimals, are removed by a Gauss-Newton step.
"""

import numpy as np

from kabo.compilation import kernel, lean_kernel
from kabo.kinematics.kernels.forms import (
    SPHERICAL,
    THREE_PARALLEL,
    moved_direction,
    solve_five,
    solve_spherical,
    solve_three_parallel,
)
from kabo.kinematics.kernels.subproblems import carried, cross, direction, origin, turned
from kabo.scene.kernels.poses import forward_kinematics

MAX_SOLUTIONS = 8  # of one pose
FREE_TURN_VALUES = 16  # values tried for a free joint, until one gives a solution within limits
LIMIT_ROUNDING = 1e-7  # [rad] outside a limit: such values are set to the limit
REFINABLE_EXCESS = 1e-4  # [rad] outside a limit: refinement may correct this much
POSE_TOLERANCE = 1e-9  # of every entry of the pose that a solution reaches


@lean_kernel  # (12,) f8, (12,) f8 -> writes (12,) f8
def motion_between(start, end, motion):
    """Writes the rigid motion, in the world frame, from one pose to another: end · start^-1."""
    for r in range(3):
        for c in range(3):
            motion[3 * r + c] = (
                end[3 * r] * start[3 * c] + end[3 * r + 1] * start[3 * c + 1] + end[3 * r + 2] * start[3 * c + 2]
            )
    p = moved_direction(motion, (start[9], start[10], start[11]))
    for r in range(3):
        motion[9 + r] = end[9 + r] - p[r]


@lean_kernel  # (m, 6) f8, i8, f8, i8, bool -> writes (k, 6) f8
def chain_with_lock(axes, lock, value, backwards, chain):
    """Writes all axes of a chain but the locked axis, whose rotation by `value` moves the axes behind it.

    The order is from the base to the end; if `backwards`, from the end to the base.
    """
    last, number = chain.shape[0] - 1, 0
    for j in range(axes.shape[0]):
        if j == lock:
            continue
        at = last - number if backwards else number
        z, p = direction(axes[j]), origin(axes[j])
        if 0 <= lock < j:
            z, p = turned(direction(axes[lock]), value, z), carried(axes[lock], value, p)
        for k in range(3):
            chain[at, k], chain[at, 3 + k] = -z[k] if backwards else z[k], p[k]
        number += 1


@lean_kernel  # (12,) f8 x 2, (m, 6) f8, i8, f8, bool -> writes (12,) f8 x 2
def motion_of_chain(goal, zero, axes, lock, value, backwards, moved, motion):
    """Writes the rigid motion that the rotations of a chain must have as their product."""
    if lock >= 0:
        h = direction(axes[lock])
        for c in range(3):
            column = turned(h, value, (zero[c], zero[3 + c], zero[6 + c]))
            moved[c], moved[3 + c], moved[6 + c] = column
        moved[9], moved[10], moved[11] = carried(axes[lock], value, (zero[9], zero[10], zero[11]))
    else:
        for k in range(12):
            moved[k] = zero[k]
    if backwards:
        motion_between(goal, moved, motion)
    else:
        motion_between(moved, goal, motion)


@lean_kernel  # (n,) f8, (m,) i8, (J,) i8, (n,) f8 x 2 -> f8, i8; writes q
def outside(q, joints, source, lower, upper):
    """Moves each angle by whole turns towards the middle of its limits; returns the largest excess [rad] and its axis."""
    worst, fault = 0.0, -1
    for a in range(joints.shape[0]):
        k = source[joints[a]]
        value, low, high = q[k], lower[k], upper[k]
        value += 2.0 * np.pi * np.round((0.5 * (low + high) - value) / (2.0 * np.pi))
        beyond = max(low - value, value - high)
        if beyond <= LIMIT_ROUNDING:
            value = min(max(value, low), high)
        elif beyond > worst:
            worst, fault = beyond, a
        q[k] = value
    return worst, fault


@lean_kernel  # (n,) f8, (12,) f8, (J, 12) f8, i8, tree x 6 -> f8
def miss(q, goal, world_T, joint, parent, kind, source, ratio, shift, placement):
    """The largest absolute difference between entries of the goal and of the pose at q by forward kinematics."""
    forward_kinematics(q, parent, kind, source, ratio, shift, placement, world_T)
    worst = 0.0
    for k in range(12):
        worst = max(worst, abs(world_T[joint, k] - goal[k]))
    return worst


@lean_kernel  # (m, 6) f8, (m + 1) x m work -> bool; writes step (m,) f8
def solved_step(system, step):
    """Solves a small linear system (m, m + 1) by Gaussian elimination with pivoting; False if it is singular."""
    m = system.shape[0]
    for i in range(m):
        best = i
        for r in range(i + 1, m):
            if abs(system[r, i]) > abs(system[best, i]):
                best = r
        if abs(system[best, i]) < 1e-300:
            return False
        for c in range(i, m + 1):
            system[i, c], system[best, c] = system[best, c], system[i, c]
        for r in range(i + 1, m):
            factor = system[r, i] / system[i, i]
            for c in range(i, m + 1):
                system[r, c] -= factor * system[i, c]
    for i in range(m - 1, -1, -1):
        rest = system[i, m]
        for c in range(i + 1, m):
            rest -= system[i, c] * step[c]
        step[i] = rest / system[i, i]
    return True


@lean_kernel  # (n,) f8, (12,) f8, (J, 12) f8, (m,) i8, (m, 7) f8 x 2, i8, i8, ratio -> writes q
def refine(q, goal, world_T, joints, columns, system, lock, joint, source, ratio):
    """Applies one Gauss-Newton step to q, from the poses in world_T, which removes rounding errors."""
    m = joints.shape[0]
    turn = (
        0.5 * antisymmetric(goal, world_T[joint], 2, 1),
        0.5 * antisymmetric(goal, world_T[joint], 0, 2),
        0.5 * antisymmetric(goal, world_T[joint], 1, 0),
    )
    for i in range(m):
        j = joints[i]
        h = world_T[j, 2], world_T[j, 5], world_T[j, 8]
        arm = between(world_T, joint, j)
        p = cross(h, arm)
        for k in range(3):
            columns[i, k], columns[i, 3 + k] = p[k], h[k]
    for i in range(m):
        for c in range(m):
            system[i, c] = 0.0
            for k in range(6):
                system[i, c] += columns[i, k] * columns[c, k]
        system[i, i] += 1e-13 if i != lock else 1e12
        system[i, m] = 0.0
        for k in range(3):
            system[i, m] += columns[i, k] * (goal[9 + k] - world_T[joint, 9 + k]) + columns[i, 3 + k] * turn[k]
    step = columns[:, 6]
    if solved_step(system[:, : m + 1], step):
        for i in range(m):
            q[source[joints[i]]] += step[i] / ratio[joints[i]]


@lean_kernel  # (12,) f8 x 2, i8, i8 -> f8
def antisymmetric(goal, at, r, c):
    """Entry (r, c) minus entry (c, r) of the matrix product goal · at^T of two rotations."""
    a = goal[3 * r] * at[3 * c] + goal[3 * r + 1] * at[3 * c + 1] + goal[3 * r + 2] * at[3 * c + 2]
    b = goal[3 * c] * at[3 * r] + goal[3 * c + 1] * at[3 * r + 1] + goal[3 * c + 2] * at[3 * r + 2]
    return a - b


@lean_kernel  # (J, 12) f8, i8, i8 -> vector
def between(world_T, a, b):
    """The vector from the origin of joint b to that of joint a."""
    return world_T[a, 9] - world_T[b, 9], world_T[a, 10] - world_T[b, 10], world_T[a, 11] - world_T[b, 11]


@lean_kernel  # (n,) f8, (M, n) f8, i8 -> bool
def is_known(q, found, count):
    """Whether a configuration is among the first `count` rows of `found`, which occurs where two branches meet."""
    for i in range(count):
        worst = 0.0
        for k in range(q.shape[0]):
            worst = max(worst, abs(q[k] - found[i, k]))
        if worst <= 1e-7:
            return True
    return False


@lean_kernel  # (k,) f8, bool, i8, (m,) i8, (J,) x 3, (n,) f8 -> writes q
def write_turns(turns, backwards, lock, joints, source, ratio, shift, q):
    """Writes the joint values of a solution into q; the locked joint keeps its value."""
    used, count = 0, joints.shape[0] - (1 if lock >= 0 else 0)
    for a in range(joints.shape[0]):
        if a != lock:
            j = joints[a]
            q[source[j]] = (turns[count - 1 - used if backwards else used] - shift[j]) / ratio[j]
            used += 1


@lean_kernel  # (n,), (12,), work x 3, i8, (m,) i8, (n,) x 2, tree x 6 -> f8, i8, f8; writes q
def settle(
    q,
    goal,
    world_T,
    columns,
    system,
    lock,
    joints,
    lower,
    upper,
    parent,
    kind,
    source,
    ratio,
    shift,
    placement,
):
    """Brings a solution within limits and refines it; returns its excess, the axis at fault, and its pose error."""
    end = joints[joints.shape[0] - 1]
    worst, fault = outside(q, joints, source, lower, upper)
    if worst > REFINABLE_EXCESS:
        return worst, fault, np.inf
    error = miss(q, goal, world_T, end, parent, kind, source, ratio, shift, placement)
    for _ in range(4):
        if error <= 1e-12 or error > 1e-3:
            break
        refine(q, goal, world_T, joints, columns, system, lock, end, source, ratio)
        worst, fault = outside(q, joints, source, lower, upper)
        error = miss(q, goal, world_T, end, parent, kind, source, ratio, shift, placement)
    return worst, fault, error


@kernel  # (n,) f8, i8, i8, f8 -> writes (n,) f8
def begin(base, lock, held, value, q):
    """Writes the values of joints outside the chain, and of the locked joint if there is one."""
    for j in range(q.shape[0]):
        q[j] = base[j]
    if lock >= 0:
        q[held] = value


@kernel  # (N, 12), (N,), (n,), i8 x 2, bool x 2, i8, (m, 6), (12,), (m,) i8, (n,) x 2, tree x 6 -> writes the last four
def solve_poses(
    goals, locked, base, form, placing, mirrored, backwards, lock, axes, zero, joints, lower, upper,
    parent, kind, source, ratio, shift, placement, found, counts, free, short,
):  # fmt: skip
    """Writes the configurations (N, MAX_SOLUTIONS, n) that bring the last joint to each pose; pose i has `counts[i]`.

    `base` has the values of joints outside the chain, `locked` the value of the locked joint for each pose. `free`
    receives the singularities of each solution as bits. `short` (N, 4) receives why a pose has no solution:
    missing length [m], tilt [rad], the least excess of limits [rad], and the index of the axis with this excess.
    """
    m, hold = axes.shape[0], joints[max(lock, 0)]
    chain = np.empty((m - 1 if lock >= 0 else m, 6))
    triples, swapped = np.empty((4, 3)), np.empty((3, 6))
    turns, marks = np.empty((MAX_SOLUTIONS, 6)), np.empty(MAX_SOLUTIONS, np.int64)
    moved, motion, q = np.empty(12), np.empty(12), base.copy()
    columns, system, world_T = np.empty((m, 7)), np.empty((m, m + 1)), np.zeros((parent.shape[0], 12))
    world_T[0, 0], world_T[0, 4], world_T[0, 8] = 1.0, 1.0, 1.0
    tree = parent, kind, source, ratio, shift, placement
    for i in range(goals.shape[0]):
        held, tilt = ratio[hold] * locked[i] + shift[hold], 0.0
        chain_with_lock(axes, lock, held, backwards, chain)
        motion_of_chain(goals[i], zero, axes, lock, held, backwards, moved, motion)
        short[i, 2], short[i, 3], counts[i] = np.inf, -1.0, 0
        for trial in range(FREE_TURN_VALUES):
            spare = 2.0 * np.pi * trial / FREE_TURN_VALUES
            if form == SPHERICAL:
                number, singular, missing = solve_spherical(
                    chain, motion, placing, mirrored, triples, swapped, turns, marks, spare
                )
            elif form == THREE_PARALLEL:
                number, singular, missing = solve_three_parallel(chain, motion, turns, marks, spare)
            else:
                number, singular, missing, tilt = solve_five(chain, motion, turns, marks, spare)
            if trial == 0:
                short[i, 0], short[i, 1] = missing, tilt
            for s in range(number):
                begin(base, lock, source[hold], locked[i], q)
                write_turns(turns[s], backwards, lock, joints, source, ratio, shift, q)
                worst, fault, error = settle(
                    q, goals[i], world_T, columns, system, lock, joints, lower, upper, *tree
                )
                if worst > 0.0:
                    if worst < short[i, 2]:
                        short[i, 2], short[i, 3] = worst, fault
                elif error <= POSE_TOLERANCE and not is_known(q, found[i], counts[i]):
                    found[i, counts[i]], free[i, counts[i]] = q, marks[s]
                    counts[i] += 1
            if singular == 0 or counts[i] > 0:
                break


@kernel  # (N, n) f8, i8, tree x 6 -> (N, 12) f8
def poses_of(Q, joint, parent, kind, source, ratio, shift, placement):
    """The poses (N, 12) of one joint in the world at every configuration."""
    world_T = np.zeros((parent.shape[0], 12))
    world_T[0, 0], world_T[0, 4], world_T[0, 8] = 1.0, 1.0, 1.0
    poses = np.empty((Q.shape[0], 12))
    for i in range(Q.shape[0]):
        forward_kinematics(Q[i], parent, kind, source, ratio, shift, placement, world_T)
        poses[i] = world_T[joint]
    return poses
