"""Plans with trajectories, made by hand: from rest to rest at every way point, by the quintic of least jerk.

The quintic 10 u^3 - 15 u^4 + 6 u^5 goes from 0 to 1 [Flash, Hogan 1985]; PEAKS are the sizes of its derivatives.
"""

from dataclasses import replace

import numpy as np

from kabo.motion import Trajectory
from kabo.plan import Node, Plan, Segment
from kabo.scene import Robot, Scene

PEAKS = (1.875, 10.0 / np.sqrt(3.0), 60.0)


def limits_of(robot: Robot) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Velocity, acceleration and jerk, as docs/reference/scenes.md says."""
    velocity = np.array(robot.tree.velocity)
    names = robot.joint_names
    acceleration = np.array([robot.acceleration.get(n, v / 0.25) for n, v in zip(names, velocity, strict=True)])
    return velocity, acceleration, acceleration / 0.05


def needed(segment: Segment, robot: Robot) -> np.ndarray:
    """The time that each piece of a segment's path takes from rest to rest (m - 1,) [s]."""
    index = [robot.joint_names.index(joint) for joint in segment.joints]
    ways = np.abs(np.diff(np.array(segment.waypoints), axis=0))
    times = [
        (peak * ways / limit[index]) ** (1.0 / (order + 1))
        for order, (peak, limit) in enumerate(zip(PEAKS, limits_of(robot), strict=True))
    ]
    return np.max(times, axis=(0, 2))


def quintics(segment: Segment, times: tuple[float, ...]) -> Trajectory:
    """The trajectory that rests at every way point, which it passes at `times`."""
    rows, pieces = np.array(segment.waypoints), []
    for a, b, span in zip(rows, rows[1:], np.diff(times), strict=False):
        scale = [0.0, 0.0, 0.0, 10.0 / span**3, -15.0 / span**4, 6.0 / span**5]
        piece = []
        for x, way in zip(a, b - a, strict=True):
            powers = [x, 0.0, 0.0, *(way * s for s in scale[3:])]
            piece.append(tuple(powers) if way else (x,))
        pieces.append(tuple(piece))
    return Trajectory(segment.joints, segment.waypoints, times, tuple(pieces), 1e-9)


def smooth_node(node: Node, scene: Scene, share: float = 0.99) -> Node:
    """The node with trajectories that use this share of the limits at most.

    Where segments overlap in time or a pause follows, its time is stretched as a whole; else each piece takes its time.
    """
    if not node.motion:
        return node
    spans = [needed(segment, scene.robots[segment.robot]) / share**0.3 for segment in node.motion]
    ends = [segment.times for segment in node.motion]
    if all(a[-1] == b[0] for a, b in zip(ends, ends[1:], strict=False)):
        motion, start = [], 0.0
        for segment, span in zip(node.motion, spans, strict=True):
            steps = np.concatenate([[0.0], np.cumsum(np.maximum(span, 0.001))])
            motion.append(_timed(segment, start + steps))
            start = motion[-1].times[-1]
        return replace(node, motion=tuple(motion))
    factor = max(float((span / np.diff(own)).max()) for span, own in zip(spans, ends, strict=True))
    motion = [_timed(segment, np.array(segment.times) * factor) for segment in node.motion]
    return replace(node, motion=tuple(motion), overlap=round(node.overlap * factor, 6))


def _timed(segment: Segment, times: np.ndarray) -> Segment:
    told = tuple(float(t) for t in np.round(times, 6))
    return replace(segment, times=told, trajectory=quintics(segment, told))


def smooth(plan: Plan, scene: Scene) -> Plan:
    """The plan with a trajectory on every segment, of deviation 0 (stated as 1e-9)."""
    return replace(plan, nodes={name: smooth_node(node, scene) for name, node in plan.nodes.items()})
