"""Whether the motion of a node is its action's: moves what the call names, and ends as recorded.

A motion is walked segment by segment: numbers, permitted contacts, collisions, the motion constraint, then what is
attached and detached; at the end what the call asks for, and the recorded state.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from kabo.language.problem import Problem
from kabo.plan import Node, ObjectPose, Segment
from kabo.scene import Robot
from kabo.verify.arms import Mount
from kabo.verify.calls import Call, call_of
from kabo.verify.collision import Tally, check_collision
from kabo.verify.components import Components
from kabo.verify.constraints import UnknownFeatureError
from kabo.verify.contacts import RAISED, is_first, is_last, permits
from kabo.verify.families import check_grasp, check_placement
from kabo.verify.keeping import Lapse, Owners, check_kept
from kabo.verify.limits import JOINED, check_joints, check_numbers
from kabo.verify.report import Finding
from kabo.verify.situation import Ambiguous, Situation, situation
from kabo.verify.surfaces import mesh_distance
from kabo.verify.sweep import Path, Thing
from kabo.verify.world import World, matrix

Array = npt.NDArray[np.float64]

# procedure -> what must be attached and detached during its motion
TAKES, LETS_GO = {"pick", "restack"}, {"place", "release", "restack"}


def check_motion(
    node: str, content: Node, problem: Problem, world: World, components: Components, tally: Tally
) -> Iterator[Finding]:
    """Everything that is wrong with the motion of a node, in the order of time."""
    try:
        call = call_of(content, problem)
    except ValueError as error:
        yield Finding(node, str(error))
        return
    if call is None:
        if content.motion or content.after is not None:
            yield Finding(node, f'"{content.action}" has no geometry, but the node moves something')
        return
    unknown = [name for role, name in call.roles.items() if not _plays(role, name, world)]
    if unknown:
        yield Finding(
            node, f"{call}: {', '.join(unknown)} cannot play this role in the scene", bodies=tuple(unknown)
        )
        return
    try:
        start = situation(node, call, world, components)
    except Ambiguous as error:
        yield Finding(node, str(error))
        return
    if start is None:
        return
    if not content.motion:
        yield from _check_still(node, content, call, world, start)
        return
    foreign = [segment.robot for segment in content.motion if segment.robot != call.roles["robot"]]
    if foreign:
        yield Finding(node, f"{call} moves {foreign[0]}, which it does not name", bodies=(foreign[0],))
        return
    yield from _Walk(node, call, world, start, tally).check(content)


def _plays(role: str, name: str, world: World) -> bool:
    scene = world.scene
    if role == "robot":
        return name in scene.robots
    if role == "region":
        return name in scene.regions
    return name in scene.bodies and (role != "object" or name in scene.movable)


def _check_still(node: str, content: Node, call: Call, world: World, start: Situation) -> Iterator[Finding]:
    """Nothing moves: right only for sensing where the robot is already, or has no place to go to."""
    robot = world.scene.robots[call.roles["robot"]]
    wanted = robot.configurations.get(call.at or "")
    if call.at is None or (wanted is not None and not _is_at(robot, start.q, wanted)):
        yield Finding(node, f"{call} has no motion")
    elif content.after is not None:
        yield Finding(node, "records a change, but nothing moves")


def _is_at(robot: Robot, q: Array, wanted: tuple[float, ...]) -> bool:
    return bool(np.abs(q[: robot.planned] - np.asarray(wanted)).max() <= JOINED)


@dataclass
class _Walk:
    """The state of the moving robot while its segments are walked."""

    node: str
    call: Call
    world: World
    start: Situation
    tally: Tally
    taken: set[str] = field(default_factory=set)
    let_go: set[str] = field(default_factory=set)
    links: dict[str, str] = field(default_factory=dict)  # what each object that was taken hangs on

    def __post_init__(self) -> None:
        self.arm = self.world.arms[self.call.roles["robot"]]
        self.robot: Robot = self.arm.robot
        self.q = self.start.q.copy()
        self.objects = dict(self.start.objects)
        self.ended = 0.0

    def check(self, content: Node) -> Iterator[Finding]:
        segments = content.motion
        for i, segment in enumerate(segments):
            wrong = list(check_joints(self.node, segment, self.robot))
            wrong = wrong or list(check_numbers(self.node, segment, self.robot, self.q, self.ended))
            yield from wrong
            if segment.joints not in (self.robot.planned_joints, self.robot.gripper_joints):
                return
            path = self._path(segment)
            yield from self._check_collision(segment, path, is_first(segments, i), is_last(segments, i))
            yield from self._check_kept(segment, path)
            self.q, self.ended = path.configurations[-1].copy(), segment.times[-1]
            yield from self._attach(segment)
            yield from self._detach(segment)
        yield from self._check_end()
        yield from self._check_after(content)

    @property
    def held(self) -> list[str]:
        """What the robot carries now."""
        return [name for name, where in self.objects.items() if isinstance(where, Mount)]

    def pose(self, name: str) -> Array:
        """Where an object is now, in the world."""
        where = self.objects[name]
        return self.arm.pose(self.q.tolist(), where) if isinstance(where, Mount) else where

    def _path(self, segment: Segment) -> Path:
        index = [self.robot.joint_names.index(joint) for joint in segment.joints]
        configurations = np.tile(self.q, (len(segment.waypoints), 1))
        configurations[:, index] = segment.waypoints
        return Path(self.arm, configurations, segment.times)

    # ---------------------------------------------------------------------------------------------- contacts
    def _check_collision(self, segment: Segment, path: Path, first: bool, last: bool) -> Iterator[Finding]:
        standing = list(self.start.standing)
        moving = self.world.links(self.robot.name)
        for name, where in self.objects.items():
            own = self.world.surface_of(self.world.scene.bodies[name].mesh)
            if isinstance(where, Mount):
                moving.append(Thing(name, own, mount=where))
            else:
                standing.append(Thing(name, own, where))
        objects = {*self.held, *([self.call.roles["object"]] if "object" in self.call.roles else [])}
        granted = permits(
            segment,
            self.world.scene,
            gripper_moves=segment.joints == self.robot.gripper_joints,
            objects=objects,
            supports=list(self._supports(segment, path, standing, first, last)),
        )
        for a, b in granted.refused:
            text = f"permits contact of {a} and {b}, which this motion may not"
            yield Finding(self.node, text, segment.times[0], (a, b))
        yield from check_collision(self.node, path, moving, standing, granted, self.world, self.tally)

    def _supports(
        self, segment: Segment, path: Path, standing: list[Thing], first: bool, last: bool
    ) -> Iterator[tuple[str, str]]:
        """Which of the permitted pairs are an object and what it stands on, where this segment begins or ends."""
        places = {thing.name: thing for thing in standing if "." not in thing.name}
        for pair in segment.allowed_contacts:
            for name, support in (pair, pair[::-1]):
                if support not in places or name not in self.objects:
                    continue
                where = self.objects[name]
                own, below = self.world.surface_of(self.world.scene.bodies[name].mesh), places[support]
                ends = [path.configurations[0]] * first + [path.configurations[-1]] * last
                if not isinstance(where, Mount):
                    yield name, support  # it does not move against what it stands on
                elif any(
                    mesh_distance(own, self.arm.pose(q.tolist(), where), below.surface, below.pose(np.empty(0)))
                    <= RAISED
                    for q in ends
                ):
                    yield name, support

    def _check_kept(self, segment: Segment, path: Path) -> Iterator[Finding]:
        moves = segment.joints == self.robot.planned_joints
        if self.call.keep is not None and moves and self.held and segment.constraint != self.call.keep:
            text = f"{self.call} must keep {self.call.keep}, but a segment does not"
            yield Finding(self.node, text, segment.times[0])
        if segment.constraint is None:
            return
        constraints = self.world.scene.motion_constraints.get(segment.constraint)
        if constraints is None:
            yield Finding(self.node, f"the scene has no motion constraint {segment.constraint}", segment.times[0])
            return
        try:
            check_kept(path, constraints, self._owners())
        except UnknownFeatureError as error:
            yield Finding(
                self.node, f"{segment.constraint} speaks of {error}, which nobody has here", segment.times[0]
            )
        except Lapse as lapse:
            by = lapse.measure.excess
            how = "cannot be decided" if lapse.undecided else f"is missed by {by:.3g}"
            missed = lapse.constraint
            text = f"{segment.constraint}: {missed.kind}({missed.first}, {missed.second})"
            unit = "m" if lapse.measure.kind == "length" else "rad"
            yield Finding(self.node, f"{text} {how} {unit}", lapse.time, (), max(0.0, by))

    def _owners(self) -> Owners:
        result: Owners = {}
        tool = self.world.tool_role(self.robot.name, tuple(self.q.tolist()))
        if tool is not None and self.robot.tool is not None:
            result["tool"] = tool, self.arm.mounts[self.robot.tool.frame]
        name = self.call.roles.get("object") or next(iter(self.held), None)
        if name is not None:
            where = self.objects[name]
            role = self.world.role(name, self.pose(name))
            result["this"] = role, where if isinstance(where, Mount) else None
        return result

    # -------------------------------------------------------------------------------------- taking, letting go
    def _attach(self, segment: Segment) -> Iterator[Finding]:
        for name, link in segment.attach:
            if name != self.call.roles.get("object") or self.call.procedure not in TAKES:
                yield Finding(self.node, f"{self.call} attaches {name}, which it may not", self.ended, (name,))
                continue
            robot, _, own = link.partition(".")
            mount = self.arm.mounts.get(own) if robot == self.robot.name else None
            tool = None if self.robot.tool is None else self.arm.mounts[self.robot.tool.frame]
            if mount is None or (tool is not None and mount.joint != tool.joint):
                yield Finding(
                    self.node, f"{name} is attached to {link}, not to the tool", self.ended, (name, link)
                )
                return
            if name in self.held:
                yield Finding(self.node, f"{name} is attached, but held already", self.ended, (name,))
            world_T = self.pose(name)
            yield from check_grasp(self.node, self.ended, self.call, self.world, tuple(self.q.tolist()), world_T)
            joint = self.arm.joint_poses(self.q.tolist())[mount.joint]
            self.objects[name] = Mount(mount.joint, np.linalg.inv(joint) @ world_T)
            self.links[name] = link
            self.taken.add(name)

    def _detach(self, segment: Segment) -> Iterator[Finding]:
        for name in segment.detach:
            if name != self.call.roles.get("object") or self.call.procedure not in LETS_GO:
                yield Finding(self.node, f"{self.call} detaches {name}, which it may not", self.ended, (name,))
                continue
            if name not in self.held:
                yield Finding(self.node, f"{name} is detached, but not held", self.ended, (name,))
            self.objects[name] = self.pose(name)
            self.let_go.add(name)
            yield from check_placement(
                self.node, self.ended, self.call, self.world, self.pose(name), self.start.poses
            )
            yield from self._check_open(segment)

    def _check_open(self, segment: Segment) -> Iterator[Finding]:
        gripper, names = self.robot.gripper, self.robot.joint_names
        for joint, value in {} if gripper is None else gripper.open.items():
            if joint in names and abs(self.q[names.index(joint)] - value) > JOINED:
                text = f"{self.robot.name} lets go while {joint} is not open"
                yield Finding(self.node, text, segment.times[-1], (self.robot.name,))

    # ------------------------------------------------------------------------------------------------- the end
    def _check_end(self) -> Iterator[Finding]:
        procedure, name = self.call.procedure, self.call.roles.get("object")
        if procedure in TAKES and name not in self.taken:
            yield Finding(self.node, f"{self.call} never takes {name}", self.ended, (str(name),))
        if procedure in LETS_GO and name not in self.let_go:
            yield Finding(self.node, f"{self.call} never lets go of {name}", self.ended, (str(name),))
        if procedure == "transfer" and name is not None:
            if name not in self.held:
                yield Finding(self.node, f"{self.call} moves without holding {name}", self.ended, (name,))
            pose = self.pose(name)
            yield from check_placement(self.node, self.ended, self.call, self.world, pose, self.start.poses)
        wanted = self.robot.configurations.get(self.call.at or "")
        if wanted is not None and not _is_at(self.robot, self.q, wanted):
            text = f"{self.call} does not end in the configuration {self.call.at}"
            yield Finding(self.node, text, self.ended, (self.robot.name,))

    def _check_after(self, content: Node) -> Iterator[Finding]:
        """`after` records the robot's last configuration and what was taken or let go, nothing else."""
        after = content.after
        robots = {} if after is None else after.robots
        objects = {} if after is None else after.objects
        changed = {*self.taken, *self.let_go}
        for name in sorted(robots.keys() - {self.robot.name}) + sorted(objects.keys() - changed):
            yield Finding(self.node, f"records a change of {name}, which its motion does not make", bodies=(name,))
        recorded = robots.get(self.robot.name, {})
        for joint, value, before in zip(self.robot.joint_names, self.q, self.start.q, strict=True):
            told = recorded.get(joint, float(before))
            if abs(told - value) > JOINED:
                text = f"records {joint} of {self.robot.name} at {told:.9g}, the motion ends at {value:.9g}"
                yield Finding(self.node, text, self.ended, (self.robot.name,), abs(told - float(value)))
        for joint in recorded.keys() - set(self.robot.joint_names):
            yield Finding(self.node, f"records {joint}, which {self.robot.name} does not have")
        for name in sorted(changed):
            yield from self._check_recorded(name, objects)

    def _check_recorded(self, name: str, objects: Mapping[str, ObjectPose]) -> Iterator[Finding]:
        if name not in objects:
            yield Finding(self.node, f"does not record where {name} is afterwards", self.ended, (name,))
            return
        recorded, where = objects[name], self.objects[name]
        parent = self.links.get(name, "") if isinstance(where, Mount) else "world"
        if recorded.parent != parent:
            text = f"records {name} on {recorded.parent}, the motion leaves it on {parent}"
            yield Finding(self.node, text, self.ended, (name,))
            return
        expected = self.pose(name)
        if isinstance(where, Mount):
            mount = self.arm.mounts[parent.partition(".")[2]]
            expected = np.linalg.inv(self.arm.pose(self.q.tolist(), mount)) @ expected
        off = float(np.abs(matrix(recorded) - expected).max())
        if off > 2 * JOINED:
            text = f"records {name} {off:.3g} away from where the motion leaves it"
            yield Finding(self.node, text, self.ended, (name,), off)
