"""Checks that a motion takes, releases and joins objects only as its call and the scene's families permit."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from kabo.arrays import Array
from kabo.plan import Segment
from kabo.verify.motion.calls import Call
from kabo.verify.motion.contacts.attachment_tree import AttachmentTree
from kabo.verify.motion.contacts.families import check_grasp, check_placement
from kabo.verify.motion.contacts.mating import check_mate, fittings
from kabo.verify.motion.limits import CONTINUITY_TOLERANCE
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.report import Finding


@dataclass
class AttachmentChanges:
    """The attachments of objects during a node's motion; each segment that ends may change them in `holding`."""

    node: str
    call: Call
    world: SceneModel
    holding: AttachmentTree
    had: dict[str, set[str]] = field(default_factory=dict)  # robot -> the objects that it has held in this node
    taken: dict[str, str] = field(default_factory=dict)  # object -> the robot that took it
    let_go: set[str] = field(default_factory=set)
    mated: set[frozenset[str]] = field(default_factory=set)

    def __post_init__(self) -> None:
        for name, (parent, _) in self.holding.hung.items():
            robot, dot, _ = parent.partition(".")
            if dot:
                self.had.setdefault(robot, set()).add(name)

    def begin(self, segment: Segment) -> Iterator[Finding]:
        """A finding if the segment moves a hand that holds an object, unless it releases or attaches it."""
        robot = self.world.scene.robots[segment.robot]
        moved = np.abs(np.subtract(segment.waypoints, segment.waypoints[0])).max() > CONTINUITY_TOLERANCE
        if self.call.spec is None or segment.joints != robot.gripper_joints or not moved:
            return
        let_go = {*segment.detach, *(name for name, _ in segment.attach)}
        for name, (parent, _) in self.holding.hung.items():
            if parent.partition(".")[0] == robot.name and name not in let_go:
                text = f"{robot.name} moves its hand while it holds {name}"
                yield Finding(self.node, text, segment.times[0], (robot.name, name))

    def end(self, segment: Segment) -> Iterator[Finding]:
        """Applies a segment's releases, then its takes and joins, to the attachments; yields the findings."""
        time, loose = segment.times[-1], []
        for name in segment.detach:
            wrong = list(self._detach(segment, name))
            yield from wrong
            loose += [] if wrong else [name]
        for name, to in segment.attach:
            robot, dot, _ = to.partition(".")
            yield from self._take(segment, name, to) if dot else self._join(time, name, to)
        for name in loose:
            yield from self._check_let_go(segment, name)

    # ------------------------------------------------------------------------------------------------- letting go
    def _detach(self, segment: Segment, name: str) -> Iterator[Finding]:
        time, robot, spec = segment.times[-1], segment.robot, self.call.spec
        if not self._may_let_go(robot, name):
            yield Finding(self.node, f"{self.call} detaches {name}, which it may not", time, (name,))
        elif self.holding.hung[name][0].partition(".")[0] == robot:
            self.holding.hang(name, "world")
            self.let_go.add(name)
        elif (
            spec is not None and spec.takes != "receiver" and not spec.mates or name not in self.had.get(robot, ())
        ):
            yield Finding(self.node, f"{name} is detached, but not held", time, (name,))

    def _may_let_go(self, robot: str, name: str) -> bool:
        call, spec = self.call, self.call.spec
        if name not in self.holding.hung:
            return False
        if spec is None:
            return name in call.bodies or name in self.had.get(robot, ())
        if spec.mates:
            return name in (call.role("object"), call.role("other"))
        return spec.lets_go is not None and name == call.role("object") and robot == call.role(spec.lets_go)

    def _check_let_go(self, segment: Segment, name: str) -> Iterator[Finding]:
        """A finding unless an object that was let go stands, or is held by another robot."""
        call, spec, time = self.call, self.call.spec, segment.times[-1]
        if spec is None:
            return
        yield from self._check_open(segment)
        if spec.places:
            yield from check_placement(self.node, time, call, self.world, self.holding.pose)
        elif self.holding.parent(name) != "world":
            return
        elif spec.mates:
            pair = str(call.role("object")), str(call.role("other"))
            yield from check_mate(self.node, time, call, self.world, pair, self.holding.pose)
        elif spec.takes == "receiver":
            receiver = str(call.role("receiver"))
            if receiver in self.holding.q:
                q, pose = self.holding.q[receiver], self.holding.pose(name)
                yield from check_grasp(self.node, time, call, self.world, receiver, name, q, pose)

    def _check_open(self, segment: Segment) -> Iterator[Finding]:
        joint = first_joint_not_open(self.world, segment.robot, self.holding.q[segment.robot])
        if joint is not None:
            text = f"{segment.robot} lets go while {joint} is not open"
            yield Finding(self.node, text, segment.times[-1], (segment.robot,))

    # -------------------------------------------------------------------------------------------- taking, joining
    def _take(self, segment: Segment, name: str, link: str) -> Iterator[Finding]:
        time, (robot, _, own), call = segment.times[-1], link.partition("."), self.call
        if not self._may_take(robot, name):
            yield Finding(self.node, f"{call} attaches {name}, which it may not", time, (name,))
            return
        arm = self.world.arms[robot]
        mount, tool = arm.mounts.get(own), arm.robot.tool
        wrist = None if tool is None else arm.mounts[tool.frame]
        if robot != segment.robot or mount is None or (wrist is not None and mount.joint != wrist.joint):
            text = f"{name} is attached to {link}, not to the tool"
            yield Finding(self.node, text, time, (name, link))
            return
        if self.holding.holder(name) not in (None, *self._givers(robot)):
            yield Finding(self.node, f"{name} is attached, but held already", time, (name,))
        if call.spec is not None:
            q, pose = self.holding.q[robot], self.holding.pose(name)
            yield from check_grasp(self.node, time, call, self.world, robot, name, q, pose)
        self.holding.hang(name, link)
        self.taken[name] = robot
        self.had.setdefault(robot, set()).add(name)

    def _may_take(self, robot: str, name: str) -> bool:
        call, spec = self.call, self.call.spec
        if name not in self.holding.hung or robot not in call.robots:
            return False
        if spec is None:
            return name in call.bodies
        return spec.takes is not None and name == call.role("object") and robot == call.role(spec.takes)

    def _givers(self, robot: str) -> tuple[str, ...]:
        """The robots from which a robot may take an object that they hold."""
        spec = self.call.spec
        if spec is None:
            return tuple(other for other in self.call.robots if other != robot)
        return (str(self.call.role("robot")),) if spec.takes == "receiver" else ()

    def _join(self, time: float, name: str, to: str) -> Iterator[Finding]:
        call, spec, pair = self.call, self.call.spec, (name, to)
        hung = self.holding.hung
        known = name in hung and (to in hung or to in self.holding.fixed)
        wanted = (
            set(call.bodies)
            if spec is None
            else {call.role("object"), call.role("other")}
            if spec.mates
            else set()
        )
        if not known or not set(pair) <= wanted or name == to:
            yield Finding(self.node, f"{call} attaches {name} to {to}, which it may not", time, pair)
            return
        if to in hung and self.holding.root(to) == self.holding.root(name):
            yield Finding(self.node, f"{name} and {to} hang together already", time, pair)
            return
        if spec is not None or fittings(call, self.world, *pair):
            yield from check_mate(self.node, time, call, self.world, pair, self.holding.pose)
        self.holding.hang(name, to)
        self.mated.add(frozenset(pair))


def first_joint_not_open(world: SceneModel, robot: str, q: Array) -> str | None:
    """The first gripper joint that is not at its open position, or None."""
    gripper, names = world.scene.robots[robot].gripper, world.scene.robots[robot].joint_names
    for joint, value in {} if gripper is None else gripper.open.items():
        if joint in names and abs(q[names.index(joint)] - value) > CONTINUITY_TOLERANCE:
            return joint
    return None
