"""Proofs that two bodies stay apart along a path: trees of boxes, axes and halvings, in walk order.

A path is straight from way point to way point; position s = piece * POSITIONS_PER_PIECE + fraction. A proof of a
pair is a tree, stored in walk order: each node concerns an interval [s0, s1] and a range of parts of each body,
and is one of

    BOXES: the boxes of both ranges over the interval are apart;   AXIS: this axis separates their swept hulls;
    TIME: the children prove both halves of the interval;
    FIRST, SECOND: the children prove both halves of the first or second body's range of parts.

Over an interval a body sweeps no more than the hull of its poses at the ends and at all way points between, grown
by the deviation of its points from their chords [K Eq. 4.19-4.22], and by its stray where joints may be off the path
(`tracks.motion`). A verifier recomputes these hulls; a proof contains only the axes and the choice of halves.

A pair has two targets: the margin that each axis is wanted to leave, and the one that it needs. Nodes with less than
is wanted are halved until halving can gain little more; what is found there then is all that is wanted of the rest.

The first index of a pair's arrays, 0 or 1, is the body. `Trail.poses` holds the poses at all way points and, behind
them, at the ends of a part of a piece.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.tracks import motion, pose_in, turning
from kabo.geometry.collision.kernels.witness_axes import AXIS_SCALE, END, HIGH, LOW, START, gap_along, greatest_gap
from kabo.scene.kernels.poses import forward_kinematics

FRACTION_BITS = 20
POSITIONS_PER_PIECE = 1 << FRACTION_BITS  # positions to a piece of the path
BOXES, AXIS, EXACT_AXIS, TIME, FIRST, SECOND, FAILED = 0, 1, 2, 3, 4, 5, 6
BOX_MARGIN = 1e-9  # [m] by which boxes must be apart, for the rounding of verifiers
KEPT_MARGIN_SHARE = 0.98  # of an axis in short integers, which is else stored in full
SMALL_SHARE = 0.05  # of the wanted margin: where halving can gain no more, the axis is looked for thoroughly
GAINED_SHARE = 0.1  # of a margin: not worth halving for

JOINT, FIRST_PART, LAST_PART = 0, 1, 2  # rows of `Things.rows`
DEVIATION, PATH, STRAY = 0, 1, 2  # columns of `bounds` and `over`
# Places of `limits`: boxes farther apart need no axis; halving for less is never worth it; no stretch of FINEST or less
# is halved; the nodes of a proof after which half as much is wanted, and again after each quarter of as many; the share
# of a gap that may be lost.
NEAR, DECIDED, FINEST, EFFORT, LOSS = 0, 1, 2, 3, 4
WANTED, NEEDED = 0, 1  # rows of `Proofs.targets`


@lean_kernel
def _body_pose(start_T, world_T, frame, joint, joint_T, thing, poses, row, scratch):
    """Writes the pose of a body, with the frame fixed at its pose at the start."""
    pose_in(world_T, joint, frame, scratch, 1)
    for r in range(3):
        a, b, c, d = (
            start_T[frame, 3 * r],
            start_T[frame, 3 * r + 1],
            start_T[frame, 3 * r + 2],
            start_T[frame, 9 + r],
        )
        for k in range(3):
            scratch[0, 3 * r + k] = a * scratch[1, k] + b * scratch[1, 3 + k] + c * scratch[1, 6 + k]
        scratch[0, 9 + r] = a * scratch[1, 9] + b * scratch[1, 10] + c * scratch[1, 11] + d
    for r in range(3):
        a, b, c = scratch[0, 3 * r], scratch[0, 3 * r + 1], scratch[0, 3 * r + 2]
        for k in range(3):
            poses[row, 3 * r + k] = a * joint_T[thing, k] + b * joint_T[thing, 3 + k] + c * joint_T[thing, 6 + k]
        poses[row, 9 + r] = (
            a * joint_T[thing, 9] + b * joint_T[thing, 10] + c * joint_T[thing, 11] + scratch[0, 9 + r]
        )


@lean_kernel
def _number_sides(pairs, sides):
    """Numbers each body in the frame of one of its pairs, once however many pairs that are; returns how many there are."""
    count = 0
    for t in range(sides.numbers.shape[0]):
        for frame in range(sides.numbers.shape[1]):
            sides.numbers[t, frame] = -1
    for p in range(pairs.shape[0]):
        for e in range(2):
            t, frame = pairs[p, e], pairs[p, 2]
            if sides.numbers[t, frame] < 0:
                sides.numbers[t, frame] = count
                sides.keys[count, 0], sides.keys[count, 1] = t, frame
                count += 1
    return count


@lean_kernel
def _pace(count, chain, trail, things, sides):
    """Writes for every piece bounds of how far points of each side deviate from chords, move, and stray in its frame."""
    waypoints, bounds, segment = trail.waypoints, sides.bounds, trail.way.segment
    for k in range(waypoints.shape[0] - 1):
        for i in range(waypoints.shape[1]):
            segment[0, i], segment[1, i] = waypoints[k, i], waypoints[k + 1, i]
            trail.way.strays[i] = trail.strays[k, i]
        turning(trail.way, chain)
        for s in range(count):
            t = sides.keys[s, 0]
            bounds[s, k, DEVIATION], _, bounds[s, k, PATH], bounds[s, k, STRAY] = motion(
                trail.way, chain, things.rows[JOINT, t], sides.keys[s, 1], things.radii[t]
            )


@lean_kernel
def _place_sides(count, trail, things, sides, work):
    """Writes the poses of each side at all way points, its box over the whole path, and how it moves."""
    frames, pieces, ends, over = trail.way.frames, trail.waypoints.shape[0] - 1, work.ends, work.over
    for s in range(count):
        t, frame, path, stray, off = sides.keys[s, 0], sides.keys[s, 1], 0.0, 0.0, 0.0
        for k in range(pieces):
            path += sides.bounds[s, k, PATH]
            stray = max(stray, sides.bounds[s, k, STRAY])
            off = max(off, sides.bounds[s, k, DEVIATION] + sides.bounds[s, k, STRAY])
        rows = 1 if path == 0.0 else pieces + 1
        for k in range(rows):
            _body_pose(
                frames[0],
                frames[k],
                frame,
                things.rows[JOINT, t],
                things.joint_T,
                t,
                sides.poses[s],
                k,
                work.scratch,
            )
        sides.still[s], sides.moves[s] = path == 0.0, path > 0.0 or stray > 0.0
        ends[0, LOW], ends[0, HIGH], ends[0, START], ends[0, END] = (
            things.rows[FIRST_PART, t],
            things.rows[LAST_PART, t],
            0,
            rows - 1,
        )
        over[0, DEVIATION] = off
        _swept_box(things.boxes, sides.poses[s], ends[0], off, work.box, sides.boxes[s])


@lean_kernel
def _take_sides(pair, sides, trail, work):
    """Copies poses and bounds of both sides of a pair to where a proof uses them."""
    for e in range(2):
        s = sides.numbers[pair[e], pair[2]]
        work.still[e] = sides.still[s]
        for k in range(1 if sides.still[s] else sides.bounds.shape[1] + 1):
            for i in range(12):
                trail.poses[e, k, i] = sides.poses[s, k, i]
        for k in range(sides.bounds.shape[1]):
            for i in range(3):
                trail.bounds[e, k, i] = sides.bounds[s, k, i]


@lean_kernel  # (2, K, 3), i8, i8 -> writes (2, 3) deviation with stray, path, and stray
def _over(bounds, s0, s1, over):
    """Writes the same bounds for a stretch, whole pieces or a part of one: of both kinds of deviation together."""
    first, last = s0 >> FRACTION_BITS, (s1 - 1) >> FRACTION_BITS
    share = min(1.0, (s1 - s0) / POSITIONS_PER_PIECE)
    for e in range(2):
        over[e, DEVIATION], over[e, PATH], over[e, STRAY] = 0.0, 0.0, 0.0
        for k in range(first, last + 1):
            off = bounds[e, k, STRAY]
            over[e, DEVIATION] = max(over[e, DEVIATION], bounds[e, k, DEVIATION] * share * share + off)
            over[e, PATH] += bounds[e, k, PATH] * share
            over[e, STRAY] = max(over[e, STRAY], off)


@lean_kernel
def _swept_box(boxes, poses, ends, grow, box, swept):
    """Writes the box (6,) around the volume that a range of parts sweeps; returns the diagonal of the range's own box."""
    size = 0.0
    for r in range(3):
        least, most = np.inf, -np.inf
        for p in range(ends[LOW], ends[HIGH]):
            least, most = min(least, boxes[p, r]), max(most, boxes[p, 3 + r])
        box[r], box[3 + r] = 0.5 * (least + most), 0.5 * (most - least)
        size += (most - least) * (most - least)
    for r in range(3):
        least, most = np.inf, -np.inf
        for k in range(ends[START], ends[END] + 1):
            a, b, c = poses[k, 3 * r], poses[k, 3 * r + 1], poses[k, 3 * r + 2]
            middle = a * box[0] + b * box[1] + c * box[2] + poses[k, 9 + r]
            half = abs(a) * box[3] + abs(b) * box[4] + abs(c) * box[5]
            least, most = min(least, middle - half), max(most, middle + half)
        swept[r], swept[3 + r] = least - grow, most + grow
    return np.sqrt(size)


@lean_kernel
def _box_gap(first, second):
    """The greatest gap of two boxes along an axis [m]; negative if they overlap."""
    gap = -np.inf
    for r in range(3):
        gap = max(gap, first[r] - second[3 + r], second[r] - first[3 + r])
    return gap


@lean_kernel
def _write_axis(things, work, poses, grow, gap, near, search, proofs, row):
    """Writes the axis in short integers if that keeps its margin, else in full; returns the gap along the written axis.

    A margin of `near` is kept whole, since one that is less is told as the clearance.
    """
    axis, axes = search.axis, proofs.axes
    greatest, square = max(abs(axis[0]), abs(axis[1]), abs(axis[2])), 0.0
    proofs.codes[row] = AXIS
    for r in range(3):
        axes[row, r] = np.round(axis[r] / greatest * AXIS_SCALE)
        square += axes[row, r] * axes[row, r]
    norm = np.sqrt(square)
    x, y, z = axes[row, 0] / norm, axes[row, 1] / norm, axes[row, 2] / norm
    found = gap_along(things.hulls, work.ends, poses, x, y, z, search)
    if found - grow > KEPT_MARGIN_SHARE * (gap - grow) and not found - grow < near <= gap - grow:
        return found
    proofs.codes[row] = EXACT_AXIS
    for r in range(3):
        axes[row, r] = axis[r]
    return gap


@lean_kernel
def _place(s0, s1, pair, chain, trail, things, work):
    """Selects the poses of a stretch; if it ends inside a piece, writes the poses at its ends behind the others."""
    waypoints, segment, frames, ends = trail.waypoints, trail.way.segment, trail.way.frames, work.ends
    joints, factors = chain.joints, chain.factors
    count = waypoints.shape[0]
    inside = s1 - s0 < POSITIONS_PER_PIECE
    for c in range(2 if inside else 0):
        s = s1 if c else s0
        k, share = s >> FRACTION_BITS, (s & (POSITIONS_PER_PIECE - 1)) / POSITIONS_PER_PIECE
        for i in range(waypoints.shape[1]):
            segment[2, i] = waypoints[k, i]
            if share > 0.0:
                segment[2, i] += share * (waypoints[k + 1, i] - waypoints[k, i])
        forward_kinematics(
            segment[2], joints[0], joints[1], joints[2], factors[0], factors[1], chain.placement, frames[count]
        )
        for e in range(2):
            t = pair[e]
            if not work.still[e]:
                _body_pose(
                    frames[0], frames[count], pair[2], things.rows[JOINT, t], things.joint_T, t, trail.poses[e],
                    count + c, work.scratch,
                )  # fmt: skip
    for e in range(2):
        ends[e, START] = 0 if work.still[e] else count if inside else s0 >> FRACTION_BITS
        ends[e, END] = 0 if work.still[e] else count + 1 if inside else s1 >> FRACTION_BITS


@lean_kernel
def _halve(stack, top, s0, s1, ends, size, by_time, codes, row):
    """Puts both halves on the stack, the first on top: of the stretch, or of the larger range of several parts."""
    for e in range(2):
        stack[top + e, 0], stack[top + e, 1] = s0, s1
        stack[top + e, 2], stack[top + e, 3] = ends[0, LOW], ends[0, HIGH]
        stack[top + e, 4], stack[top + e, 5] = ends[1, LOW], ends[1, HIGH]
    if by_time:
        codes[row] = TIME
        middle = (s0 + s1) >> 1
        if s1 - s0 > POSITIONS_PER_PIECE:
            middle = (((s0 >> FRACTION_BITS) + (s1 >> FRACTION_BITS)) >> 1) << FRACTION_BITS
        stack[top, 0], stack[top + 1, 1] = middle, middle
        return
    e = 0 if ends[1, HIGH] - ends[1, LOW] == 1 or (ends[0, HIGH] - ends[0, LOW] > 1 and size[0] >= size[1]) else 1
    codes[row] = SECOND if e else FIRST
    middle = (ends[e, LOW] + ends[e, HIGH]) >> 1
    stack[top, 2 + 2 * e], stack[top + 1, 3 + 2 * e] = middle, middle


@lean_kernel
def _widest(ends, size):
    """The size of the larger box among ranges of several parts; 0 if both ranges have one part."""
    several = 0.0
    for e in range(2):
        if ends[e, HIGH] - ends[e, LOW] > 1:
            several = max(several, size[e])
    return several


@lean_kernel
def _begin(pair, waypoints, things, axis, stack):
    """Puts the whole path with all parts of a pair on the stack, resets the axis; returns the height of the stack."""
    stack[0, 0], stack[0, 1] = 0, (waypoints.shape[0] - 1) * POSITIONS_PER_PIECE
    for e in range(2):
        stack[0, 2 + 2 * e], stack[0, 3 + 2 * e] = things[FIRST_PART, pair[e]], things[LAST_PART, pair[e]]
    for r in range(3):
        axis[r] = 0.0
    return 1


@lean_kernel
def _fail(s0, s1, margin, ends, proofs, row):
    """Writes why a proof failed: the ends of the stretch, in pieces, and the margin; behind it, the two parts."""
    proofs.codes[row] = FAILED
    proofs.axes[row, 0], proofs.axes[row, 1], proofs.axes[row, 2] = (
        s0 / POSITIONS_PER_PIECE,
        s1 / POSITIONS_PER_PIECE,
        margin,
    )
    if row + 1 < proofs.axes.shape[0]:
        proofs.axes[row + 1, 0], proofs.axes[row + 1, 1] = ends[0, LOW], ends[1, LOW]


@lean_kernel
def _prove(p, pair, limits, chain, trail, things, work, search, proofs, row):
    """Writes the proof of a pair from `row` on; returns the row after it, or -1 if there is none (see `_fail`)."""
    top, stack, ends, over = (
        _begin(pair, trail.waypoints, things.rows, search.axis, work.stack),
        work.stack,
        work.ends,
        work.over,
    )
    axis, swept, last_row = search.axis, work.swept, row + np.int64(limits[EFFORT])
    wanted, needed = proofs.targets[WANTED, p], proofs.targets[NEEDED, p]
    while top > 0:
        top -= 1
        s0, s1 = stack[top, 0], stack[top, 1]
        for e in range(2):
            ends[e, LOW], ends[e, HIGH] = stack[top, 2 + 2 * e], stack[top, 3 + 2 * e]
        _place(s0, s1, pair, chain, trail, things, work)
        _over(trail.bounds, s0, s1, over)
        for e in range(2):
            work.size[e] = _swept_box(
                things.boxes, trail.poses[e], ends[e], over[e, DEVIATION], work.box, swept[e]
            )
        if row >= proofs.codes.shape[0] or top + 2 >= stack.shape[0]:
            return -1
        gap = _box_gap(swept[0], swept[1]) - BOX_MARGIN
        if gap > min(limits[NEAR], wanted):
            proofs.codes[row] = BOXES
            proofs.margins[p] = min(proofs.margins[p], gap if gap < limits[NEAR] else np.inf)
            row += 1
            continue
        grow, moved = over[0, DEVIATION] + over[1, DEVIATION], over[0, PATH] + over[1, PATH]
        single = ends[0, HIGH] - ends[0, LOW] == 1 and ends[1, HIGH] - ends[1, LOW] == 1
        rest = grow - over[0, STRAY] - over[1, STRAY] + moved  # what halving can gain
        if row > last_row:
            wanted, last_row = max(needed, 0.5 * wanted), row + np.int64(0.25 * limits[EFFORT])
        small = single and (rest <= SMALL_SHARE * wanted or s1 - s0 <= limits[FINEST])
        least = grow + (needed if small else wanted)
        if axis[0] == 0.0 and axis[1] == 0.0 and axis[2] == 0.0:
            for r in range(3):
                axis[r] = swept[0, r] + swept[0, 3 + r] - swept[1, r] - swept[1, 3 + r]
        gap = greatest_gap(things.hulls, ends, trail.poses, grow + wanted, least, limits[LOSS], search)
        gained = rest <= max(limits[DECIDED], GAINED_SHARE * (gap - grow)) or s1 - s0 <= limits[FINEST]
        if gap > least and (gap > grow + wanted or gained):
            gap = _write_axis(things, work, trail.poses, grow, gap, limits[NEAR], search, proofs, row)
            proofs.margins[p] = min(proofs.margins[p], gap - grow)
            wanted = max(needed, min(wanted, gap - grow))
        elif small and gained:
            _fail(s0, s1, gap - grow, ends, proofs, row)
            return -1
        else:
            by_time = single or (moved > _widest(ends, work.size) and s1 - s0 > limits[FINEST])
            _halve(stack, top, s0, s1, ends, work.size, by_time, proofs.codes, row)
            top += 2
        row += 1
    return row


@lean_kernel
def prove_pairs(pairs, limits, chain, trail, things, sides, work, search, proofs):
    """Proves pairs (P, 3) of first body, second body, frame; writes the row after each proof, and its least margin.

    `proofs.targets` (2, P) are the margin that is wanted of each pair, and the one that is needed [m].
    A pair that does not move, or whose boxes over the whole path are apart, has an empty proof, since verifiers
    test these two cases first. Returns the number of pairs proven before the first failure; P if there is none.
    """
    joints, factors, waypoints, frames = chain.joints, chain.factors, trail.waypoints, trail.way.frames
    count, row = waypoints.shape[0], 0
    for k in range(count):
        forward_kinematics(
            waypoints[k], joints[0], joints[1], joints[2], factors[0], factors[1], chain.placement, frames[k]
        )
    number = _number_sides(pairs, sides)
    _pace(number, chain, trail, things, sides)
    _place_sides(number, trail, things, sides, work)
    for p in range(pairs.shape[0]):
        proofs.margins[p], proofs.where[p] = np.inf, row
        first, second = sides.numbers[pairs[p, 0], pairs[p, 2]], sides.numbers[pairs[p, 1], pairs[p, 2]]
        if not (sides.moves[first] or sides.moves[second]):
            continue
        gap = _box_gap(sides.boxes[first], sides.boxes[second]) - BOX_MARGIN
        if gap > min(limits[NEAR], proofs.targets[WANTED, p]):
            proofs.margins[p] = gap if gap < limits[NEAR] else np.inf
            continue
        _take_sides(pairs[p], sides, trail, work)
        row = _prove(p, pairs[p], limits, chain, trail, things, work, search, proofs, row)
        if row < 0:
            return p
        proofs.where[p] = row
    return pairs.shape[0]
