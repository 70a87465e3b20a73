"""Closed-form inverse kinematics of many poses: solves a chain's form, confirms and refines the solutions.

Every solution is confirmed by forward kinematics of the tree; errors from rounding, or from a robot file with few
decimals, are removed by a Gauss-Newton step.
"""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.compilation import kernel, lean_kernel
from kabo.kinematics.kernels.forms import (
    HALF,
    MAX_SOLUTIONS,
    MIDDLE,
    SPHERICAL,
    THREE_PARALLEL,
    Solutions,
    moved_direction,
    solve_five,
    solve_spherical,
    solve_three_parallel,
)
from kabo.kinematics.kernels.subproblems import carried, cross, direction, origin, turned
from kabo.scene.kernels.poses import forward_kinematics

FREE_TURN_VALUES = 16  # values tried for a free joint, until one gives a solution within limits
LIMIT_ROUNDING = 1e-7  # [rad] outside a limit: such values are set to the limit
REFINABLE_EXCESS = 1e-4  # [rad] outside a limit: refinement may correct this much
POSE_TOLERANCE = 1e-9  # of every entry of the pose that a solution reaches


class Chain(NamedTuple):
    """An arm whose inverse kinematics has a closed form: the numbers of a `Structure` (kabo/scene/structure.py)."""

    form: int
    placing: int
    mirrored: bool
    backwards: bool
    lock: int  # the index of the locked axis, or -1
    axes: Array  # (m, 6)
    zero: Array  # (12,)
    joints: Integers  # (m,)


class Answers(NamedTuple):
    """What `solve_poses` writes for each of N poses."""

    found: Array  # (N, MAX_SOLUTIONS, n) configurations
    counts: Integers  # (N,) how many of them
    free: Integers  # (N, MAX_SOLUTIONS) singularities of each, as bits
    short: Array  # (N, 4) missing length [m], tilt [rad], least excess of limits [rad], index of the axis with this excess


class Room(NamedTuple):
    """The scratch arrays of a solution."""

    solutions: Solutions
    axes: Array  # (k, 6) of the solved axes, in the order of the form
    moved: Array  # (12,)
    motion: Array  # (12,)
    columns: Array  # (m, 7)
    system: Array  # (m, m + 1)
    world_T: Array  # (J, 12)  # noqa: N815


@kernel  # Chain, i8 -> Room
def room_for(chain, joints):
    """Allocates the scratch arrays for solutions of a chain in a tree of so many joints; every angle is admitted."""
    m = chain.axes.shape[0]
    windows, world_T = np.zeros((6, 2)), np.zeros((joints, 12))
    windows[:, HALF] = np.inf
    world_T[0, 0], world_T[0, 4], world_T[0, 8] = 1.0, 1.0, 1.0
    turns, free = np.empty((MAX_SOLUTIONS, 6)), np.empty(MAX_SOLUTIONS, np.int64)
    solutions = Solutions(turns, free, windows, np.empty((4, 3)), np.empty((3, 6)))
    axes = np.empty((m - 1 if chain.lock >= 0 else m, 6))
    return Room(solutions, axes, np.empty(12), np.empty(12), np.empty((m, 7)), np.empty((m, m + 1)), world_T)


@lean_kernel  # Chain, KinematicTree, (6, 2) f8 -> writes windows
def set_windows(chain, tree, windows):
    """Writes the windows that the limits leave the angle of each solved axis, in the order of the form."""
    count, used = chain.joints.shape[0] - (1 if chain.lock >= 0 else 0), 0
    for a in range(chain.joints.shape[0]):
        if a != chain.lock:
            j = chain.joints[a]
            k = tree.source[j]
            at = count - 1 - used if chain.backwards else used
            windows[at, MIDDLE] = tree.ratio[j] * 0.5 * (tree.lower[k] + tree.upper[k]) + tree.shift[j]
            windows[at, HALF] = 0.5 * abs(tree.ratio[j]) * (tree.upper[k] - tree.lower[k]) + LIMIT_ROUNDING
            used += 1


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


@lean_kernel  # (n,) f8, (12,) f8, (J, 12) f8, i8, KinematicTree -> f8
def miss(q, goal, world_T, joint, tree):
    """The largest absolute difference between entries of the goal and of the pose at q by forward kinematics."""
    forward_kinematics(q, tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement, world_T)
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


@lean_kernel  # (n,) f8, (12,) f8, Chain, KinematicTree, Room -> writes q
def refine(q, goal, chain, tree, room):
    """Applies one Gauss-Newton step to q, from the poses in room.world_T, which removes rounding errors."""
    world_T, columns, system, joints = room.world_T, room.columns, room.system, chain.joints
    joint = joints[joints.shape[0] - 1]
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
        system[i, i] += 1e-13 if i != chain.lock else 1e12
        system[i, m] = 0.0
        for k in range(3):
            system[i, m] += columns[i, k] * (goal[9 + k] - world_T[joint, 9 + k]) + columns[i, 3 + k] * turn[k]
    step = columns[:, 6]
    if solved_step(system[:, : m + 1], step):
        for i in range(m):
            q[tree.source[joints[i]]] += step[i] / tree.ratio[joints[i]]


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


@lean_kernel  # (6,) f8, Chain, KinematicTree, (n,) f8 -> writes q
def write_turns(turns, chain, tree, q):
    """Writes the joint values of a solution into q; the locked joint keeps its value."""
    used, count = 0, chain.joints.shape[0] - (1 if chain.lock >= 0 else 0)
    for a in range(chain.joints.shape[0]):
        if a != chain.lock:
            j = chain.joints[a]
            angle = turns[count - 1 - used if chain.backwards else used]
            q[tree.source[j]] = (angle - tree.shift[j]) / tree.ratio[j]
            used += 1


@lean_kernel  # (n,) f8, (12,) f8, Chain, KinematicTree, Room -> f8, i8, f8; writes q
def settle(q, goal, chain, tree, room):
    """Brings a solution within limits and refines it; returns its excess, the axis at fault, and its pose error."""
    joints = chain.joints
    end = joints[joints.shape[0] - 1]
    worst, fault = outside(q, joints, tree.source, tree.lower, tree.upper)
    if worst > REFINABLE_EXCESS:
        return worst, fault, np.inf
    error = miss(q, goal, room.world_T, end, tree)
    for _ in range(4):
        if error <= 1e-12 or error > 1e-3:
            break
        refine(q, goal, chain, tree, room)
        worst, fault = outside(q, joints, tree.source, tree.lower, tree.upper)
        error = miss(q, goal, room.world_T, end, tree)
    return worst, fault, error


@lean_kernel  # (12,) f8, f8, Chain, KinematicTree, Room -> writes room.axes, room.motion
def prepare(goal, locked, chain, tree, room):
    """Writes the axes to solve, with the locked joint at a value, and the motion that their turns must have."""
    held = 0.0
    if chain.lock >= 0:
        hold = chain.joints[chain.lock]
        held = tree.ratio[hold] * locked + tree.shift[hold]
    chain_with_lock(chain.axes, chain.lock, held, chain.backwards, room.axes)
    motion_of_chain(goal, chain.zero, chain.axes, chain.lock, held, chain.backwards, room.moved, room.motion)


@lean_kernel  # Chain, f8, Room -> i8, i8, f8, f8; writes room.solutions
def solve_form(chain, spare, room):
    """The count of solutions of the prepared motion, the singularities, the missing length [m] and the tilt [rad]."""
    if chain.form == SPHERICAL:
        number, singular, missing = solve_spherical(
            room.axes, room.motion, chain.placing, chain.mirrored, spare, room.solutions
        )
        return number, singular, missing, 0.0
    if chain.form == THREE_PARALLEL:
        number, singular, missing = solve_three_parallel(room.axes, room.motion, spare, room.solutions)
        return number, singular, missing, 0.0
    return solve_five(room.axes, room.motion, spare, room.solutions)


@kernel  # (n,) f8, i8, i8, f8 -> writes (n,) f8
def begin(base, lock, held, value, q):
    """Writes the values of joints outside the chain, and of the locked joint if there is one."""
    for j in range(q.shape[0]):
        q[j] = base[j]
    if lock >= 0:
        q[held] = value


@kernel  # (N, 12) f8, (N,) f8, (n,) f8, Chain, KinematicTree, Answers -> writes answers
def solve_poses(goals, locked, base, chain, tree, answers):
    """Writes the configurations that bring the last joint of a chain to each pose, or why there are none.

    `base` has the values of joints outside the chain, `locked` the value of the locked joint for each pose.
    """
    found, counts, free, short = answers.found, answers.counts, answers.free, answers.short
    hold, lock, source = chain.joints[max(chain.lock, 0)], chain.lock, tree.source
    room, q = room_for(chain, tree.parent.shape[0]), base.copy()
    turns, marks = room.solutions.turns, room.solutions.free
    for i in range(goals.shape[0]):
        prepare(goals[i], locked[i], chain, tree, room)
        short[i, 2], short[i, 3], counts[i] = np.inf, -1.0, 0
        for trial in range(FREE_TURN_VALUES):
            spare = 2.0 * np.pi * trial / FREE_TURN_VALUES
            number, singular, missing, tilt = solve_form(chain, spare, room)
            if trial == 0:
                short[i, 0], short[i, 1] = missing, tilt
            for s in range(number):
                begin(base, lock, source[hold], locked[i], q)
                write_turns(turns[s], chain, tree, q)
                worst, fault, error = settle(q, goals[i], chain, tree, room)
                if worst > 0.0:
                    if worst < short[i, 2]:
                        short[i, 2], short[i, 3] = worst, fault
                elif error <= POSE_TOLERANCE and not is_known(q, found[i], counts[i]):
                    found[i, counts[i]], free[i, counts[i]] = q, marks[s]
                    counts[i] += 1
            if singular == 0 or counts[i] > 0:
                break


@kernel  # (N, n) f8, i8, KinematicTree -> (N, 12) f8
def poses_of(Q, joint, tree):
    """The poses (N, 12) of one joint in the world at every configuration."""
    world_T = np.zeros((tree.parent.shape[0], 12))
    world_T[0, 0], world_T[0, 4], world_T[0, 8] = 1.0, 1.0, 1.0
    poses = np.empty((Q.shape[0], 12))
    for i in range(Q.shape[0]):
        forward_kinematics(
            Q[i], tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement, world_T
        )
        poses[i] = world_T[joint]
    return poses
