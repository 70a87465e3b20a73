"""A branch of a plan as geometric states over time: what film strips and animations show, frame by frame.

Nodes follow each other; where the motion of one begins before that of the one before ends (`overlap`), both move.
Objects hang where the hand is when a segment takes them, and the state after a node is the plan's own.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from kabo.plan import Node, Plan, Segment, Step, plan_statistics
from kabo.plan.description import call
from kabo.scene import GeometricState, Scene, with_change, with_hand_action
from kabo.scene.state import Component


@dataclass(frozen=True)
class Frame:
    """A moment of a branch: its node, the time since the node's motion began [s], the state, and a caption."""

    node: str
    time: float
    state: GeometricState
    caption: str


class Film:
    """A branch of a plan, to be asked for states at times."""

    def __init__(self, plan: Plan, scene: Scene, steps: Sequence[Step]) -> None:
        self.plan, self.scene, self.steps = plan, scene, tuple(steps)
        self.start = scene.start if plan.start is None else with_change(scene, scene.start, plan.start)
        self._before: dict[str, GeometricState] = {}
        state = self.start
        for name, _ in self.steps:
            self._before[name] = state
            state = self._after(plan.nodes[name], state)
        self.end = state

    @property
    def moving(self) -> tuple[str, ...]:
        """The nodes of the branch that move something."""
        return tuple(name for name, _ in self.steps if self.plan.nodes[name].motion)

    def duration(self, name: str) -> float:
        """How long the motion of a node takes [s]."""
        return max((segment.times[-1] for segment in self.plan.nodes[name].motion), default=0.0)

    def before(self, name: str) -> GeometricState:
        """The state before a node of the branch."""
        return self._before[name]

    def at(self, name: str, time: float) -> GeometricState:
        """The state at a time since the motion of a node of the branch began [s]."""
        node = self.plan.nodes[name]
        if time >= self.duration(name):
            return self._after(node, self._before[name])
        return self._moved(node, self._before[name], time)

    def shown(self, name: str, time: float) -> GeometricState:
        """The state at a time until the motion of a node ends [s], in which the next node may have begun to move."""
        after = self._overlapping.get(name)
        state, begins = self.at(name, time), self.duration(name) - (0.0 if after is None else after.overlap)
        return state if after is None or time <= begins else self._moved(after, state, time - begins)

    @cached_property
    def _overlapping(self) -> dict[str, Node]:
        """By the name of a node the next one of the branch, if its motion begins early."""
        pairs = ((name, self.plan.nodes[after]) for (name, _), (after, _) in pairwise(self.steps))
        return {name: after for name, after in pairs if after.overlap}

    def key_frames(self) -> Iterator[Frame]:
        """The start, and the state after each node that moves something; captions tell what was sensed between.

        Where only one node moves, as in the plan of a task, the state after each of its stages, too.
        """
        told: list[str] = []
        yield Frame(self.plan.root, 0.0, self.start, "start")
        for name, outcome in self.steps:
            node = self.plan.nodes[name]
            if outcome is not None:
                told.append(f"{node.on}: {outcome}")
            if self.moving == (name,):
                yield from self._after_stages(name)
            if node.motion:
                lines = [*told, f"{name} {call(node)}"]
                yield Frame(name, self.duration(name), self.shown(name, self.duration(name)), "\n".join(lines))
                told = []

    def _after_stages(self, name: str) -> Iterator[Frame]:
        """The state at the end of each stage of a node but the last, when it moves something last."""
        ends: dict[str, float] = {}
        for segment in self.plan.nodes[name].motion:
            stage = segment.stage or segment.procedure
            ends[stage] = max(ends.get(stage, 0.0), segment.times[-1])
        for stage, time in sorted(ends.items(), key=lambda each: each[1])[:-1]:
            yield Frame(name, time, self.shown(name, time), stage)

    def frames(self, step: float) -> Iterator[Frame]:
        """States every `step` seconds of all motions of the branch, and those at the ends of motions."""
        told = ""
        for name, outcome in self.steps:
            node = self.plan.nodes[name]
            if outcome is not None and not node.motion:
                told = f"{node.on}: {outcome}"
                yield Frame(name, 0.0, self.before(name), f"{name} {told}")
            if node.motion:
                # What it does before the node before has ended was shown with that.
                for time in [*np.arange(node.overlap, self.duration(name), step).tolist(), self.duration(name)]:
                    yield Frame(name, time, self.shown(name, time), f"{name} {call(node)}  {time:.1f} s")

    def _after(self, node: Node, state: GeometricState) -> GeometricState:
        moved = self._moved(node, state, np.inf) if node.motion else state
        return moved if node.after is None else with_change(self.scene, moved, node.after)

    def _moved(self, node: Node, state: GeometricState, time: float) -> GeometricState:
        """The state while a node's motion goes on: segments in order of their ends, hands take and let go between."""
        for segment in sorted(node.motion, key=lambda each: each.times[-1]):
            if segment.times[0] <= time:
                state = state.replace({segment.robot: self._configuration(segment, state, time)})
            if segment.times[-1] <= time:
                state = with_hand_action(
                    self.scene, state, segment.robot, detach=segment.detach, attach=segment.attach
                )
        return state

    def _configuration(self, segment: Segment, state: GeometricState, time: float) -> Component:
        robot = self.scene.robots[segment.robot]
        q = list(state.robots[segment.robot])
        for joint, value in zip(segment.joints, segment.at(time).tolist(), strict=True):
            q[robot.joint_names.index(joint)] = value
        return tuple(q)


def described(plan: Plan) -> str:
    """The figures of a plan in a line: nodes, branches, the longest branch."""
    found = plan_statistics(plan)
    branches = "1 branch" if found.plan_leaves == 1 else f"{found.plan_leaves} branches"
    return f"{found.plan_nodes} nodes, {branches}, at most {found.plan_actions} actions"
