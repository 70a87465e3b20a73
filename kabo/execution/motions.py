"""What a robot is given to follow: the trajectories of a node, and of nodes that overlap it, on one clock.

Where all robots rest and a hand takes or lets go, the motion is divided: the next part begins when the hand has done so.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kabo.arrays import Array
from kabo.motion import Trajectory
from kabo.motion.kernels.deviations import positions_at
from kabo.plan import Plan, Segment
from kabo.scene import Robot, Scene

SAME_TIME = 1e-9  # [s]


@dataclass(frozen=True)
class Stretch:
    """A segment of a plan on the clock of the whole motion."""

    node: str
    segment: int
    robot: str
    trajectory: Trajectory
    permitted: tuple[tuple[str, str], ...] = ()  # contacts

    @property
    def begin(self) -> float:
        """When it begins [s]."""
        return self.trajectory.times[0]

    @property
    def end(self) -> float:
        """When it ends [s]."""
        return self.trajectory.times[-1]


@dataclass(frozen=True)
class HandAction:
    """What a hand does at a time [s]: `grip` what its segment takes, `release` it, or let go of it in the state only.

    What it lets go of may be joined to another body from then on: then `attach` has both, and no hand presses. An action
    that `begins` its segment belongs to what comes after it: a giver opens when the other hand has closed, and is judged.
    """

    time: float
    kind: str  # "grip", "release" or "detach"
    robot: str
    node: str
    segment: int
    attach: tuple[tuple[str, str], ...] = ()
    detach: tuple[str, ...] = ()
    begins: bool = False


@dataclass(frozen=True)
class Motion:
    """Stretches in the order of their beginnings, what hands do meanwhile, and the nodes that end with it.

    Times count from the beginning of the first node of the motion [s].
    """

    stretches: tuple[Stretch, ...]
    actions: tuple[HandAction, ...]
    nodes: tuple[str, ...]
    begin: float
    end: float

    def at(self, time: float) -> Iterator[Stretch]:
        """The stretches that run at a time."""
        return (each for each in self.stretches if each.begin - SAME_TIME <= time <= each.end + SAME_TIME)

    def rows(self, robot: Robot, resting: Sequence[float], times: Array) -> Array:
        """The values (k, n) of all joints of a robot by the plan at times (k,) in order: `resting` before."""
        rows = np.empty((len(times), len(resting)))
        rows[:] = resting
        for each in self.stretches:
            begin = each.begin - SAME_TIME
            if each.robot != robot.name or times[-1] < begin:
                continue
            columns, trajectory = robot.columns(each.trajectory.joints), each.trajectory
            if each.end <= times[0]:
                rows[:, columns] = trajectory.waypoints[-1]
            else:
                begun = 0 if times[0] >= begin else int(np.searchsorted(times, begin))
                inside = np.minimum(np.maximum(times[begun:], each.begin), each.end)
                rows[begun:, columns] = positions_at(trajectory.knots, trajectory.padded, inside)
        return rows

    def rests(self, time: float) -> bool:
        """Whether no robot moves at a time."""
        return not any(each.begin + SAME_TIME < time < each.end - SAME_TIME for each in self.stretches)


def motion_of(plan: Plan, name: str, scene: Scene) -> Motion:
    """The motion of a node, and of the nodes after it as long as each begins before the one before it has ended.

    Raises:
        ValueError: a segment has no trajectory: the plan is of the format `kabo-plan/1`.
    """
    stretches: list[Stretch] = []
    actions: list[HandAction] = []
    nodes: list[str] = []
    offset = end = 0.0
    while True:
        node = plan.nodes[name]
        nodes.append(name)
        for number, segment in enumerate(node.motion):
            if segment.trajectory is None:
                raise ValueError(
                    f"{name} has no trajectory: plan it anew, plans of the format kabo-plan/1 cannot be sent"
                )
            shifted = segment.trajectory.shifted(offset)
            stretches.append(Stretch(name, number, segment.robot, shifted, segment.allowed_contacts))
        actions += _hand_actions(name, node.motion, offset, scene)
        end = max([end, *(each.end for each in stretches)])
        following = None if node.next is None else plan.nodes[node.next]
        if node.next is None or following is None or not following.overlap > 0.0:
            break
        offset, name = end - following.overlap, node.next
    order = {"detach": 0, "grip": 1, "release": 2}
    actions.sort(key=lambda each: (each.time, order[each.kind]))
    stretches.sort(key=lambda each: each.begin)
    return Motion(tuple(stretches), tuple(actions), tuple(nodes), 0.0, end)


def _hand_actions(name: str, motion: Sequence[Segment], offset: float, scene: Scene) -> Iterator[HandAction]:
    for number, segment in enumerate(motion):
        begin, end = segment.times[0] + offset, segment.times[-1] + offset
        joined = tuple(pair for pair in segment.attach if pair[1].partition(".")[0] != segment.robot)
        taken = tuple(pair for pair in segment.attach if pair not in joined)
        if segment.detach:
            # A hand that opens presses no more from then on; the object is let go of when it is open.
            opens = set(segment.joints) & set(scene.robots[segment.robot].gripper_joints)
            time, begins = (begin, True) if opens else (end, False)
            yield HandAction(time, "release", segment.robot, name, number, (), segment.detach, begins)
        if segment.detach or joined:
            yield HandAction(end, "detach", segment.robot, name, number, joined, segment.detach)
        if taken:
            yield HandAction(end, "grip", segment.robot, name, number, taken)


def parts_of(motion: Motion) -> list[Motion]:
    """The motion divided where hands act while no robot moves; an action belongs to the part that it ends, or begins."""
    borders = sorted({each.time for each in motion.actions if motion.rests(each.time)} | {motion.end})
    parts: list[Motion] = []
    begin = motion.begin
    for border in borders:
        inside = tuple(s for s in motion.stretches if s.begin >= begin - SAME_TIME and s.end <= border + SAME_TIME)
        own = tuple(each for each in motion.actions if _is_within(each, begin, border, motion, first=not parts))
        if inside or own:
            parts.append(replace(motion, stretches=inside, actions=own, begin=begin, end=border))
        begin = border
    return parts


def _is_within(action: HandAction, begin: float, end: float, motion: Motion, *, first: bool) -> bool:
    """Whether a hand acts in a part of a motion from `begin` to `end` [s], the `first` one or another."""
    if action.begins and action.time < motion.end - SAME_TIME:
        return begin - SAME_TIME <= action.time < end - SAME_TIME
    return (first or action.time > begin + SAME_TIME) and action.time <= end + SAME_TIME
