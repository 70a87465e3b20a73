"""Checks one motion from start to end: its numbers, collisions, motion constraints, objects taken and released.

The motion is checked window by window: robots whose segments overlap in time move together along one path.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from kabo.arrays import Array
from kabo.plan import Node, Segment
from kabo.verify.motion.added import AddedBodies
from kabo.verify.motion.calls import Call
from kabo.verify.motion.collision import Tally, check_collision
from kabo.verify.motion.constraints import UnknownFeatureError
from kabo.verify.motion.contacts.approaches import ApproachesAndRetreats
from kabo.verify.motion.contacts.attachment_changes import AttachmentChanges, first_joint_not_open
from kabo.verify.motion.contacts.families import check_placement
from kabo.verify.motion.contacts.granted import Permits
from kabo.verify.motion.contacts.grants import Grants
from kabo.verify.motion.floors import check_floor
from kabo.verify.motion.limits import CONTINUITY_TOLERANCE, check_joints, check_numbers, check_times
from kabo.verify.motion.overlaps import Motion, Sweep
from kabo.verify.motion.path_constraints import ConstraintViolation, Owners, check_path_constraints
from kabo.verify.motion.recorded import Recorded
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.situation import Situation
from kabo.verify.motion.stretches import MotionStretch
from kabo.verify.motion.sweep import Path, SweptBody
from kabo.verify.motion.trajectories.astray import check_astray
from kabo.verify.motion.trajectories.borders import check_borders, check_rest
from kabo.verify.motion.trajectories.grip import check_grip
from kabo.verify.motion.trajectories.judge import Followed, SegmentJudge, check_form, followed
from kabo.verify.motion.views import check_view
from kabo.verify.motion.windows import Window, columns, fine_path, one_by_one, window_path, windows
from kabo.verify.report import Finding


@dataclass
class Walk:
    """The check of one motion, with the current state of the robots and objects."""

    node: str
    call: Call
    world: SceneModel
    start: Situation
    segments: Sequence[Segment]
    tally: Tally
    added: AddedBodies | None = None  # what only planning knows
    permitted: dict[int, Permits] = field(default_factory=dict)  # of the segments that have begun
    sweeps: list[Sweep] = field(default_factory=list)  # the bodies that moved, window by window
    how: list[Followed] = field(default_factory=list)  # the curve and deviations of each segment
    now: float = 0.0  # [s]

    def __post_init__(self) -> None:
        self.before = self.start.holding
        self.holding = self.before.copy()
        self.changes = AttachmentChanges(self.node, self.call, self.world, self.holding)
        self.moved = tuple(dict.fromkeys(segment.robot for segment in self.segments))
        self.approaches = ApproachesAndRetreats(self.node, self.call, self.world, self.holding)

    @property
    def q(self) -> dict[str, Array]:
        """The present configuration of each robot, by its name."""
        return self.holding.q

    def check(self, content: Node) -> Iterator[Finding]:
        """Checks the motion; yields the findings about its numbers first, then the others in the order of time."""
        yield from self._check_timeline()
        if self._timeless():
            return
        misshapen = [f for i, s in enumerate(self.segments) for f in check_form(self.node, i, s)]
        if misshapen:
            yield from misshapen
            return
        self.segments = one_by_one(self.segments)
        self.how = [followed(segment) for segment in self.segments]
        yield from self._check_numbers()
        yield from self._check_trajectories()
        if lost := list(check_astray(self.node, self.segments, self.how)):
            yield from lost
            return
        self.grants = Grants(self.call, self.world, self.holding, self.start.standing, self.segments, self.how)
        for window in windows(self.segments):
            path, fine = (
                window_path(window, self.segments, self.world.arms, self.q, self.how, fine=each)
                for each in (False, True)
            )
            for i in window.starting:
                yield from self._begin(i)
            yield from self._check_collision(window, path, fine)
            for robot in path.arms:
                self.q[robot] = path.configurations[-1][path.columns[robot]].copy()
            for i in window.ending:
                yield from self._end(i)
        ended = max(segment.times[-1] for segment in self.segments)
        yield from self.approaches.ended(ended)
        yield from check_end(self.node, self.call, self.world, self.changes, ended)
        if self.call.looks(self.world.scene):
            yield from check_view(self.node, self.call, self.world, self.holding, self.start.standing, ended)
        yield from Recorded(self.node, self.world, self.moved, self.before, self.changes, ended).check(content)

    def _begin(self, i: int) -> Iterator[Finding]:
        """Checks the hand, the strokes and the constraint of a segment that begins, and decides its permitted contacts."""
        segment, time = self.segments[i], self.segments[i].times[0]
        path = fine_path(i, self.segments, self.world.arms, self.q, self.how)
        self.permitted[i] = self.grants.permits(i, path)
        for text, pair in self.permitted[i].refused:
            yield Finding(self.node, text, time, pair)
        if self._moves_arm(segment) and path.steps.any():
            yield from self.approaches.arm(segment.robot, path)
        yield from self.changes.begin(segment)
        yield from self._check_kept(segment, path)
        if self.how[i].given:
            yield from check_grip(
                self.node, i, segment, self.how[i].curve, self.world, self.holding, self.tally.trajectories
            )

    def _end(self, i: int) -> Iterator[Finding]:
        """Updates the attachments at the end of a segment, and checks what it lets go, takes and joins."""
        segment, time = self.segments[i], self.segments[i].times[-1]
        for name in segment.detach:
            if name in self.holding.hung and self.holding.holder(name) == segment.robot:
                self.approaches.letting_go(segment.robot, name)
        before = dict(self.changes.taken)
        yield from self._check_still(i)
        yield from self.changes.end(segment)
        for name, robot in self.changes.taken.items():
            if name not in before:
                yield from self.approaches.taken(robot, name, time)
        for text, pair in self.grants.ended(i):
            yield Finding(self.node, text, time, pair)

    def _check_still(self, i: int) -> Iterator[Finding]:
        """Findings unless other robots rest that hold what a segment attaches or detaches, or to which it is attached."""
        segment, time = self.segments[i], self.segments[i].times[-1]
        named = [*segment.detach, *(name for pair in segment.attach for name in pair)]
        holders = {self.holding.holder(name) for name in named if name in self.holding.hung}
        holders |= {to.partition(".")[0] for _, to in segment.attach if "." in to}
        for k, other in enumerate(self.segments):
            touched = other.times[0] < time < other.times[-1] and self.how[k].given
            if touched and other.robot in holders - {segment.robot}:
                arm, reason = self.world.arms[other.robot], "where something is attached or detached"
                yield from check_rest(self.node, k, other, self.how[k].curve, arm, time, reason)

    def motion(self) -> Motion:
        """The sweeps and objects of the checked motion, which the check of overlapping motions needs."""
        objects = {thing.name for sweep in self.sweeps for thing in sweep.things} & self.holding.hung.keys()
        changed = {name for name, hung in self.holding.hung.items() if hung is not self.before.hung[name]}
        return Motion(tuple(self.sweeps), frozenset(objects | changed), frozenset(self.call.bodies))

    # ------------------------------------------------------------------------------------------------- numbers
    def _in_time(self) -> list[Segment]:
        return sorted(self.segments, key=lambda segment: segment.times[0])

    def _timeless(self) -> bool:
        """Whether no path can be made of the segments: joints do not fit, or times do not increase."""
        robots = self.world.scene.robots
        return any(
            list(check_joints(self.node, s, robots[s.robot])) or list(check_times(self.node, s, 0.0))
            for s in self.segments
        )

    def _check_timeline(self) -> Iterator[Finding]:
        ended: dict[str, float] = {}
        for segment in self._in_time():
            yield from check_joints(self.node, segment, self.world.scene.robots[segment.robot])
            yield from check_times(self.node, segment, ended.get(segment.robot, 0.0))
            ended[segment.robot] = segment.times[-1]

    def _check_numbers(self) -> Iterator[Finding]:
        q = {robot: self.q[robot].copy() for robot in self.moved}
        for i in sorted(range(len(self.segments)), key=lambda i: self.segments[i].times[0]):
            segment = self.segments[i]
            arm = self.world.arms[segment.robot]
            yield from check_numbers(self.node, segment, arm.robot, q[segment.robot])
            if (floor := self.world.floors[segment.robot]) is not None:
                yield from check_floor(self.node, segment, arm, floor, q[segment.robot], self.how[i].deviations)
            q[segment.robot][columns(segment, arm)] = segment.waypoints[-1]

    def _check_trajectories(self) -> Iterator[Finding]:
        arms, figures = self.world.arms, self.tally.trajectories
        for i, segment in enumerate(self.segments):
            yield from SegmentJudge(self.node, i, segment, arms[segment.robot], figures).check(self.how[i])
        yield from check_borders(self.node, self.segments, self.how, arms)

    # ------------------------------------------------------------------------------------------------ contacts
    def _check_collision(self, window: Window, path: Path, fine: Path) -> Iterator[Finding]:
        self.now = window.start
        moving, standing = self._things(path)
        self.sweeps.append(Sweep(path, moving, window.running))
        granted = Permits()
        for i in window.running:
            granted = granted.joined(self._granted(i, window))
        roots = {name: self.holding.root(name) for name in self.holding.hung}
        self.tally.stretches.append(
            MotionStretch(self.node, window.running, path, moving, standing, granted.pairs, roots=roots)
        )
        yield from check_collision(self.node, (path, fine), moving, standing, granted, self.world, self.tally)
        if self.added is not None:
            things = moving, standing
            yield from self.added.check(self.node, window, (path, fine), things, granted, self.world, self.holding)

    def _granted(self, i: int, window: Window) -> Permits:
        """The contacts that a segment permits in a window; fingers must not touch an object that an arm then carries."""
        found = self.permitted[i]
        arms = {s.robot for s in map(self.segments.__getitem__, window.running) if self._moves_arm(s)}
        carried = {name for robot in arms for name in self.holding.carried(robot)}
        return Permits(frozenset(pair for pair in found.loose if not pair & carried), found.shifted)

    def _things(self, path: Path) -> tuple[list[SweptBody], list[SweptBody]]:
        """The bodies that move along a path, and all other bodies."""
        moving, standing = [], list(self.start.standing)
        for robot in self.moved:
            if robot in path.arms:
                moving.extend(self.world.links(robot))
            else:
                standing.extend(self.world.links_at(robot, self.q[robot].tolist()))
        for name in self.holding.hung:
            own = self.world.surface_of(self.world.scene.bodies[name])
            if self.holding.holder(name) in path.arms:
                moving.append(SweptBody(name, own, mount=self.holding.mount(name)))
            else:
                standing.append(SweptBody(name, own, self.holding.pose(name)))
        return moving, standing

    def _moves_arm(self, segment: Segment) -> bool:
        return segment.joints == self.world.scene.robots[segment.robot].planned_joints

    # ------------------------------------------------------------------------------------------------- keeping
    def _check_kept(self, segment: Segment, path: Path) -> Iterator[Finding]:
        keep, carried = self.call.keep, self.holding.carried(segment.robot)
        if keep is not None and self._moves_arm(segment) and carried and segment.constraint != keep:
            text = f"{self.call} must keep {keep}, but a segment does not"
            yield Finding(self.node, text, segment.times[0])
        if segment.constraint is None:
            return
        constraints = self.world.scene.motion_constraints.get(segment.constraint)
        if constraints is None:
            yield Finding(self.node, f"the scene has no motion constraint {segment.constraint}", segment.times[0])
            return
        try:
            check_path_constraints(path, constraints, self._owners(segment.robot, carried))
        except UnknownFeatureError as error:
            text = f"{segment.constraint} speaks of {error}, which nobody has here"
            yield Finding(self.node, text, segment.times[0])
        except ConstraintViolation as lapse:
            by = lapse.measure.excess
            how = "cannot be decided" if lapse.undecided else f"is missed by {by:.3g}"
            missed = lapse.constraint
            text = f"{segment.constraint}: {missed.kind}({missed.first}, {missed.second})"
            unit = "m" if lapse.measure.kind == "length" else "rad"
            yield Finding(self.node, f"{text} {how} {unit}", lapse.time, (), max(0.0, by))

    def _owners(self, robot: str, carried: Sequence[str]) -> Owners:
        result: Owners = {}
        tool, arm = self.world.tool_role(robot, self.q[robot]), self.world.arms[robot]
        if tool is not None and arm.robot.tool is not None:
            result["tool"] = tool, arm.mounts[arm.robot.tool.frame]
        held = [name for name in carried if self.holding.root(name) == name]
        name = next(iter(held), self.call.roles.get("object"))
        if name is not None and (name in self.holding.hung or name in self.holding.fixed):
            role = self.world.role(name, self.holding.pose(name))
            result["this"] = role, self.holding.mount(name) if name in carried else None
        return result


def check_end(
    node: str, call: Call, world: SceneModel, changes: AttachmentChanges, time: float
) -> Iterator[Finding]:
    """The findings unless a motion has achieved the result that its procedure requires."""
    spec, holding = call.spec, changes.holding
    if spec is None:
        return
    robot, name = str(call.role("robot")), call.role("object")
    if spec.takes is not None and name not in changes.taken:
        yield Finding(node, f"{call} never takes {name}", time, (str(name),))
    elif spec.takes == "receiver" and holding.holder(str(name)) != call.role(spec.takes):
        yield Finding(node, f"{call} ends without {call.role(spec.takes)} holding {name}", time, (str(name),))
    if spec.lets_go is not None and spec.takes != "receiver" and name not in changes.let_go:
        yield Finding(node, f"{call} never lets go of {name}", time, (str(name),))
    if spec.takes == "receiver" or spec.mates:
        yield from _check_released(node, world, changes, time)
    if spec.mates and frozenset((str(name), str(call.role("other")))) not in changes.mated:
        text = f"{call} never puts {name} and {call.role('other')} together"
        yield Finding(node, text, time, (str(name), str(call.role("other"))))
    if spec.places and spec.lets_go is None and name is not None:
        if holding.holder(name) != robot:
            yield Finding(node, f"{call} moves without holding {name}", time, (name,))
        yield from check_placement(node, time, call, world, holding.pose)
    wanted = None if call.looks(world.scene) else world.scene.robots[robot].configurations.get(call.at or "")
    if wanted is not None and not is_at(world, robot, holding.q.get(robot), wanted):
        yield Finding(node, f"{call} does not end in the configuration {call.at}", time, (robot,))


def _check_released(node: str, world: SceneModel, changes: AttachmentChanges, time: float) -> Iterator[Finding]:
    """A finding unless a hand that has let go what it held is open."""
    for robot, names in changes.had.items():
        for name in sorted(names):
            if changes.holding.holder(name) != robot:
                joint = first_joint_not_open(world, robot, changes.holding.q[robot])
                if joint is not None:
                    text = f"{robot} gave {name} away, but its {joint} is not open at the end"
                    yield Finding(node, text, time, (robot, name))


def is_at(world: SceneModel, robot: str, q: Array | None, wanted: Sequence[float]) -> bool:
    """Whether a robot's planned joints are in the wanted configuration."""
    planned = world.scene.robots[robot].planned
    return q is not None and bool(np.abs(q[:planned] - np.asarray(wanted)).max() <= CONTINUITY_TOLERANCE)
