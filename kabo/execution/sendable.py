"""Whether the motions of a plan can be sent at all: joints do not jump, and stay where they can be.

A plan that was verified has no such fault. One that was edited by hand and is carried out without being verified may have:
whatever else it does, no robot is sent a setpoint out of its reach. `kabo verify` proves more, exactly; this takes some
milliseconds, and stands between a file and a robot where nobody has verified.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from kabo.motion.bernstein import derivative, values
from kabo.plan import Plan, Segment, StateChange, topological_order
from kabo.scene import Robot, Scene

JUMP = 1e-6  # rad or m, and each of it a second: plans are rounded to a thousandth of that
BEYOND = 1e-3  # rad or m: bounds of polynomials may be beyond limits by less than that
WHAT = "", "the velocity of "

_Values = dict[tuple[str, str], float]  # of each joint of each robot


def unsendable(plan: Plan, scene: Scene) -> Iterator[str]:
    """Sentences that tell which joint jumps where, or leaves its limits of position."""
    begins: dict[str, _Values] = {plan.root: _said(plan.start)}
    for name in topological_order(plan) or ():
        node, now = plan.nodes[name], dict(begins.get(name, {}))
        for number in sorted(range(len(node.motion)), key=lambda k: node.motion[k].times[0]):
            segment = node.motion[number]
            robot = scene.robots[segment.robot]
            for fault in (*_begins(segment, now), *_inside(segment), *_beyond(segment, robot)):
                yield f"{name}: segment {number}: {fault}"
            now.update(zip(_keys(segment), segment.waypoints[-1], strict=True))
        now |= _said(node.after)
        for following in node.successors:
            begins.setdefault(following, now)


def _said(change: StateChange | None) -> _Values:
    robots = {} if change is None else change.robots
    return {(robot, joint): value for robot, joints in robots.items() for joint, value in joints.items()}


def _keys(segment: Segment) -> Sequence[tuple[str, str]]:
    return [(segment.robot, joint) for joint in segment.joints]


def _begins(segment: Segment, now: _Values) -> Iterator[str]:
    """That a segment begins where its robot is not, or its path ends where its trajectory does not."""
    assert segment.trajectory is not None
    with np.errstate(all="ignore"):
        first, last = (segment.trajectory.at(segment.trajectory.times[k]).tolist() for k in (0, -1))
    for key, begin, end, goal in zip(_keys(segment), first, last, segment.waypoints[-1], strict=True):
        if not abs(begin - now.get(key, begin)) <= JUMP:
            yield f"it begins with {key[1]} of {key[0]} at {begin:.6g}, which is at {now[key]:.6g} before"
        if not abs(end - goal) <= JUMP:
            yield f"it ends with {key[1]} of {key[0]} at {end:.6g}, and its path at {goal:.6g}"


def _inside(segment: Segment) -> Iterator[str]:
    """Where a joint jumps, or its velocity, between two pieces of a segment."""
    found = segment.trajectory
    assert found is not None
    if len(found.padded) < 2:
        return
    for order, what in enumerate(WHAT):
        with np.errstate(all="ignore"):
            pieces = derivative(found.padded, order)
            jumps = np.abs(values(pieces[:-1], found.spans[:-1, None]) - pieces[1:, :, 0])
        wrong = ~(jumps <= JUMP)
        if wrong.any():
            piece, joint = (int(k) for k in np.argwhere(wrong)[0])
            how = f"by {jumps[piece, joint]:.3g} at {found.times[piece + 1]:.3f} s"
            yield f"{what}{segment.joints[joint]} of {segment.robot} jumps {how}"


def _beyond(segment: Segment, robot: Robot) -> Iterator[str]:
    """That a joint leaves its limits of position."""
    assert segment.trajectory is not None
    with np.errstate(all="ignore"):
        low, high = segment.trajectory.bounds()
    for joint, least, most in zip(segment.joints, low, high, strict=True):
        place = robot.joint_names.index(joint)
        lower, upper = robot.tree.lower[place], robot.tree.upper[place]
        if not (lower - BEYOND <= least and most <= upper + BEYOND):
            told = f"goes from {least:.6g} to {most:.6g}, outside its limits {lower:.6g} to {upper:.6g}"
            yield f"{joint} of {segment.robot} {told}"
