"""The bounded sweep: finds a pair of groups that does not stay apart along a straight joint-space segment.

For a pair of parts over an interval, the hull of each part's poses at both ends, grown by its deviation D, encloses
what the part sweeps. If the hulls are proven farther apart than clearance + D_a + D_b the interval is free. Every
point of a grown hull lies within D + angle * diameter / 4 of the part's true swept volume, hence a pair of hulls
that is not proven apart comes as close as

    clearance + 2 (D_a + D_b) + spread,   spread = (angle_a diameter_a + angle_b diameter_b) / 4
                                                   + the shorter of both paths, since both move in step

and "hit" may be said where this, numeric and both bodies' own deviations are at most epsilon. Where they are not, the
pose in the middle decides if it brings the parts that close by itself; else both halves are looked at. D falls with
the square of the interval, spread linearly, so the bisection ends.

The arguments are the fields of `Chain`, `Bodies`, `Tracks`, `Scratch` and `Sweep` (kabo.geometry.collision.view_arrays).
"""

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.boxes import boxes_near, place_block, place_box, unite_boxes
from kabo.geometry.collision.kernels.configuration_check import usable
from kabo.geometry.collision.kernels.separation import apart
from kabo.geometry.collision.kernels.tracks import (
    COARSE_LEVELS,
    COARSE_NODES,
    MAX_HALVINGS,
    frames_at,
    interval_parts,
    level_for,
    look_up,
    motion,
    pose_in,
    turning,
    whole_box,
)

COARSE_DEVIATION = 0.03  # [m] down to which segments are halved before boxes are compared
JOINT, PARTS, PAIRS = 0, 1, 2  # rows of `groups`
GROUP, FRAME = 0, 1  # rows of `tracks`
RUN, MARK, USED, INTERVAL_MARK, INTERVALS_USED = 0, 1, 2, 3, 4  # places of `state`
KEY, KEY_MARK, BLOCK = 0, 1, 2  # rows of `pool`
NUMBER = 1  # row of `pairs`
SWEEPS, POSITIVE = 5, 6  # places of `counters`


@lean_kernel
def _coarse_poses(
    t, level, moves, segment, joints, factors, placement, groups, group_extents, tracks, frames, frame_tags,
    node_poses, node_boxes, node_marks, state,
):  # fmt: skip
    """Computes the poses of a track and the boxes of its group at the coarse nodes of a level, each once per sweep."""
    group = tracks[GROUP, t]
    for i in range((1 << level) + 1 if moves else 1):
        c = i << (COARSE_LEVELS - level)
        row = t * COARSE_NODES + c
        if node_marks[row] != state[RUN]:
            node_marks[row] = state[RUN]
            node = c << (MAX_HALVINGS - COARSE_LEVELS)
            slot = frames_at(node, state[RUN], segment, joints, factors, placement, frames, frame_tags)
            pose_in(frames[slot], groups[JOINT, group], tracks[FRAME, t], node_poses, row)
            place_box(node_poses, row, group_extents, group, node_boxes, row)


@lean_kernel
def _whole(
    t, segment, joints, factors, placement, groups, group_extents, tracks, lengths, radii, turned, motions, frames,
    frame_tags, node_poses, node_boxes, node_marks, whole_boxes, whole_marks, state,
):  # fmt: skip
    """Computes bounds of a track's motion, its boxes at coarse nodes and the box of its swept volume, once per sweep."""
    if whole_marks[t] == state[RUN]:
        return
    whole_marks[t] = state[RUN]
    group, frame = tracks[GROUP, t], tracks[FRAME, t]
    deviation, angle, path = motion(
        segment, joints, factors, lengths, turned, groups[JOINT, group], frame, radii[group]
    )
    motions[t, 0], motions[t, 1], motions[t, 2] = deviation, angle, path
    level = level_for(deviation, COARSE_DEVIATION)
    _coarse_poses(
        t, level, path > 0.0, segment, joints, factors, placement, groups, group_extents, tracks, frames, frame_tags,
        node_poses, node_boxes, node_marks, state,
    )  # fmt: skip
    whole_box(t, level, deviation / (1 << 2 * level), path > 0.0, node_boxes, whole_boxes)


@lean_kernel
def _interval_box(t, level, i, motions, node_boxes, united, target):
    """Writes the box of a track's group over interval i of a level to row `target` of `united`."""
    moves = motions[t, 2] > 0.0
    row = t * COARSE_NODES + (i << (COARSE_LEVELS - level) if moves else 0)
    last = row + (1 << (COARSE_LEVELS - level) if moves else 0)
    unite_boxes(node_boxes, row, last, motions[t, 0] / (1 << 2 * level), united, target)


@lean_kernel
def _interval_parts(
    t, level, i, groups, part_extents, tracks, motions, node_poses, interval_table, interval_boxes, united, state
):
    """The index in `interval_boxes` of the boxes of a track's parts over interval i of a level, computed on first use."""
    moves = motions[t, 2] > 0.0
    number = t * 2 * COARSE_NODES + ((1 << level) + i if moves else 0)
    if interval_table[1, number] != state[INTERVAL_MARK]:
        row = t * COARSE_NODES + (i << (COARSE_LEVELS - level) if moves else 0)
        last = row + (1 << (COARSE_LEVELS - level) if moves else 0)
        first, end = groups[PARTS, tracks[GROUP, t]], groups[PARTS, tracks[GROUP, t] + 1]
        start = state[INTERVALS_USED]
        grow = motions[t, 0] / (1 << 2 * level)
        interval_parts(first, end, part_extents, node_poses, row, last, grow, united, interval_boxes, start)
        state[INTERVALS_USED] += end - first
        interval_table[0, number], interval_table[1, number] = start, state[INTERVAL_MARK]
    return interval_table[0, number]


@lean_kernel
def _block(
    t, part, node, motions, segment, joints, factors, placement, groups, sizes, part_extents, tracks, frames,
    frame_tags, blocks, block_boxes, pose, pool, state,
):  # fmt: skip
    """The block with a part's vertices at a node in the track's frame (and its box), computed on first use."""
    joint, frame = groups[JOINT, tracks[GROUP, t]], tracks[FRAME, t]
    if joint == frame:
        return part
    if not motions[t, 2] > 0.0:
        node = 0
    key = (node * tracks.shape[1] + t) * sizes.shape[0] + part
    place = look_up(key, state[MARK], pool[KEY], pool[KEY_MARK])
    if pool[KEY_MARK, place] != state[MARK]:
        target = sizes.shape[0] + state[USED]
        pool[KEY, place], pool[KEY_MARK, place], pool[BLOCK, place] = key, state[MARK], target
        state[USED] += 1
        slot = frames_at(node, state[RUN], segment, joints, factors, placement, frames, frame_tags)
        pose_in(frames[slot], joint, frame, pose, 0)
        place_block(pose, 0, blocks, part, blocks, target, sizes[part])
        place_box(pose, 0, part_extents, part, block_boxes, target)
    return pool[BLOCK, place]


@lean_kernel
def _parts_hit(
    ta, a, tb, b, start, width, deviation, spread, slack, pose_margin, margin, motions, segment, joints, factors,
    placement, groups, sizes, part_extents, tracks, frames, frame_tags, blocks, block_boxes, pose, pool, state, stack,
    ends, united, offset, axis, simplex, counters,
):  # fmt: skip
    """Whether parts a and b may collide within the interval; bisects until either answer is proven."""
    stack[0, 0], stack[0, 1], top, coarse = start, width, 1, width
    while top > 0:
        top -= 1
        node, width = stack[top, 0], stack[top, 1]
        if state[USED] + 8 > blocks.shape[0] - sizes.shape[0]:  # nothing is held here: begin the pool anew
            state[USED] = 0
            state[MARK] += 1
        for e in range(4):
            ends[e] = _block(
                ta if e < 2 else tb, a if e < 2 else b, node + width * (e & 1), motions, segment, joints, factors,
                placement, groups, sizes, part_extents, tracks, frames, frame_tags, blocks, block_boxes, pose, pool,
                state,
            )  # fmt: skip
        f = width / (1 << MAX_HALVINGS)
        needed = deviation * f * f + margin
        if width < coarse:
            unite_boxes(block_boxes, ends[0], ends[1], 0.0, united, 0)
            unite_boxes(block_boxes, ends[2], ends[3], 0.0, united, 1)
            if not boxes_near(united, 0, united, 1, needed):
                continue
        if apart(
            blocks, ends[0], ends[1], sizes[a], ends[2], ends[3], sizes[b], needed, offset, axis, simplex, counters
        ):
            continue
        if 2.0 * deviation * f * f + spread * f <= slack or width == 1:
            return True
        width //= 2
        for e in range(2):
            ends[e] = _block(
                tb if e else ta, b if e else a, node + width, motions, segment, joints, factors, placement, groups,
                sizes, part_extents, tracks, frames, frame_tags, blocks, block_boxes, pose, pool, state,
            )  # fmt: skip
        counters[3] += 1
        if not apart(
            blocks, ends[0], ends[0], sizes[a], ends[1], ends[1], sizes[b], pose_margin, offset, axis, simplex,
            counters,
        ):  # fmt: skip
            return True  # the pose in the middle alone is closer than epsilon
        stack[top, 0], stack[top, 1] = node + width, width
        stack[top + 1, 0], stack[top + 1, 1] = node, width
        top += 2
    return False


@lean_kernel  # (B, 6) f8, i8, i8 -> writes (3,) f8
def _between(boxes, u, v, axis):
    """Writes twice the vector from the centre of box v to that of box u, as a first axis."""
    for r in range(3):
        axis[r] = boxes[u, r] + boxes[u, 3 + r] - boxes[v, r]
        axis[r] -= boxes[v, 3 + r]


@lean_kernel
def _pair_hit(
    ta, tb, slack, pose_margin, margin, motions, segment, joints, factors, placement, groups, sizes, diameters,
    part_extents, group_extents, tracks, frames, frame_tags, node_poses, node_boxes, node_marks, interval_table,
    interval_boxes, blocks, block_boxes, pose, pool, state, stack, ends, united, offset, axis, simplex, counters,
):  # fmt: skip
    """Whether a pair of groups may collide: tests those parts whose boxes meet, interval by interval."""
    deviation, together = motions[ta, 0] + motions[tb, 0], min(motions[ta, 2], motions[tb, 2])
    level = level_for(deviation, COARSE_DEVIATION)
    first_a, first_b = groups[PARTS, tracks[GROUP, ta]], groups[PARTS, tracks[GROUP, tb]]
    count_a = groups[PARTS, tracks[GROUP, ta] + 1] - first_a
    count_b = groups[PARTS, tracks[GROUP, tb] + 1] - first_b
    width = (1 << MAX_HALVINGS) >> level
    for t in (ta, tb):
        _coarse_poses(
            t, level, motions[t, 2] > 0.0, segment, joints, factors, placement, groups, group_extents, tracks, frames,
            frame_tags, node_poses, node_boxes, node_marks, state,
        )  # fmt: skip
    for i in range(1 << level):
        if state[INTERVALS_USED] + count_a + count_b > interval_boxes.shape[0]:
            state[INTERVALS_USED] = 0
            state[INTERVAL_MARK] += 1
        _interval_box(ta, level, i, motions, node_boxes, united, 2)
        _interval_box(tb, level, i, motions, node_boxes, united, 3)
        if not boxes_near(united, 2, united, 3, margin):
            continue
        boxes_a = _interval_parts(
            ta, level, i, groups, part_extents, tracks, motions, node_poses, interval_table, interval_boxes, united,
            state,
        )  # fmt: skip
        boxes_b = _interval_parts(
            tb, level, i, groups, part_extents, tracks, motions, node_poses, interval_table, interval_boxes, united,
            state,
        )  # fmt: skip
        for a in range(count_a):
            if not boxes_near(interval_boxes, boxes_a + a, united, 3, margin):
                continue
            for b in range(count_b):
                u, v = boxes_a + a, boxes_b + b
                if not boxes_near(interval_boxes, u, interval_boxes, v, margin):
                    continue
                _between(interval_boxes, u, v, axis)
                turned = motions[ta, 1] * diameters[first_a + a] + motions[tb, 1] * diameters[first_b + b]
                if _parts_hit(
                    ta, first_a + a, tb, first_b + b, i * width, width, deviation, 0.25 * turned + together, slack,
                    pose_margin, margin, motions, segment, joints, factors, placement, groups, sizes, part_extents,
                    tracks, frames, frame_tags, blocks, block_boxes, pose, pool, state, stack, ends, united, offset,
                    axis, simplex, counters,
                ):  # fmt: skip
                    return True
    return False


@lean_kernel
def _begin(start, end, segment, joints, factors, turned, state):
    """Empties all pools, stores both ends of the segment, and sums up how far each joint's frame rotates."""
    state[RUN] += 1
    state[MARK] += 1
    state[INTERVAL_MARK] += 1
    state[USED], state[INTERVALS_USED] = 0, 0
    for i in range(start.shape[0]):
        segment[0, i], segment[1, i] = start[i], end[i]
    turning(segment, joints, factors, turned)


@lean_kernel
def first_swept_hit(
    start, end, margin, clearance, joints, factors, placement, bound, offset, groups, sizes, part_extents,
    group_extents, pairs, blocks, axis, simplex, counters, lengths, radii, diameters, tracks, pair_tracks, slacks,
    segment, turned, motions, frames, frame_tags, node_poses, node_boxes, node_marks, whole_boxes, whole_marks,
    interval_table, interval_boxes, block_boxes, pose, pool, state, stack, ends, united,
):  # fmt: skip
    """The index of the first pair (in the order of groups) that is not proven apart on the segment.

    The result is -1 if all pairs are proven apart, and -2 if `start` or `end` is invalid. `slacks` (P,): the part
    of epsilon that remains for `spread`, for each pair.
    """
    counters[SWEEPS] += 1
    if not (usable(start, bound) and usable(end, bound)):
        return -2
    _begin(start, end, segment, joints, factors, turned, state)
    for p in range(pairs.shape[1]):
        ta, tb = pair_tracks[0, p], pair_tracks[1, p]
        for t in (ta, tb):
            if whole_marks[t] != state[RUN]:
                _whole(
                    t, segment, joints, factors, placement, groups, group_extents, tracks, lengths, radii, turned,
                    motions, frames, frame_tags, node_poses, node_boxes, node_marks, whole_boxes, whole_marks, state,
                )  # fmt: skip
        if boxes_near(whole_boxes, ta, whole_boxes, tb, margin) and _pair_hit(
            ta, tb, slacks[p], slacks[p] + clearance, margin, motions, segment, joints, factors, placement, groups,
            sizes, diameters, part_extents, group_extents, tracks, frames, frame_tags, node_poses, node_boxes,
            node_marks, interval_table, interval_boxes, blocks, block_boxes, pose, pool, state, stack, ends, united,
            offset, axis, simplex, counters,
        ):  # fmt: skip
            counters[POSITIVE] += 1
            return pairs[NUMBER, p]
    return -1
