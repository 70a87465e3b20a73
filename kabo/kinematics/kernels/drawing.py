"""Configurations drawn pose first: the parameters of a family evenly, then a branch of the closed form that reaches it.

Sample i depends on the stream's key and on i alone. Its first draw takes evenly spread parameters; a pose that the
arm does not reach is drawn anew: first with the same aims, as long as something else is left to draw, then with others.
"""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.compilation import kernel, lean_kernel
from kabo.kinematics.kernels.closed_form import (
    POSE_TOLERANCE,
    Chain,
    begin,
    is_known,
    prepare,
    room_for,
    set_windows,
    settle,
    solve_form,
    write_turns,
)
from kabo.kinematics.kernels.families import ANY_TURN, MOST_SHARES, compose, draw_pose
from kabo.kinematics.kernels.streams import step_of, uniform
from kabo.scene.tree import KinematicTree

GOLDEN_SHARE = 0.6180339887498949  # of its range by which the locked joint moves from one try to the next
# Numbers of a sample's stream: so many for each draw, of which the shares come first.
DRAW_NUMBERS, COMPONENT, LOCK, BRANCH, SECOND = 24, 6, 7, 8, 12


class Arm(NamedTuple):
    """An arm with a closed form, and where its end can be."""

    chain: Chain
    tree: KinematicTree  # with the limits to keep
    base: Array  # (n,) the values of joints outside the chain
    centre: Array  # (3,) a point from which the end's origin is never farther than `reach` [m]
    reach: float


class Draws(NamedTuple):
    """The samples to draw, and how often to try."""

    key: np.uint64  # of the stream
    first: int  # the number of the first sample
    aims: int  # draws for the same aims
    draws: int  # draws of one sample
    locks: int  # values of the locked joint for one pose


@lean_kernel  # Family -> i8
def numbers_of(family):
    """How many shares choose a pose of a family."""
    return family.aimed.shape[0] + (family.turn if family.turn < ANY_TURN else 3) + family.loose.shape[0]


@kernel  # u8, i8, i8 -> (2, 6) f8
def recurrence(key, count, slot):
    """Start and step of the additive recurrence that fills the box of `count` shares evenly."""
    places = np.zeros((2, MOST_SHARES))
    for d in range(count):
        places[0, d], places[1, d] = uniform(key, np.int64(-1), slot + d), step_of(d, count)
    return places


@lean_kernel  # Family, Draws, i8, i8, i8, (2, 6) f8, (6,) f8 -> writes shares
def set_shares(family, rule, index, draw, slot, places, shares):
    """Writes the shares of one draw of a sample: evenly spread in the first, anew in later ones, aims last of all."""
    aims = family.aimed.shape[0] + family.azimuths.shape[0]
    for d in range(numbers_of(family)):
        if draw == 0 or (d < aims and draw < rule.aims):
            shares[d] = places[0, d] + index * places[1, d]
            shares[d] -= np.floor(shares[d])
        else:
            shares[d] = uniform(rule.key, index, draw * DRAW_NUMBERS + slot + d)


@lean_kernel  # (12,) f8, Arm, Draws, i8, i8, i8, Room -> i8, f8; writes room
def solved(pose, arm, rule, index, number, tries, room):
    """The number of branches that reach a pose within limits, and the value of the locked joint, which is drawn."""
    chain, tree = arm.chain, arm.tree
    if chain.lock < 0:
        prepare(pose, 0.0, chain, tree, room)
        return solve_form(chain, 0.0, room)[0], 0.0
    k = tree.source[chain.joints[chain.lock]]
    share = uniform(rule.key, index, number)
    for _ in range(tries):
        value = tree.lower[k] + share * (tree.upper[k] - tree.lower[k])
        prepare(pose, value, chain, tree, room)
        count = solve_form(chain, 0.0, room)[0]
        if count > 0:
            return count, value
        share += GOLDEN_SHARE
        share -= np.floor(share)
    return 0, 0.0


@lean_kernel  # (12,) f8, Arm, i8, f8, Room, (n,) f8 -> bool; writes q
def confirmed(pose, arm, branch, locked, room, q):
    """Writes the configuration of one branch that `solved` found; returns whether forward kinematics confirms it."""
    chain, tree = arm.chain, arm.tree
    begin(arm.base, chain.lock, tree.source[chain.joints[max(chain.lock, 0)]], locked, q)
    write_turns(room.solutions.turns[branch], chain, tree, q)
    beyond, _, error = settle(q, pose, chain, tree, room)
    return beyond == 0.0 and error <= POSE_TOLERANCE


@lean_kernel  # (12,) f8, Arm, i8, f8, f8, Room, (n,) f8 -> bool; writes q
def one_branch(pose, arm, count, locked, share, room, q):
    """Writes a branch that a share in [0, 1) chooses; the next ones if it is not confirmed. False: none is."""
    chosen = min(int(share * count), count - 1)
    for k in range(count):  # noqa: SIM110  kernels know no generators
        if confirmed(pose, arm, (chosen + k) % count, locked, room, q):
            return True
    return False


@lean_kernel  # (12,) f8, Arm, i8, f8, Room, (n,) f8, (B, n) f8 -> i8; writes q, found
def all_branches(pose, arm, count, locked, room, q, found):
    """Writes every confirmed branch, each once; returns their number."""
    number = 0
    for k in range(count):  # noqa: SIM110  kernels know no generators
        if confirmed(pose, arm, k, locked, room, q) and not is_known(q, found, number):
            for j in range(q.shape[0]):
                found[number, j] = q[j]
            number += 1
    return number


@kernel  # Family, Arm, Draws, (N, B, n) f8, (N,) i8 -> writes found and counts
def draw_arm(family, arm, rule, found, counts):
    """Writes a configuration of each sample, or (B > 1) all branches at its pose; `counts` is 0 where none was found."""
    room, q = room_for(arm.chain, arm.tree.parent.shape[0]), arm.base.copy()
    set_windows(arm.chain, arm.tree, room.solutions.windows)
    frames, wrench, shares = np.zeros((2, 12)), np.empty(6), np.zeros(MOST_SHARES)
    frames[0, 0], frames[0, 4], frames[0, 8] = 1.0, 1.0, 1.0
    places, components = recurrence(rule.key, numbers_of(family), 0), family.starts.shape[0]
    for i in range(found.shape[0]):
        index, counts[i] = rule.first + i, 0
        for draw in range(rule.draws):
            set_shares(family, rule, index, draw, 0, places, shares)
            at = draw * DRAW_NUMBERS
            component = int(uniform(rule.key, index, at + COMPONENT) * components)
            if not draw_pose(family, component, shares, arm.centre, arm.reach, frames, wrench):
                continue
            count, locked = solved(frames[1], arm, rule, index, at + LOCK, rule.locks, room)
            if count == 0:
                continue
            if found.shape[1] == 1:
                share = uniform(rule.key, index, at + BRANCH)
                counts[i] = 1 if one_branch(frames[1], arm, count, locked, share, room, found[i, 0]) else 0
            else:
                counts[i] = all_branches(frames[1], arm, count, locked, room, q, found[i])
            if counts[i] > 0:
                break


@kernel  # (Family, Family), (Arm, Arm), Draws, (N, n1) f8, (N, n2) f8, (N,) bool -> writes the last three
def draw_pair(families, arms, rule, firsts, seconds, succeeded):
    """Writes configurations of two arms: the first's end from one family, the second's relative to it from another."""
    first, second = arms
    ahead, relative = families
    room, other = (
        room_for(first.chain, first.tree.parent.shape[0]),
        room_for(second.chain, second.tree.parent.shape[0]),
    )
    set_windows(first.chain, first.tree, room.solutions.windows)
    set_windows(second.chain, second.tree, other.solutions.windows)
    frames, between, pose = np.zeros((2, 12)), np.zeros((2, 12)), np.empty(12)
    for k in range(0, 9, 4):
        frames[0, k], between[0, k] = 1.0, 1.0
    wrench, shares, origin = np.empty(6), np.zeros(MOST_SHARES), np.zeros(3)
    places = recurrence(rule.key, numbers_of(ahead), 0)
    steps = recurrence(rule.key, numbers_of(relative), SECOND)
    apart = first.reach + second.reach + np.sqrt(((first.centre - second.centre) ** 2).sum())
    for i in range(firsts.shape[0]):
        index, succeeded[i] = rule.first + i, False
        for draw in range(rule.draws):
            at = draw * DRAW_NUMBERS
            set_shares(ahead, rule, index, draw, 0, places, shares)
            component = int(uniform(rule.key, index, at + COMPONENT) * ahead.starts.shape[0])
            if not draw_pose(ahead, component, shares, first.centre, first.reach, frames, wrench):
                continue
            set_shares(relative, rule, index, draw, SECOND, steps, shares)
            component = int(uniform(rule.key, index, at + SECOND + COMPONENT) * relative.starts.shape[0])
            if not draw_pose(relative, component, shares, origin, apart, between, wrench):
                continue
            compose(frames[1], between[1], pose)
            x, y, z = pose[9] - second.centre[0], pose[10] - second.centre[1], pose[11] - second.centre[2]
            if x * x + y * y + z * z > second.reach * second.reach:
                continue
            count, locked = solved(frames[1], first, rule, index, at + LOCK, rule.locks, room)
            if count == 0:
                continue
            number, held = solved(pose, second, rule, index, at + SECOND + LOCK, rule.locks, other)
            if number == 0:
                continue
            share, chosen = uniform(rule.key, index, at + BRANCH), uniform(rule.key, index, at + SECOND + BRANCH)
            succeeded[i] = one_branch(frames[1], first, count, locked, share, room, firsts[i]) and one_branch(
                pose, second, number, held, chosen, other, seconds[i]
            )
            if succeeded[i]:
                break
