"""One plan in physics on many of its branches, measured at each step.

Where branches part, the process forks: a child goes on with one outcome and writes down what it has measured since, and its
parent, which waits, goes on with the next one.
"""

import os
import pickle
import sys
import tempfile
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import inf, sqrt
from pathlib import Path

import numpy as np

from kabo.execution import Follower, KnownTruth, Margins, Run, execute
from kabo.execution.following import Setpoint
from kabo.plan import ObjectPose, Plan, StateChange, state_after
from kabo.planner.geometry.relations import relations
from kabo.scene import Scene, attachment, beginning_at, link_pose, motion_limits, world_T
from kabo.simulation import ContactJudge, PhysicsSettings, SimulatedRobot

Outcomes = tuple[str, ...]  # of what is asked in a run, in order

HASTY = sqrt(2.0)  # how much faster everything goes if it is accelerated twice as much
ROUNDING = 1e-6  # share of a limit by which a sample may exceed it
AFTERWARDS = 0.5  # [s] from the end until bodies are looked at
HELD_WITHIN = 0.03  # [m]
SOFT = 5e-4  # [m] by which contacts of the simulation give way


@dataclass
class Branch:
    """How one branch ended: whether its goal is true, how far bodies are off [mm, degrees], contacts, what went wrong."""

    outcomes: Outcomes
    goal: bool = False
    off: float = 0.0
    turned: float = 0.0
    contacts: tuple[str, ...] = ()
    reason: str = ""


@dataclass
class Measured:
    """What is counted over all branches, what they share once.

    Attributes:
        errors: of the joint that is farthest from its setpoint, at each step [rad or m].
        samples, violations: setpoints that were sent, and those that exceed a limit.
        looks, beyond: how often a tool was compared with its path, and was farther off than is proven.
        nearest: the least proven clearance less the tool's error [m].
        simulated: [s].
    """

    errors: list[np.ndarray] = field(default_factory=list)
    samples: int = 0
    violations: int = 0
    looks: int = 0
    beyond: int = 0
    nearest: float = inf
    simulated: float = 0.0

    def add(self, other: "Measured") -> None:
        """Takes in what another process has measured."""
        self.errors += other.errors
        self.samples += other.samples
        self.violations += other.violations
        self.looks += other.looks
        self.beyond += other.beyond
        self.nearest = min(self.nearest, other.nearest)
        self.simulated += other.simulated


def branches_of(plan: Plan) -> list[Outcomes]:
    """The outcomes of what a run asks, for every run that the plan foresees."""
    later = {n.on: tuple(n.branches) for n in plan.nodes.values() if n.kind == "branch" and n.on}
    found: list[Outcomes] = []
    waiting: list[tuple[str, dict[str, str], Outcomes, int]] = [(plan.root, {}, (), 0)]
    while waiting:
        name, known, path, asked = waiting.pop()
        node = plan.nodes[name]
        terms = [term for term in node.delivers if term in later]
        if asked < len(terms):
            for outcome in reversed(later[terms[asked]]):
                waiting.append((name, known | {terms[asked]: outcome}, (*path, outcome), asked + 1))
        elif node.on is None:
            if node.next is None:
                found.append(path)
            else:
                waiting.append((node.next, known, path, 0))
        elif node.kind == "branch" and node.on in known:
            waiting.append((node.branches[known[node.on]], known, path, 0))
        else:
            for outcome, following in reversed(node.branches.items()):
                waiting.append((following, known | {node.on: outcome}, (*path, outcome), 0))
    return found


class Forking(KnownTruth):
    """Answers what leads to branches that are wanted; where they part, the process forks.

    Args:
        wanted: the branches. robot: sees where bodies are. folder: where children write.
    """

    def __init__(self, wanted: Sequence[Outcomes], robot: "MeasuredRobot", folder: Path) -> None:
        super().__init__(poses=robot.poses)
        self.wanted, self.robot, self.folder = list(wanted), robot, folder
        self.path: Outcomes = ()
        self.is_child = False

    def resolve(self, formula: str, outcomes: tuple[str, ...]) -> str | None:
        """The outcome of this process."""
        depth = len(self.path)
        parts = {o: own for o in outcomes if (own := [each for each in self.wanted if each[depth] == o])}
        *others, last = parts
        for outcome in others:
            sys.stdout.flush()
            sys.stderr.flush()
            child = os.fork()
            if child == 0:
                self.is_child, self.wanted, self.path = True, parts[outcome], (*self.path, outcome)
                self.robot.measured = Measured()
                return outcome
            os.waitpid(child, 0)
        self.wanted, self.path = parts[last], (*self.path, last)
        return last

    def end(self, branch: Branch) -> None:
        """Writes down a branch, and ends the process if it was forked."""
        file = self.folder / f"{os.getpid()}.pickle"
        file.write_bytes(pickle.dumps((branch, self.robot.measured)))
        if self.is_child:
            sys.stderr.flush()
            os._exit(0)


class _Hastening(Follower):
    """A follower whose clock runs faster."""

    def __init__(self, scene: Scene, pace: float) -> None:
        super().__init__(scene)
        self.times_faster = pace

    def advance(self, seconds: float) -> Iterator[Setpoint]:
        """What is to be sent, with velocities and accelerations of the faster motion."""
        for s in super().advance(seconds * self.times_faster):
            faster = self.times_faster * s.velocities, self.times_faster**2 * s.accelerations
            yield Setpoint(s.robot, s.joints, s.positions, *faster)


class MeasuredRobot(SimulatedRobot):
    """A robot in physics whose setpoints and errors are measured at each step."""

    def __init__(self, scene: Scene, settings: PhysicsSettings, plan: Plan, pace: float) -> None:
        self.measured, self.margins = Measured(), Margins(plan)
        self._before: dict[tuple[str, tuple[str, ...]], Setpoint] = {}
        self._bounds: dict[tuple[str, tuple[str, ...]], tuple[np.ndarray, ...]] = {}
        super().__init__(scene, settings)
        if pace != 1.0:
            self._follower = _Hastening(scene, pace)
        motors = self.physics.motors
        arms = [k for k, each in enumerate(motors) if each.joint in scene.robots[each.robot].planned_joints]
        self._arms = {name: np.array([k for k in arms if motors[k].robot == name]) for name in scene.robots}
        self._contacts, self.judge = ContactJudge(scene), self._look

    @property
    def contacts(self) -> dict[tuple[str, str], float]:
        """Contacts that no segment permits, with their depth [m]."""
        return self._contacts.faults

    def _send(self, tick: int, step: float) -> None:
        measured, follower = self.measured, self._follower
        moving = follower.moving and follower.motion is not None
        measured.simulated += step
        super()._send(tick, step)
        if not moving or follower.motion is None:
            return
        robots = {each.robot for each in follower.motion.at(follower.time)}
        off = self.physics.setpoint - self.physics.data.qpos[self.physics._values[: len(self.physics.motors)]]
        self._errors.append(
            max((float(np.abs(off[self._arms[name]]).max(initial=0.0)) for name in robots), default=0.0)
        )
        for sent in self._sent if tick == 0 else ():
            self._judge_sample(sent, step * self.each)

    @property
    def _errors(self) -> list[float]:
        if not self.measured.errors or len(self.measured.errors[-1]) > 100_000:
            self.measured.errors.append([])  # type: ignore[arg-type]
        return self.measured.errors[-1]  # type: ignore[return-value]

    def _judge_sample(self, sent: Setpoint, step: float) -> None:
        key = sent.robot, sent.joints
        if key not in self._bounds:
            own = self.scene.robots[sent.robot]
            index = [own.joint_names.index(joint) for joint in sent.joints]
            limits = motion_limits(own, sent.joints)
            low, high = own.tree.lower[index], own.tree.upper[index]
            self._bounds[key] = low, high, limits.velocity, limits.acceleration, limits.jerk
        low, high, velocity, acceleration, jerk = self._bounds[key]
        before, room = self._before.get(key), 1.0 + ROUNDING
        self._before[key] = sent
        fine = (sent.positions >= low - ROUNDING).all() and (sent.positions <= high + ROUNDING).all()
        fine &= (np.abs(sent.velocities) <= room * velocity + 1e-9).all()
        fine &= (np.abs(sent.accelerations) <= room * acceleration + 1e-9).all()
        if before is not None:
            fine &= (np.abs(sent.accelerations - before.accelerations) <= step * room * jerk + 1e-9).all()
            fine &= (np.abs(sent.positions - before.positions) <= step * room * velocity + 1e-9).all()
        self.measured.samples += 1
        self.measured.violations += not fine

    def _look(self, physics: object, motion: object, time: float, holding: list[tuple[str, str]]) -> None:
        self._contacts.look(self.physics, self._follower.motion if motion is not None else None, time, holding)
        if self._follower.motion is None or motion is None:
            return
        for stretch in self._follower.motion.at(time):
            robot = self.scene.robots[stretch.robot]
            if stretch.trajectory.joints != robot.planned_joints:
                continue
            now = self.physics.configuration(stretch.robot)
            wanted = (*stretch.trajectory.at(time).tolist(), *now[robot.planned :])
            frame = robot.tool.frame if robot.tool is not None else next(reversed(robot.links))
            off = link_pose(robot, now, frame)[:3, 3] - link_pose(robot, wanted, frame)[:3, 3]
            room = self.margins.of_segment(stretch.node, stretch.segment) - float(np.linalg.norm(off))
            self.measured.looks += 1
            self.measured.beyond += room <= 0.0
            self.measured.nearest = min(self.measured.nearest, room)


def carried_out(
    plan: Plan, scene: Scene, wanted: Sequence[Outcomes], pace: float = 1.0, *, weld: bool = False
) -> tuple[list[Branch], Measured]:
    """Carries out a plan on branches; at another pace nothing is asked of clearances."""
    if pace != 1.0 and plan.certificate is not None:
        free = tuple(replace(each, clearance=HELD_WITHIN) for each in plan.certificate.segments)
        plan = replace(plan, certificate=replace(plan.certificate, segments=free))
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        robot = MeasuredRobot(scene, PhysicsSettings(welds=weld), plan, pace)
        sensor = Forking(wanted, robot, folder)
        branch = Branch(())
        try:
            run = execute(plan, scene, robot, sensor)
            branch.outcomes = sensor.path
            robot.wait(AFTERWARDS)
            _judge(branch, run, plan, scene, robot)
        except Exception:  # noqa: BLE001 - whatever it is, it is a finding
            branch.reason = traceback.format_exc(limit=-3)
        robot.measured.errors = [np.asarray(each, np.float32) for each in robot.measured.errors]
        sensor.end(branch)
        found = [pickle.loads(file.read_bytes()) for file in sorted(folder.glob("*.pickle"))]  # noqa: S301 - our own
    measured = Measured()
    for _, own in found:
        measured.add(own)
    return [each for each, _ in found], measured


def _judge(branch: Branch, run: Run, plan: Plan, scene: Scene, robot: MeasuredRobot) -> None:
    """What has become of a branch, by the simulator's state."""
    branch.contacts = tuple(" and ".join(pair) for pair in robot.contacts)
    if branch.contacts:
        deepest = max(robot.contacts, key=lambda pair: robot.contacts[pair])
        branch.reason = f"{' and '.join(deepest)} touch, {1000 * robot.contacts[deepest]:.2g} mm deep"
    if not run.reached_goal:
        branch.reason = "; ".join(robot.doubts) or run.reason
    wanted = state_after(plan, run.history).geometry
    if wanted is None:
        branch.goal = run.reached_goal
        return
    there = beginning_at(scene, wanted)
    planned = {name: world_T(there, there.start, name) for name in scene.movable}
    found = robot.poses()
    moved = {b for n, _ in run.history if (after := plan.nodes[n].after) is not None for b in after.objects}
    for name in sorted(moved & set(planned)):
        off = 1000.0 * float(np.linalg.norm(planned[name][:3, 3] - found[name][:3, 3]))
        branch.off, branch.turned = max(branch.off, off), max(branch.turned, _angle(planned[name], found[name]))
    wrong = _wrong(wanted, scene, robot)
    if wrong and not branch.reason:
        branch.reason = wrong
    branch.goal = run.reached_goal and not wrong


def _angle(first: np.ndarray, second: np.ndarray) -> float:
    turn = first[:3, :3].T @ second[:3, :3]
    return float(np.degrees(np.arctan2(np.linalg.norm(turn - turn.T) / sqrt(8.0), 0.5 * (np.trace(turn) - 1.0))))


def _wrong(wanted: StateChange, scene: Scene, robot: MeasuredRobot) -> str:
    """What is not true in the simulator that a plan's last state says of bodies, in a sentence."""
    found, soft = robot.poses(), {}
    touching = {frozenset(contact.things) for contact in robot.physics.contacts(-1e-4)} | robot.joined
    objects: dict[str, ObjectPose] = {}
    for name, own in wanted.objects.items():
        if own.parent == "world":
            made = attachment("world", found[name])
            objects[name] = ObjectPose("world", made.position, made.quaternion)
            x, y, z = made.position
            high = own.position[2] if abs(z - own.position[2]) < SOFT else z
            soft[name] = ObjectPose("world", (x, y, high), made.quaternion)
            continue
        holder, dot, _ = own.parent.partition(".")
        things = (
            scene.robots[holder].gripper.touch_links if dot and scene.robots[holder].gripper else (own.parent,)
        )
        if not any(frozenset((name, thing)) in touching for thing in things):
            return f"{name} is not touched by {own.parent}"
        objects[name] = soft[name] = own
    planned = relations(scene, wanted)
    true, near = (relations(scene, replace(wanted, objects=each)) for each in (objects, soft))
    for name in objects:
        supports = planned[name].supports in (true[name].supports, near[name].supports)
        if not supports or planned[name].regions not in (true[name].regions, near[name].regions):
            return f"{name} should be {_told(planned[name])}, and is {_told(true[name])}"
    return ""


def _told(relation: object) -> str:
    supports, regions = sorted(relation.supports), sorted(relation.regions)  # type: ignore[attr-defined]
    return f"on {', '.join(supports) or 'nothing'} in {', '.join(regions) or 'no region'}"
