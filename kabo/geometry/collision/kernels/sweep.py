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

Where joints may be off the segment by given values, a body may be farther from its pose by its stray [kernels.tracks];
and a body may have to keep more than the clearance from others. Both only add to the distance that is asked for.

Before any part is placed, the axis along which a pair was apart last is tried: of two pairs it decides one or more.

Where a part is not proven apart and has children, these are looked at over the same interval.
"""

import numpy as np

from kabo.compilation import farthest, inner, lean_kernel
from kabo.geometry.collision.kernels.boxes import (
    BOX_SLACK,
    boxes_near,
    kept_between,
    place_box,
    place_part,
    unite_boxes,
)
from kabo.geometry.collision.kernels.bundles import (
    CHILD_COUNT,
    DISC,
    FIRST_CHILD,
    FIRST_OPEN,
    FREE,
    ITERATIONS,
    JOINT,
    MIDDLES,
    NUMBER,
    OPEN,
    PARTS,
    POSITIVE,
    RADIUS,
    ROOTS_END,
    SEARCHES,
    SWEEPS,
    UNUSABLE,
    Limits,
)
from kabo.geometry.collision.kernels.configuration_check import usable
from kabo.geometry.collision.kernels.descent import divided
from kabo.geometry.collision.kernels.distance import between
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
KNOWN_AXES, AXES_PER_PART = 4096, 251  # rows of `Pool.known`, and between those of a part and the next one
KNOWN_SLACK = 1e-6  # [m] that a known axis must have to spare: more than any search may lose of a gap
GROUP, FRAME = 0, 1  # rows of `Tracks.tracks`
RUN, MARK, USED, INTERVAL_MARK, INTERVALS_USED = 0, 1, 2, 3, 4  # places of `Pool.state`
KEY, KEY_MARK, ROW = 0, 1, 2  # rows of `Pool.keys`
DEVIATION, ANGLE, PATH, STRAY = 0, 1, 2, 3  # columns of `Way.motions`


@lean_kernel
def _coarse_poses(t, level, moves, scene, sweep):
    """Computes the poses of a track and the boxes of its group at the coarse nodes of a level, each once per sweep."""
    group, nodes, run = sweep.tracks.tracks[GROUP, t], sweep.nodes, sweep.pool.state[RUN]
    for i in range((1 << level) + 1 if moves else 1):
        c = i << (COARSE_LEVELS - level)
        row = t * COARSE_NODES + c
        if nodes.marks[row] != run:
            nodes.marks[row] = run
            slot = frames_at(c << (MAX_HALVINGS - COARSE_LEVELS), run, sweep.way, scene.chain)
            pose_in(
                sweep.way.frames[slot], scene.groups[JOINT, group], sweep.tracks.tracks[FRAME, t], nodes.poses, row
            )
            place_box(nodes.poses, row, scene.extents.groups, group, nodes.boxes, row)


@lean_kernel
def _whole(t, scene, sweep):
    """Computes bounds of a track's motion, its boxes at coarse nodes and the box of its swept volume."""
    tracks, motions = sweep.tracks, sweep.way.motions
    group, frame = tracks.tracks[GROUP, t], tracks.tracks[FRAME, t]
    if scene.groups[JOINT, group] == frame:  # it stands in its own frame, as most bodies do in the world
        motions[t, DEVIATION], motions[t, ANGLE], motions[t, PATH], motions[t, STRAY] = 0.0, 0.0, 0.0, 0.0
        for r in range(3):
            middle, half = scene.extents.groups[group, r], scene.extents.groups[group, 3 + r] + BOX_SLACK
            sweep.nodes.whole_boxes[t, r], sweep.nodes.whole_boxes[t, 3 + r] = middle - half, middle + half
        return
    deviation, angle, path, stray = motion(
        sweep.way, scene.chain, scene.groups[JOINT, group], frame, tracks.radii[group]
    )
    motions[t, DEVIATION], motions[t, ANGLE], motions[t, PATH], motions[t, STRAY] = deviation, angle, path, stray
    level = level_for(deviation, COARSE_DEVIATION)
    _coarse_poses(t, level, path > 0.0, scene, sweep)
    whole_box(t, level, deviation / (1 << 2 * level), path > 0.0, sweep.nodes)


@lean_kernel
def _interval_box(t, level, i, motions, node_boxes, united, target):
    """Writes the box of a track's group over interval i of a level to row `target` of `united`."""
    moves = motions[t, PATH] > 0.0
    row = t * COARSE_NODES + (i << (COARSE_LEVELS - level) if moves else 0)
    last = row + (1 << (COARSE_LEVELS - level) if moves else 0)
    unite_boxes(node_boxes, row, last, motions[t, DEVIATION] / (1 << 2 * level), united, target)


@lean_kernel
def _interval_parts(t, level, i, groups, part_extents, sweep):
    """The index in `interval_boxes` of the boxes of a track's roots over interval i of a level, computed on first use."""
    motions, pool, group = sweep.way.motions, sweep.pool, sweep.tracks.tracks[GROUP, t]
    moves = motions[t, PATH] > 0.0
    number = t * 2 * COARSE_NODES + ((1 << level) + i if moves else 0)
    if pool.interval_table[1, number] != pool.state[INTERVAL_MARK]:
        row = t * COARSE_NODES + (i << (COARSE_LEVELS - level) if moves else 0)
        last = row + (1 << (COARSE_LEVELS - level) if moves else 0)
        first, end = groups[PARTS, group], groups[ROOTS_END, group]
        start = pool.state[INTERVALS_USED]
        grow = motions[t, DEVIATION] / (1 << 2 * level)
        interval_parts(first, end, part_extents, sweep.nodes.poses, row, last, grow, pool, start)
        pool.state[INTERVALS_USED] += end - first
        pool.interval_table[0, number], pool.interval_table[1, number] = start, pool.state[INTERVAL_MARK]
    return pool.interval_table[0, number]


@lean_kernel
def _row_at(t, part, node, scene, sweep):
    """The row of the hulls with a part at a node in the track's frame (and its box), computed on first use."""
    tracks, pool = sweep.tracks.tracks, sweep.pool
    joint, frame, parts = scene.groups[JOINT, tracks[GROUP, t]], tracks[FRAME, t], scene.extents.parts.shape[0]
    if joint == frame:
        return part
    if not sweep.way.motions[t, PATH] > 0.0:
        node = 0
    key = (node * tracks.shape[1] + t) * parts + part
    place = look_up(key, pool.state[MARK], pool.keys[KEY], pool.keys[KEY_MARK])
    if pool.keys[KEY_MARK, place] != pool.state[MARK]:
        target = parts + pool.state[USED]
        pool.keys[KEY, place], pool.keys[KEY_MARK, place], pool.keys[ROW, place] = key, pool.state[MARK], target
        pool.state[USED] += 1
        slot = frames_at(node, pool.state[RUN], sweep.way, scene.chain)
        pose_in(sweep.way.frames[slot], joint, frame, pool.pose, 0)
        place_part(pool.pose, 0, scene.hulls, part, scene.hulls, target)
        place_box(pool.pose, 0, scene.extents.parts, part, pool.boxes, target)
    return pool.keys[ROW, place]


@lean_kernel  # (.., 4) i8, i8 x 5
def _put(stack, top, node, width, a, b):
    stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = node, width, a, b


@lean_kernel
def _put_children(a, b, node, width, tree, stack, top):
    """Puts the pairs with the children of one of two parts on the stack; returns its height, or FIRST_OPEN - part."""
    part = divided(tree, a, b)
    count, first = tree.children[part, CHILD_COUNT], tree.children[part, FIRST_CHILD]
    if count == OPEN:
        return FIRST_OPEN - part
    for child in range(first + count - 1, first - 1, -1):
        _put(stack, top, node, width, child if part == a else a, b if part == a else child)
        top += 1
    return top


@lean_kernel
def _parts_hit(ta, tb, coarse, limits, scene, sweep, search):
    """FREE or 0, if the two parts on the stack collide within the interval; or FIRST_OPEN - p if p must be divided.

    Bisects the interval until either answer is proven.
    """
    pool, motions, tree, ends = sweep.pool, sweep.way.motions, scene.tree, sweep.pool.ends
    stack, united, top = pool.stack, pool.united, 1
    deviation = motions[ta, DEVIATION] + motions[tb, DEVIATION]
    together = min(motions[ta, PATH], motions[tb, PATH])
    first_a, first_b = stack[0, 2], stack[0, 3]
    while top > 0:
        top -= 1
        node, width, a, b = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        if pool.state[USED] + 8 > pool.boxes.shape[0] - tree.children.shape[0]:
            pool.state[USED] = 0  # nothing is held here: begin the pool anew
            pool.state[MARK] += 1
        for e in range(4):
            ends[e] = _row_at(ta if e < 2 else tb, a if e < 2 else b, node + width * (e & 1), scene, sweep)
        f = width / (1 << MAX_HALVINGS)
        needed = deviation * f * f + limits.margin
        if width < coarse or a != first_a or b != first_b:
            unite_boxes(pool.boxes, ends[0], ends[1], 0.0, united, 0)
            unite_boxes(pool.boxes, ends[2], ends[3], 0.0, united, 1)
            if not boxes_near(united, 0, united, 1, needed):
                continue
        if apart(scene.hulls, ends[0], ends[1], ends[2], ends[3], needed, search):
            continue
        if divided(tree, a, b) >= 0:
            top = _put_children(a, b, node, width, tree, stack, top)
            if top < 0:
                return top
            continue
        turned = motions[ta, ANGLE] * tree.diameters[a] + motions[tb, ANGLE] * tree.diameters[b]
        if 2.0 * deviation * f * f + (0.25 * turned + together) * f <= limits.slack or width == 1:
            return 0
        width //= 2
        for e in range(2):
            ends[e] = _row_at(tb if e else ta, b if e else a, node + width, scene, sweep)
        search.counters[MIDDLES] += 1
        if not apart(scene.hulls, ends[0], ends[0], ends[1], ends[1], limits.pose_margin, search):
            return 0  # the pose in the middle alone is closer than epsilon
        _put(stack, top, node + width, width, a, b)
        _put(stack, top + 1, node, width, a, b)
        top += 2
    return FREE


@lean_kernel
def _height(t, part, level, i, axis, scene, sweep, offset):
    """How far a part reaches along an axis (x, y, z), without its ball, at both ends of interval i of a level."""
    tracks, poses, blocks, count = (
        sweep.tracks.tracks,
        sweep.nodes.poses,
        scene.hulls.blocks,
        scene.hulls.sizes[part],
    )
    joint, frame = scene.groups[JOINT, tracks[GROUP, t]], tracks[FRAME, t]
    if joint == frame:
        k = farthest(blocks, part, count, axis, offset) & 63
        return inner(axis, (blocks[part, 0, k], blocks[part, 1, k], blocks[part, 2, k]))
    moves, greatest = sweep.way.motions[t, PATH] > 0.0, -np.inf
    row = t * COARSE_NODES + (i << (COARSE_LEVELS - level) if moves else 0)
    for end in range(2 if moves else 1):
        at = row + (end << (COARSE_LEVELS - level))
        own = (
            inner((poses[at, 0], poses[at, 3], poses[at, 6]), axis),
            inner((poses[at, 1], poses[at, 4], poses[at, 7]), axis),
            inner((poses[at, 2], poses[at, 5], poses[at, 8]), axis),
        )
        k = farthest(blocks, part, count, own, offset) & 63
        height = inner(own, (blocks[part, 0, k], blocks[part, 1, k], blocks[part, 2, k]))
        greatest = max(greatest, height + inner(axis, (poses[at, 9], poses[at, 10], poses[at, 11])))
    return greatest


@lean_kernel
def _still_apart(ta, a, tb, b, level, i, needed, scene, sweep, search):
    """Whether one axis proves two parts farther apart than is needed: that of the last proof, or `search.axis` at first.

    Only farthest corners are moved, where a search places all of them. So much is asked for that a search would find an
    axis as well: answers do not depend on what is known.
    """
    rounds, known = scene.hulls.rounds, sweep.pool.known[(a * AXES_PER_PART + b) & (KNOWN_AXES - 1)]
    if known[0] == 0.0 and known[1] == 0.0 and known[2] == 0.0:
        known[0], known[1], known[2] = search.axis[0], search.axis[1], search.axis[2]
    square = inner((known[0], known[1], known[2]), (known[0], known[1], known[2]))
    if not 1e-20 < square < 1e20 or rounds[a, DISC] + rounds[b, DISC] > 0.0:
        return False
    scale = 1.0 / np.sqrt(square)
    x, y, z = scale * known[0], scale * known[1], scale * known[2]
    enough = needed + rounds[a, RADIUS] + rounds[b, RADIUS] + KNOWN_SLACK
    gap = -_height(tb, b, level, i, (x, y, z), scene, sweep, search.offset)
    gap -= _height(ta, a, level, i, (-x, -y, -z), scene, sweep, search.offset)
    if gap > enough:
        search.counters[SEARCHES] += 1
        search.counters[ITERATIONS] += 1
        return True
    return False


@lean_kernel
def _pair_hit(ta, tb, limits, scene, sweep, search):
    """The answer of `_parts_hit` for a pair of groups: tests those roots whose boxes meet, interval by interval."""
    motions, tracks, pool, groups = sweep.way.motions, sweep.tracks.tracks, sweep.pool, scene.groups
    united, boxes, margin = pool.united, pool.interval_boxes, limits.margin
    level = level_for(motions[ta, DEVIATION] + motions[tb, DEVIATION], COARSE_DEVIATION)
    first_a, first_b = groups[PARTS, tracks[GROUP, ta]], groups[PARTS, tracks[GROUP, tb]]
    count_a = groups[ROOTS_END, tracks[GROUP, ta]] - first_a
    count_b = groups[ROOTS_END, tracks[GROUP, tb]] - first_b
    width = (1 << MAX_HALVINGS) >> level
    needed = (motions[ta, DEVIATION] + motions[tb, DEVIATION]) / (1 << 2 * level) + margin
    for t in (ta, tb):
        _coarse_poses(t, level, motions[t, PATH] > 0.0, scene, sweep)
    for i in range(1 << level):
        if pool.state[INTERVALS_USED] + count_a + count_b > boxes.shape[0]:
            pool.state[INTERVALS_USED] = 0
            pool.state[INTERVAL_MARK] += 1
        _interval_box(ta, level, i, motions, sweep.nodes.boxes, united, 2)
        _interval_box(tb, level, i, motions, sweep.nodes.boxes, united, 3)
        if not boxes_near(united, 2, united, 3, margin):
            continue
        boxes_a = _interval_parts(ta, level, i, groups, scene.extents.parts, sweep)
        boxes_b = _interval_parts(tb, level, i, groups, scene.extents.parts, sweep)
        for a in range(count_a):
            if not boxes_near(boxes, boxes_a + a, united, 3, margin):
                continue
            for b in range(count_b):
                if not boxes_near(boxes, boxes_a + a, boxes, boxes_b + b, margin):
                    continue
                between(boxes, boxes_a + a, boxes_b + b, search.axis)
                if _still_apart(ta, first_a + a, tb, first_b + b, level, i, needed, scene, sweep, search):
                    continue
                _put(pool.stack, 0, i * width, width, first_a + a, first_b + b)
                found = _parts_hit(ta, tb, width, limits, scene, sweep, search)
                if found != FREE:
                    return found
                known = pool.known[((first_a + a) * AXES_PER_PART + first_b + b) & (KNOWN_AXES - 1)]
                known[0], known[1], known[2] = search.axis[0], search.axis[1], search.axis[2]
    return FREE


@lean_kernel
def _begin(start, end, chain, sweep):
    """Empties all pools, stores both ends of the segment, and sums up how far each joint's frame rotates."""
    state, segment = sweep.pool.state, sweep.way.segment
    state[RUN] += 1
    state[MARK] += 1
    state[INTERVAL_MARK] += 1
    state[USED], state[INTERVALS_USED] = 0, 0
    for i in range(start.shape[0]):
        segment[0, i], segment[1, i] = start[i], end[i]
    turning(sweep.way, chain)


@lean_kernel
def first_swept_hit(start, end, margin, clearance, pairs, scene, sweep, search):
    """The index of the first pair (in the order of groups) that is not proven apart on the segment.

    The result is FREE if all pairs are proven apart, UNUSABLE if `start` or `end` is invalid, and FIRST_OPEN - p or
    less if part p must be divided to decide.
    """
    search.counters[SWEEPS] += 1
    if not (usable(start, scene.chain.bound) and usable(end, scene.chain.bound)):
        return UNUSABLE
    _begin(start, end, scene.chain, sweep)
    tracks, nodes, run = sweep.tracks, sweep.nodes, sweep.pool.state[RUN]
    for p in range(pairs.shape[1]):
        ta, tb = tracks.pair_tracks[0, p], tracks.pair_tracks[1, p]
        for t in (ta, tb):
            if nodes.whole_marks[t] != run:
                nodes.whole_marks[t] = run
                _whole(t, scene, sweep)
        kept = kept_between(tracks.kept, tracks.tracks[GROUP, ta], tracks.tracks[GROUP, tb])
        kept += sweep.way.motions[ta, STRAY] + sweep.way.motions[tb, STRAY]
        if boxes_near(nodes.whole_boxes, ta, nodes.whole_boxes, tb, margin + kept):
            limits = Limits(tracks.slacks[p], tracks.slacks[p] + clearance + kept, margin + kept)
            found = _pair_hit(ta, tb, limits, scene, sweep, search)
            if found != FREE:
                search.counters[POSITIVE] += 1
                return found if found < FREE else pairs[NUMBER, p]
    return FREE


@lean_kernel
def swept_hits(starts, ends, deviations, answers, margin, clearance, pairs, scene, sweep, search):
    """Writes the result of `first_swept_hit` for each segment, whose values are within its deviations.

    The result is the number of segments, up to the first that is not decided.
    """
    strays, count = sweep.way.strays, starts.shape[0]
    for i in range(count):
        for j in range(strays.shape[0]):
            strays[j] = deviations[i, j]
        answers[i] = first_swept_hit(starts[i], ends[i], margin, clearance, pairs, scene, sweep, search)
        if answers[i] < FREE:
            count = i
            break
    for j in range(strays.shape[0]):
        strays[j] = 0.0  # other kernels sweep along segments themselves
    return count
