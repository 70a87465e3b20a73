"""The way back from the middle of a node to where it began: what was executed, in reverse, proven anew.

A motion that was proven is as free when it is reversed, as long as nothing else has moved; whether something has, the
verifier finds out, as it judges the way back in the scene as it is observed. Where a hand took something, it puts it down.
"""

import hashlib
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from kabo.execution import Executed, Interruption
from kabo.execution.belief import Belief
from kabo.execution.loads import load_of
from kabo.geometry_server import GeometryServer, whole_state
from kabo.motion import Held
from kabo.motion.timed_motion import timed_path
from kabo.options import Options
from kabo.plan import Node, Plan, Segment
from kabo.planner.certify.certifying import certified
from kabo.planner.certify.granting import granted
from kabo.scene import Scene, beginning_at, motion_limits, world_T
from kabo.scene.transforms import inverse

NAME, NODE, GOAL = "undo", "n0", "n1"


class NoWayBackError(Exception):
    """What was executed cannot be reversed; the text says why, as the rest of a sentence."""


def undoing_plan(interruption: Interruption, scene: Scene, *, clearance: float = 0.0) -> Plan:
    """The plan of one node that leads back to where the interrupted node began.

    Args:
        interruption: where the run stands, with what was executed of its node.
        scene: the scene, loaded from a file.
        clearance: what bodies keep from each other [m].

    Raises:
        NoWayBackError: two robots moved at once, or something was let go of that cannot be taken again.
    """
    assert interruption.state.geometry is not None and scene.description is not None
    here = beginning_at(scene, interruption.state.geometry)
    way = _WayBack(interruption, here, Belief(here, here.start))
    motion = tuple(way.segments())
    first, last = here.start, way.belief.state
    changes = {name: q for name, q in last.robots.items() if q != first.robots[name]}
    changes |= {name: own for name, own in last.objects.items() if own != first.objects[name]}  # type: ignore[misc]
    nodes = {
        NODE: Node("action", NAME, next=GOAL, motion=motion, after=whole_state(here, changes)),
        GOAL: Node("goal"),
    }
    options = Options(seed=0, epsilon=here.epsilon, clearance=clearance).written()
    start = whole_state(here, {**first.robots, **first.objects})
    plan = Plan(NAME, _files(here), options, NODE, nodes, start)
    models = {name: body.model for name, body in scene.description.bodies.items()}
    surroundings = GeometryServer(here, clearance=clearance).surroundings
    return certified(granted(plan, here, models), surroundings)[0]


@dataclass
class _WayBack:
    """The segments of a way back, with what hands then hold."""

    interruption: Interruption
    scene: Scene
    belief: Belief
    time: float = 0.0  # [s]
    lost: frozenset[str] = field(init=False)

    def __post_init__(self) -> None:
        self.lost = frozenset(body for body, _ in self.interruption.lost)

    def segments(self) -> Iterator[Segment]:
        """What was executed, the last first, each segment in reverse."""
        executed = self.interruption.executed
        self._require_one_by_one(executed)
        for each in reversed(executed):
            found = self._reversed(self._segment(each), each.until)
            self.belief.finish(found)
            if len(found.waypoints) > 1:
                yield found

    def _segment(self, each: Executed) -> Segment:
        return self.interruption.plan.nodes[each.node].motion[each.segment]

    def _require_one_by_one(self, executed: Sequence[Executed]) -> None:
        spans: dict[str, list[tuple[float, float, str]]] = {}
        for each in executed:
            segment = self._segment(each)
            end = segment.times[-1] if each.until is None else each.until
            spans.setdefault(each.node, []).append((segment.times[0], end, segment.robot))
        if len(spans) > 1 and any(self.interruption.plan.nodes[node].overlap > 0.0 for node in spans):
            raise NoWayBackError("several nodes had begun at once")
        for own in spans.values():
            own.sort()
            for (_, end, robot), (begin, _, other) in zip(own, own[1:], strict=False):
                if begin < end - 1e-9 and robot != other:
                    raise NoWayBackError("two robots moved at once")

    def _reversed(self, segment: Segment, until: float | None) -> Segment:
        robot = self.scene.robots[segment.robot]
        passed = [
            row
            for row, time in zip(segment.waypoints, segment.times, strict=True)
            if until is None or time < until
        ]
        q = self.belief.state.robots[segment.robot]
        here = tuple(q[robot.joint_names.index(joint)] for joint in segment.joints)
        corners = _distinct([here, *reversed(passed)])
        holds = {name for name in self.scene.movable if self.belief.holder(name) == segment.robot}
        took = tuple(name for name, _ in segment.attach if until is None and name in holds)
        held = [self._held(segment.robot, name) for name in self.scene.movable] if corners.shape[0] > 1 else []
        loads = [each for each in held if each is not None]
        arm = segment.joints == robot.planned_joints
        timed = timed_path(
            corners,
            motion_limits(robot, segment.joints),
            held=min(loads, key=lambda each: each.acceleration) if loads and arm else None,
        )
        attach = tuple(self._taken_again(segment, name) for name in segment.detach if until is None)
        handled = holds | {name for name, _ in attach}
        begin, self.time = self.time, self.time + timed.duration
        last = len(timed.waypoints) - 1
        trajectory = timed.trajectory(segment.joints, start=begin) if last else None
        self.time = self.time if trajectory is None else trajectory.times[-1]
        return replace(
            segment,
            waypoints=tuple(tuple(map(float, row)) for row in timed.waypoints),
            times=timed.passed(0, last, start=begin),
            trajectory=trajectory,
            attach=attach,
            detach=took,
            allowed_contacts=tuple(pair for pair in segment.allowed_contacts if handled & set(pair)),
            grants=(),
            procedure=NAME,
            stage=None,
            constraint=None,
        )

    def _held(self, robot: str, name: str) -> Held | None:
        """What limits a robot that holds a body; None if it does not hold it."""
        own = self.scene.robots[robot]
        if self.belief.holder(name) != robot or own.tool is None:
            return None
        state = self.belief.state
        hand = world_T(self.scene, state, f"{robot}.{own.tool.frame}")
        place = (inverse(hand) @ world_T(self.scene, state, name))[:3, 3]
        return load_of(self.scene, robot, state.robots[robot], place, self.scene.bodies[name].mass)

    def _taken_again(self, segment: Segment, name: str) -> tuple[str, str]:
        tool = self.scene.robots[segment.robot].tool
        if tool is None or name in self.lost:
            raise NoWayBackError(f"{segment.robot} has let go of {name}")
        return name, f"{segment.robot}.{tool.frame}"


def _distinct(rows: Sequence[Sequence[float]]) -> np.ndarray:
    """Rows (m, n) without those that equal the one before."""
    found = [np.round(np.array(rows[0]), 9)]
    for row in rows[1:]:
        other = np.round(np.array(row), 9)
        if np.abs(other - found[-1]).max() > 1e-9:
            found.append(other)
    return np.array(found)


def _files(scene: Scene) -> dict[str, str]:
    """The hashes of the scene's files, by their paths relative to its folder, as plans of tasks have them."""
    assert scene.description is not None
    path = scene.description.path
    read = {
        Path(os.path.relpath(each.resolve(), path.resolve().parent)).as_posix(): digest
        for each, digest in scene.files.items()
    }
    return {path.name: "sha256:" + hashlib.sha256(path.read_bytes()).hexdigest(), **read}
