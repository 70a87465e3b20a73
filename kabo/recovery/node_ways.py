"""The way out of the middle of a node: on to its end, or back to where it began, along its own path, proven anew.

A motion that was proven is as free when the rest of it begins at rest, or when it is reversed, as long as nothing else has
moved. Whether something has, the verifier finds out: it judges the way in the scene as it is observed. Going back, a hand
puts down what it has taken. A hand with something between its fingers, lost or half taken, opens where it is first: until
it is open it is said to hold what stands there, as only what a hand holds may touch its fingers; the arm rests meanwhile.
What another hand gives is said to be in that one again before the first one opens.
Robots that have moved at once go on, or back, one after the other.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from kabo.arrays import Array
from kabo.execution import Executed, Interruption
from kabo.execution.belief import Belief
from kabo.execution.interruptions import WELL_HELD, begun_nodes
from kabo.execution.loads import load_of
from kabo.execution.motions import motion_of
from kabo.geometry_server import GeometryServer, whole_state
from kabo.geometry_server.foresight.starts import start_faults
from kabo.language import recorded_files
from kabo.motion import Held
from kabo.motion.timed_motion import timed_path
from kabo.motion.trajectory import Trajectory
from kabo.options import Options
from kabo.plan import Node, Plan, Segment
from kabo.planner.certify.certifying import certified
from kabo.planner.certify.granting import granted
from kabo.recovery.known_parts import certificate_with_parts
from kabo.scene import Component, Scene, attachment, beginning_at, motion_limits, with_change, world_T
from kabo.scene.transforms import inverse

NODE, GOAL = "n0", "n1"
REGRIP = 0.1  # [s] for which a hand that gives something stands still while it presses on it again


class NoWayError(Exception):
    """There is no way; the text says why, as the rest of a sentence."""


def way_on(
    interruption: Interruption, scene: Scene, *, clearance: float = 0.0, shifted_in_hands: bool = False
) -> Plan:
    """The plan of one node that makes the rest of the motion of the interrupted node, or of all that have begun.

    Args:
        interruption: where the run stands, with what was executed of its node.
        scene: the scene, loaded from a file.
        clearance: what bodies keep from each other [m].
        shifted_in_hands: whether what is in the right hand may be elsewhere in it: what is known of it is true then, too.

    Raises:
        NoWayError: a hand has lost what it should hold, or something would not be where the plan puts it.
    """
    return _Way(interruption, scene, clearance).on(shifted_in_hands=shifted_in_hands)


def way_back(
    interruption: Interruption, scene: Scene, *, clearance: float = 0.0, between: Mapping[str, str] = {}
) -> Plan:
    """The plan of one node that leads back to where the interrupted node began; arguments as of `way_on`.

    Args:
        interruption: where the run stands. scene: the scene. clearance: as of `way_on`.
        between: bodies that stand between the fingers of a robot's hand, which opens first.

    Raises:
        NoWayError: a hand that is to open is open, or holds something else.
    """
    return _Way(interruption, scene, clearance, between).back()


def way_open(
    interruption: Interruption, scene: Scene, between: Mapping[str, str], *, clearance: float = 0.0
) -> Plan:
    """The plan of one node in which hands open, and nothing else moves; arguments as of `way_back`.

    Raises:
        NoWayError: a hand is open, or holds something else, or touches something when it is open.
    """
    return _Way(interruption, scene, clearance, between).only_open()


class _Way:
    """Segments in the order of time, with what hands then hold."""

    def __init__(
        self, interruption: Interruption, scene: Scene, clearance: float, between: Mapping[str, str] = {}
    ) -> None:
        assert interruption.state.geometry is not None and scene.description is not None
        self.interruption, self.clearance = interruption, clearance
        self.executed, self.between = interruption.executed, between
        self.scene = _with_held(beginning_at(scene, interruption.state.geometry), between)
        self.belief = Belief(self.scene, self.scene.start)
        self.hands = {body: interruption.state.geometry.objects[body].parent for body in between}  # of givers
        self.time = 0.0  # [s]

    def on(self, *, shifted_in_hands: bool) -> Plan:
        """The rest of the node's motion."""
        if self.interruption.lost:
            raise NoWayError(f"{self.interruption.lost[0][1]} has lost {self.interruption.lost[0][0]}")
        plan = self.interruption.plan
        begun = begun_nodes(plan, self.executed)
        motion = (s for s in motion_of(plan, begun[0], self.scene).stretches if s.node in begun)
        done = {(each.node, each.segment): each.until for each in self.executed}
        rest = []
        for each in sorted(
            motion, key=lambda each: each.end
        ):  # robots that moved at once move one after the other
            key, segment = (each.node, each.segment), plan.nodes[each.node].motion[each.segment]
            if key in done and done[key] is None:
                continue
            after = done.get(key)
            rows = [
                row
                for row, time in zip(segment.waypoints, segment.times, strict=True)
                if after is None or time > after
            ]
            rest.append(self._segment(segment, rows, segment.attach, segment.detach))
        for name in begun:
            self._require_placed(name, shifted_in_hands=shifted_in_hands)
        return self._plan("finish", rest)

    def _require_placed(self, node: str, *, shifted_in_hands: bool) -> None:
        """Checks that everything is where the node puts it, so that what is then known of it is true."""
        after, plan = self.interruption.plan.nodes[node].after, self.interruption.plan
        if after is None or plan.start is None:
            return
        wanted = with_change(self.scene, self.belief.state, after)
        for name in after.objects:
            if (
                shifted_in_hands
                and wanted.objects[name].parent == self.belief.state.objects[name].parent != "world"
            ):
                continue
            place, found = (world_T(self.scene, state, name)[:3, 3] for state in (wanted, self.belief.state))
            if float(np.linalg.norm(place - found)) > WELL_HELD:
                raise NoWayError(f"{name} would not be where the node puts it")

    def back(self) -> Plan:
        """The executed part of the node's motion, the last segment first, each in reverse."""
        lost, given_back = {body for body, _ in self.interruption.lost}, set[str]()
        motion = self._opening()
        for each in reversed(self.executed):
            segment, whole = self._planned(each), each.until is None
            rows = [
                row
                for row, time in zip(segment.waypoints, segment.times, strict=True)
                if each.until is None or time < each.until
            ]
            if segment.joints != self.scene.robots[segment.robot].planned_joints:
                rows = rows[:1]  # where a hand is now, it may be beyond where it was sent
            holds = self._holds(segment.robot)
            took = tuple(name for name, _ in segment.attach if whole and name in holds | given_back)
            gave = [name for name in segment.detach if whole and name not in holds]
            tool = self.scene.robots[segment.robot].tool
            if gave and (tool is None or lost & set(gave)):
                raise NoWayError(f"{segment.robot} has let go of {gave[0]}")
            attach = tuple((name, f"{segment.robot}.{tool.frame}") for name in gave) if tool is not None else ()
            given_back |= {name for name in gave if self.belief.holder(name) is not None}
            motion.append(self._segment(segment, rows[::-1], attach, took))
        return self._plan("undo", motion)

    def only_open(self) -> Plan:
        """Hands open where they are."""
        plan = self._plan("undo", self._opening())
        faults = start_faults(
            GeometryServer(replace(self.scene, start=self.belief.state)).surroundings, parts=False
        )
        touching = [
            fault for fault in faults if set(self.between.values()) & {t.partition(".")[0] for t in fault.things}
        ]
        if touching:
            raise NoWayError(touching[0].said)
        return plan

    def _opening(self) -> list[Segment]:
        """Hands with something between their fingers open, one after the other."""
        found = []
        for name in dict.fromkeys(self.between.values()):
            robot, bodies = self.scene.robots[name], [b for b, by in self.between.items() if by == name]
            gripper, q = robot.gripper, self.belief.state.robots[name]
            assert gripper is not None
            if others := self._holds(name) - set(bodies):
                raise NoWayError(f"{name} holds {min(others)}")
            now = dict(zip(robot.joint_names, q, strict=True))
            row = tuple(gripper.open.get(joint, now[joint]) for joint in robot.gripper_joints)
            if np.allclose(row, [now[joint] for joint in robot.gripper_joints]):
                raise NoWayError(f"the hand of {name} is open")
            found += [self._given_back(body) for body in bodies if self.hands[body] != "world"]
            pairs = tuple((link, body) for body in bodies for link in gripper.touch_links)
            here = tuple(now[joint] for joint in robot.gripper_joints)
            planned = Segment(name, robot.gripper_joints, (here,), (0.0,), "undo", allowed_contacts=pairs)
            found.append(self._segment(planned, [row], (), tuple(bodies)))
        return found

    def _given_back(self, body: str) -> Segment:
        """A moment in which the hand that gives a body presses on it again, and nothing moves: from then on it has it."""
        parent = self.hands[body]
        giver = parent.partition(".")[0]
        robot, q = self.scene.robots[giver], self.belief.state.robots[giver]
        assert robot.gripper is not None
        joints = robot.gripper_joints
        here = tuple(q[robot.joint_names.index(joint)] for joint in joints)
        times = (self.time, round(self.time + REGRIP, 6))
        made = Segment(
            robot.name,
            joints,
            (here, here),
            times,
            "undo",
            attach=((body, parent),),
            allowed_contacts=tuple((link, body) for link in robot.gripper.touch_links),
            trajectory=Trajectory.linear(joints, (here, here), times),
        )
        self.time = times[-1]
        self.belief.finish(made)
        return made

    def _planned(self, each: Executed) -> Segment:
        return self.interruption.plan.nodes[each.node].motion[each.segment]

    def _holds(self, robot: str) -> set[str]:
        return {name for name in self.scene.movable if self.belief.holder(name) == robot}

    def _segment(
        self,
        planned: Segment,
        rows: Sequence[Sequence[float]],
        attach: tuple[tuple[str, str], ...],
        detach: tuple[str, ...],
    ) -> Segment:
        """A segment along way points, from where its robot is; it rests at each of them."""
        name, robot = planned.robot, self.scene.robots[planned.robot]
        q, holds = self.belief.state.robots[name], self._holds(name)
        here = tuple(q[robot.joint_names.index(joint)] for joint in planned.joints)
        loads = [each for body in holds if (each := self._load(name, body)) is not None]
        heaviest = min(loads, key=lambda each: each.acceleration, default=None)
        arm = planned.joints == robot.planned_joints
        timed = timed_path(
            _distinct([here, *rows]), motion_limits(robot, planned.joints), held=heaviest if arm else None
        )
        last, handled = len(timed.waypoints) - 1, holds | {body for body, _ in attach} | {*detach}
        trajectory = timed.trajectory(planned.joints, start=self.time) if last else None
        made = replace(
            planned,
            waypoints=tuple(tuple(map(float, row)) for row in timed.waypoints),
            times=timed.passed(0, last, start=self.time),
            trajectory=trajectory,
            attach=attach,
            detach=detach,
            allowed_contacts=tuple(pair for pair in planned.allowed_contacts if handled & set(pair)),
            grants=(),
            stage=None,
            constraint=planned.constraint if holds else None,
        )
        self.time = self.time if trajectory is None else trajectory.times[-1]
        self.belief.finish(made)
        return made

    def _load(self, robot: str, name: str) -> Held | None:
        """What limits a robot that holds a body."""
        own = self.scene.robots[robot]
        if own.tool is None:
            return None
        state = self.belief.state
        hand = world_T(self.scene, state, f"{robot}.{own.tool.frame}")
        place = (inverse(hand) @ world_T(self.scene, state, name))[:3, 3]
        return load_of(self.scene, robot, state.robots[robot], place, self.scene.bodies[name].mass)

    def _plan(self, name: str, segments: Sequence[Segment]) -> Plan:
        """The plan of one node with these segments, with what grants its contacts and its certificate."""
        scene, first, last = self.scene, self.scene.start, self.belief.state
        assert scene.description is not None
        motion = tuple(replace(each, procedure=name) for each in segments if each.trajectory is not None)
        changes: dict[str, Component] = {n: q for n, q in last.robots.items() if q != first.robots[n]}
        changes |= {n: own for n, own in last.objects.items() if own != first.objects[n]}
        after = whole_state(scene, changes) if changes else None
        nodes = {NODE: Node("action", name, next=GOAL, motion=motion, after=after), GOAL: Node("goal")}
        options = Options(seed=0, epsilon=scene.epsilon, clearance=self.clearance).written()
        start = whole_state(scene, {**first.robots, **first.objects})
        plan = Plan(name, files_of(scene), options, NODE, nodes, start)
        surroundings = GeometryServer(scene, clearance=self.clearance).surroundings
        plan = granted(plan, scene)
        known = certificate_with_parts(plan, surroundings, self.interruption.plan)
        return certified(plan, surroundings)[0] if known is None else replace(plan, certificate=known)


def _with_held(scene: Scene, between: Mapping[str, str]) -> Scene:
    """The scene in which bodies hang on the tools of robots, where they stand."""
    state = scene.start
    for body, name in between.items():
        robot = scene.robots[name]
        if robot.tool is None or robot.gripper is None:
            raise NoWayError(f"{name} has no hand")
        parent = f"{name}.{robot.tool.frame}"
        place = inverse(world_T(scene, scene.start, parent)) @ world_T(scene, scene.start, body)
        state = state.replace({body: attachment(parent, place)})
    return replace(scene, start=state)


def _distinct(rows: Sequence[Sequence[float]]) -> Array:
    """Rows (m, n) without those that equal the one before."""
    found = [np.round(np.array(rows[0]), 9)]
    for row in rows[1:]:
        other = np.round(np.array(row), 9)
        if np.abs(other - found[-1]).max() > 1e-9:
            found.append(other)
    return np.array(found)


def files_of(scene: Scene) -> dict[str, str]:
    """The hashes of the scene's files, by their names in plans of its folder, as plans of tasks have them."""
    assert scene.description is not None
    path = scene.description.path
    read = recorded_files(scene.files.items(), path.parent)
    return {path.name: "sha256:" + hashlib.sha256(path.read_bytes()).hexdigest(), **read}
