"""Tracks: how a group moves in the frame of a joint during a straight joint-space segment, and where it is at a node.

A pair of groups is swept in the frame of the last joint that carries both, so that only the joints between them count:
for links of one arm that is the first link's joint, for an arm and the table, or two arms, it is the world.

A segment q(t) = q0 + t (q1 - q0) has 2^20 intervals; node i lies at t = i / 2^20. Nodes on the coarse grid of 32
intervals keep their poses and boxes during one sweep.
"""

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.boxes import place_box, unite_boxes
from kabo.scene.kernels.poses import forward_kinematics

MAX_HALVINGS = 20  # of a segment; it has 2^MAX_HALVINGS + 1 nodes
COARSE_LEVELS = 5  # levels of the coarse grid
COARSE_NODES = (1 << COARSE_LEVELS) + 1
FRAME_SLOTS = COARSE_NODES + MAX_HALVINGS - COARSE_LEVELS  # one of each coarse node, and one of each finer level


@lean_kernel  # Way, Chain
def turning(way, chain):
    """Writes for every joint the sum of |angle| over the revolute joints from the world to this joint."""
    segment, turned, joints, factors = way.segment, way.turned, chain.joints, chain.factors
    turned[0] = 0.0
    for j in range(1, turned.shape[0]):
        i = joints[2, j]
        step = abs(factors[0, j] * (segment[1, i] - segment[0, i])) if joints[1, j] == 0 else 0.0
        turned[j] = turned[joints[0, j]] + step


@lean_kernel  # Way, Chain, i8, i8, f8 -> f8, f8, f8, f8
def motion(way, chain, joint, frame, radius):
    """Bounds over the whole segment for points within `radius` of the joint's origin, seen from `frame`.

    The bounds are the deviation from the chord, |x - c| <= max |x''| / 8, the angle turned, and the length of the
    path. With d_j = |joint step|, rho_j a bound of the distance to axis j and T_j the sum of d over revolute
    joints between the frame and j: |x''| <= sum over revolute j of rho_j d_j (d_j + 2 T_j), plus sum over
    prismatic j of 2 d_j T_j. With one radius for all joints this is [K Eq. 4.20].

    The fourth bound is the stray, how far a point may be from where it is on the segment: where each joint may be
    off the segment by s_j, it is the sum of rho_j s_j over revolute and of s_j over prismatic joints.
    """
    segment, turned, joints, factors = way.segment, way.turned, chain.joints, chain.factors
    strays = way.strays
    bend, path, stray, reach, j = 0.0, 0.0, 0.0, radius, joint
    while j != frame:
        i, parent = joints[2, j], joints[0, j]
        before = max(0.0, turned[parent] - turned[frame])
        start, end = factors[0, j] * segment[0, i] + factors[1, j], factors[0, j] * segment[1, i] + factors[1, j]
        step, off = abs(end - start), abs(factors[0, j]) * strays[i]
        if joints[1, j] == 0:
            bend += reach * step * (step + 2.0 * before)
            path += reach * step
            stray += reach * off
        else:
            bend += 2.0 * step * before
            path += step
            stray += off
            reach += max(abs(start), abs(end)) + off
        reach += way.lengths[j]
        j = parent
    angle = max(0.0, turned[joint] - turned[frame])
    return 0.125 * bend * (1.0 + 1e-12), angle * (1.0 + 1e-12), path * (1.0 + 1e-12), stray * (1.0 + 1e-12)


@lean_kernel  # f8, f8 [m] -> i8
def level_for(deviation, enough):
    """The number of halvings of the segment, at most to the coarse grid, until the deviation is at most `enough`."""
    level = 0
    while deviation > enough and level < COARSE_LEVELS:
        deviation *= 0.25
        level += 1
    return level


@lean_kernel  # i8, i8, Way, Chain -> i8
def frames_at(node, run, way, chain):
    """The slot of `way.frames` (FRAME_SLOTS, J, 12) that holds all joint frames at a node, computed on first use.

    Finer nodes share a slot with all nodes of their level; the two ends of a dyadic interval and its middle never do.
    """
    slot, bit = node >> (MAX_HALVINGS - COARSE_LEVELS), 1 << (MAX_HALVINGS - COARSE_LEVELS)
    if node & (bit - 1):
        slot, bit = COARSE_NODES, bit >> 1
        while node & (bit - 1):
            slot, bit = slot + 1, bit >> 1
    tag = run * (1 << (MAX_HALVINGS + 1)) + node
    if way.tags[slot] != tag:
        way.tags[slot] = tag
        t, segment, joints, factors = node / (1 << MAX_HALVINGS), way.segment, chain.joints, chain.factors
        for i in range(segment.shape[1]):
            segment[2, i] = segment[0, i] + t * (segment[1, i] - segment[0, i])
        forward_kinematics(
            segment[2], joints[0], joints[1], joints[2], factors[0], factors[1], chain.placement, way.frames[slot]
        )
    return slot


@lean_kernel  # (J, 12) f8, i8, i8 -> writes row of (.., 12) f8
def pose_in(world_T, joint, frame, poses, row):
    """Writes the pose frame_T_joint of joint `joint` in the frame of joint `frame`."""
    if frame == 0:
        for i in range(12):
            poses[row, i] = world_T[joint, i]
        return
    for c in range(3):
        for r in range(3):
            poses[row, 3 * r + c] = (
                world_T[frame, r] * world_T[joint, c]
                + world_T[frame, 3 + r] * world_T[joint, 3 + c]
                + world_T[frame, 6 + r] * world_T[joint, 6 + c]
            )
    x, y, z = (
        world_T[joint, 9] - world_T[frame, 9],
        world_T[joint, 10] - world_T[frame, 10],
        world_T[joint, 11] - world_T[frame, 11],
    )
    for r in range(3):
        poses[row, 9 + r] = world_T[frame, r] * x + world_T[frame, 3 + r] * y + world_T[frame, 6 + r] * z


@lean_kernel  # i8, i8, f8, bool, Nodes
def whole_box(track, level, grow, moves, nodes):
    """Writes the box around the volume that a track's group sweeps, from its boxes at the coarse nodes of a level."""
    first, whole_boxes = track * COARSE_NODES, nodes.whole_boxes
    unite_boxes(nodes.boxes, first, first, grow, whole_boxes, track)
    if moves:
        stride = 1 << (COARSE_LEVELS - level)
        for c in range(stride, COARSE_NODES, stride):
            for r in range(3):
                whole_boxes[track, r] = min(whole_boxes[track, r], nodes.boxes[first + c, r] - grow)
                whole_boxes[track, 3 + r] = max(whole_boxes[track, 3 + r], nodes.boxes[first + c, 3 + r] + grow)


@lean_kernel
def interval_parts(first, end, part_extents, poses, row0, row1, grow, pool, start):
    """Writes the boxes of parts first..end over an interval, from the poses at its ends, grown by the deviation."""
    united, boxes = pool.united, pool.interval_boxes
    for p in range(first, end):
        place_box(poses, row0, part_extents, p, united, 0)
        if row1 != row0:
            place_box(poses, row1, part_extents, p, united, 1)
            unite_boxes(united, 0, 1, grow, boxes, start + p - first)
        else:
            unite_boxes(united, 0, 0, grow, boxes, start + p - first)


@lean_kernel  # i8, i8, (H,) i8, (H,) i8 -> i8
def look_up(key, mark, keys, marks):
    """The index of a key in an open-addressing hash table with 2^k slots, or the free slot where it belongs."""
    place = (key ^ (key >> 15) ^ (key >> 23)) & (keys.shape[0] - 1)
    while marks[place] == mark and keys[place] != key:
        place = (place + 1) & (keys.shape[0] - 1)
    return place
