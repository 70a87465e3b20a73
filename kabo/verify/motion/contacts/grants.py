"""Checks the claims of a plan about a segment's contacts: the grasp, the stroke from or to a support, the mate.

The scene must have the family or mate that a claim names, the bodies' poses must satisfy the family or mate, and
the motion must be its stroke.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from kabo.arrays import Array
from kabo.language.scene_description import FeatureName, GraspFamily
from kabo.language.scene_description import Stroke as Described
from kabo.plan import Grant, Segment
from kabo.verify.motion.arms import Mount
from kabo.verify.motion.calls import Call
from kabo.verify.motion.constraints import Role
from kabo.verify.motion.contacts.attachment_tree import AttachmentTree
from kabo.verify.motion.contacts.families import direction, families_of, grips
from kabo.verify.motion.contacts.granted import (
    CONTACT_DEPTHS,
    INITIAL_CONTACT_DEPTHS,
    Permits,
    stands_at,
    touching,
    unstated,
)
from kabo.verify.motion.contacts.mating import Fitting, fittings
from kabo.verify.motion.contacts.strokes import Limits, Stroke, box_corners, of_family, of_mate
from kabo.verify.motion.limits import LIMIT_TOLERANCE
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.sweep import Path, SweptBody
from kabo.verify.motion.trajectories.judge import Followed
from kabo.verify.motion.windows import TIME_TOLERANCE, Window, window_path

DEFAULT_LIFT = Described(FeatureName("world", "up"), 1, 0.05, 0.10)  # where no family declares a lift


class Unfounded(Exception):
    """A claim of the plan that the scene or the motion does not confirm."""


@dataclass
class Grants:
    """The contact claims of a node's segments, each checked when its segment begins.

    `holding` is shared with the walk, which changes it; `standing` are all bodies that do not move in the node;
    `unmoved` are the objects that have not moved since the node began or since they were taken. `holds` maps a
    pair of robot and object to the families by which the object is held, or was held until the hand opened and the
    arm moved away.
    """

    call: Call
    world: SceneModel
    holding: AttachmentTree
    standing: Sequence[SweptBody]
    segments: Sequence[Segment]
    how: Sequence[Followed]
    unmoved: set[str] = field(default_factory=set)
    holds: dict[tuple[str, str], list[GraspFamily]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.unmoved = set(self.holding.hung)
        self.moved = {segment.robot for segment in self.segments}

    # ------------------------------------------------------------------------------------------------ in time
    def permits(self, i: int, path: Path) -> Permits:
        """The contacts that segment i permits along its path; `loose` pairs are fingers and what the hand holds."""
        segment, found = self.segments[i], Permits()
        self._note_holds()
        together = {
            frozenset((a, b))
            for a, b in segment.allowed_contacts
            if a in self.holding.hung and b in self.holding.hung and self.holding.root(a) == self.holding.root(b)
        }
        refused = [
            (f"permits contact of {a} and {b}, but does not say what grants it", (a, b))
            for a, b in unstated(segment, self.world.scene, frozenset(together))
        ]
        allowed = {frozenset(pair) for pair in segment.allowed_contacts}
        for grant in segment.grants:
            try:
                if frozenset(grant.bodies) not in allowed:
                    raise Unfounded("but the contacts that the segment allows do not name the two")
                found = found.joined(self._judged(i, grant, path))
            except Unfounded as error:
                by = {"grasp": "the grasp", "support": "the lift of the grasp", "mate": "the mate"}[grant.kind]
                text = f"lets {' and '.join(grant.bodies)} touch by {by} {grant.by or 'of no family'}, {error}"
                refused.append((text, grant.bodies))
        if self.is_arm(segment) and path.steps.any():  # from now on it is elsewhere
            carried = set(self.holding.carried(segment.robot))
            self.unmoved -= carried
            self.holds = {key: v for key, v in self.holds.items() if key[0] != segment.robot or key[1] in carried}
        return Permits(found.loose, found.shifted, tuple(refused))

    def ended(self, i: int) -> Iterator[tuple[str, tuple[str, str]]]:
        """The false claims about grasps of objects that segment i takes, each as text with two bodies."""
        segment = self.segments[i]
        taken = {name for name, to in segment.attach if to.partition(".")[0] == segment.robot}
        self.unmoved |= taken
        for name in taken:
            self.holds.pop((segment.robot, name), None)
        self._note_holds()
        for grant in segment.grants:
            name = grant.bodies[1]
            if grant.kind == "grasp" and name in taken and not self._fits(segment.robot, name, grant.by):
                yield f"says that the grasp {grant.by} holds {name}, which it does not", grant.bodies

    def is_arm(self, segment: Segment) -> bool:
        """Whether a segment moves an arm, not a hand."""
        return segment.joints == self.world.scene.robots[segment.robot].planned_joints

    def _note_holds(self) -> None:
        for robot, name in ((own, each) for own in self.moved for each in self.holding.carried(own)):
            if self.holding.root(name) == name and (robot, name) not in self.holds:
                self.holds[robot, name] = families_of(
                    self.world, robot, name, self.holding.q[robot], self.holding.pose(name)
                )

    def _fits(self, robot: str, name: str, family: str | None) -> bool:
        """Whether a robot holds or held an object by a family; None fits only a hold that no family declares."""
        found = [each.name for each in self.holds.get((robot, name), [])]
        return family in found if family is not None else not found

    # ------------------------------------------------------------------------------------- one rule for each kind
    def _judged(self, i: int, grant: Grant, path: Path) -> Permits:
        segment = self.segments[i]
        if grant.kind == "grasp":
            return self._grasp(segment, grant, path)
        if not self.is_arm(segment):
            raise Unfounded("but this segment moves a hand, and only arms lift, put down and insert")
        return self._support(i, grant, path) if grant.kind == "support" else self._mate(i, grant)

    def _grasp(self, segment: Segment, grant: Grant, path: Path) -> Permits:
        """The contact of a finger with an object that its hand holds, takes, or has let go in this node."""
        (link, name), robot = grant.bodies, self.world.scene.robots[segment.robot]
        fingers = () if robot.gripper is None else robot.gripper.touch_links
        taken = any(o == name and to.partition(".")[0] == robot.name for o, to in segment.attach)
        if link not in fingers:
            raise Unfounded(f"but {link} is no finger of {robot.name}")
        if name not in self.world.scene.bodies or not (taken or (robot.name, name) in self.holds):
            raise Unfounded(f"but {robot.name} neither holds nor takes {name}")
        family = self.world.scene.bodies[name].grasps.get(grant.by or "")
        if grant.by is not None and (family is None or not taken and not self._fits(robot.name, name, grant.by)):
            raise Unfounded(f"but {robot.name} does not hold {name} in this grasp")
        if grant.by is None and not taken and not self._fits(robot.name, name, None):
            raise Unfounded(f"but {robot.name} holds {name} in a grasp that is declared, and has to name it")
        if self.is_arm(segment):
            return Permits()  # fingers do not move against what they hold
        for joint, (low, high) in grips(self.world, robot.name, family).items():
            if joint in segment.joints:
                values = [row[segment.joints.index(joint)] for row in segment.waypoints]
                off = path.deviations[:, path.arms[robot.name].robot.joint_names.index(joint)].max(initial=0.0)
                off = 0.0 if off <= LIMIT_TOLERANCE else off
                if min(values) - off < low or max(values) + off > high:
                    raise Unfounded(f"but {joint} moves farther than between open and the width of this grasp")
        return Permits(frozenset({frozenset(grant.bodies)}))

    def _support(self, i: int, grant: Grant, path: Path) -> Permits:
        """The contact of an object with a standing support, along the lift or lowering of its grasp family."""
        segment, (name, below) = self.segments[i], grant.bodies
        robot = segment.robot
        if name not in self.holding.hung or self.holding.holder(name) != robot:
            raise Unfounded(f"but {robot} does not hold {name}")
        others = [thing for thing in self._standing_bodies() if thing.name == below]
        if not others:
            raise Unfounded(f"but {below} does not stand still")
        mount, own = self.holding.mount(name), self.world.surface_of(self.world.scene.bodies[name])
        assert mount is not None
        moved, start, end = (
            SweptBody(name, own, mount=mount),
            path.poses(0, 0.0),
            path.poses(len(path.steps) - 1, 1.0),
        )
        backward = not (name in self.unmoved and stands_at(moved, moved.pose(start), others))
        if backward and not (self._stays(i, name) and stands_at(moved, moved.pose(end), others)):
            raise Unfounded(f"but {name} stands on it neither before this segment nor after it")
        lift = self._lift(robot, name, grant.by)
        there = path.configurations[-1 if backward else 0]
        poses = end if backward else start
        roles = self._roles(robot, there, name, moved.pose(poses))
        away = direction(lift, roles)
        if away is None:
            raise Unfounded(f"but {lift.along} is not there")
        limits = of_family(lift.minimum, lift.maximum, any_length=self.call.spec is None)
        what = f"puts {name} down" if backward else f"lifts {name}"
        self._judge_stroke(what, path, mount, own_corners(own), away, limits, backward)
        depth = touching(
            moved, moved.pose(poses), others, away, CONTACT_DEPTHS if backward else INITIAL_CONTACT_DEPTHS
        )
        if depth is None:
            raise Unfounded(f"but where {name} stands the two overlap")
        return Permits(shifted={frozenset(grant.bodies): (name, depth * away)})

    def _standing_bodies(self) -> list[SweptBody]:
        """All bodies that stand still, with objects that are attached to nothing that moves in this node."""
        world, found = self.world, [thing for thing in self.standing if "." not in thing.name]
        for name in self.holding.hung:
            if self.holding.holder(name) not in self.moved:
                own = world.surface_of(world.scene.bodies[name])
                found.append(SweptBody(name, own, self.holding.pose(name)))
        return found

    def _lift(self, robot: str, name: str, by: str | None) -> Described:
        """The lift of the grasp family by which a robot holds an object."""
        root = self.holding.root(name)
        if not self._fits(robot, root, by):
            raise Unfounded(
                f"but {robot} does not hold {root} {'so' if by else 'so: a declared grasp has to be named'}"
            )
        family = None if by is None else self.world.scene.bodies[root].grasps[by]
        return DEFAULT_LIFT if family is None or family.lift is None else family.lift

    def _stays(self, i: int, name: str) -> bool:
        """Whether the object is let go or the node ends before the arm moves again."""
        segment = self.segments[i]
        later = [
            s
            for s in self.segments
            if s.robot == segment.robot and s.times[0] >= segment.times[-1] - TIME_TOLERANCE
        ]
        for other in [segment, *sorted(later, key=lambda s: s.times[0])]:
            if other is not segment and self.is_arm(other):
                return False
            if self.holding.root(name) in other.detach:
                return True
        return True

    def _roles(self, robot: str, q: Array, name: str, world_T: Array) -> dict[str, Role]:
        roles, tool = {"this": self.world.role(name, world_T)}, self.world.tool_role(robot, q)
        return roles if tool is None else {**roles, "tool": tool}

    def _judge_stroke(
        self, what: str, path: Path, mount: Mount, corners: Array, away: Array, limits: Limits, backward: bool
    ) -> None:
        arm = self.world.arms[mount.robot]
        tool = None if arm.robot.tool is None else arm.mounts[arm.robot.tool.frame]
        first = mount if tool is None or tool.joint != mount.joint else tool
        turn, place = mount.joint_T_body[:3, :3], mount.joint_T_body[:3, 3]
        points = np.concatenate([first.joint_T_body[None, :3, 3], corners @ turn.T + place])
        wrong = Stroke(path, mount, points, away, limits, backward).fault()
        if wrong is not None:
            raise Unfounded(f"but the motion that {what} {wrong.text}")

    # ------------------------------------------------------------------------------------------------------- mates
    def _mate(self, i: int, grant: Grant) -> Permits:
        """The contact of two parts that are joined at the end of segment i, along the insertion of their mate."""
        segment, pair, call = self.segments[i], grant.bodies, self.call
        if pair[0] not in self.holding.hung or pair[1] not in {*self.holding.hung, *self.holding.fixed}:
            raise Unfounded("but one of them is no body that can be put together")
        fits = [
            f for f in fittings(call, self.world, *pair) if (f.moving, f.fixed) == pair and f.mate.name == grant.by
        ]
        if not fits:
            raise Unfounded("but the scene declares no such mate of these two")
        if call.spec is not None and not (
            call.spec.mates and set(pair) == {call.role("object"), call.role("other")}
        ):
            raise Unfounded(f"but {call} does not put them together")
        path = self._together(i, pair)
        if not self._joined(frozenset(pair), segment.times[-1]):
            raise Unfounded("but they are not put together where it ends")
        return self._insertion(fits[0], path)

    def _together(self, i: int, pair: Sequence[str]) -> Path:
        """The path of all robots that move one of two parts during segment i, over the same span of time."""
        holders = {self.holding.holder(name) for name in pair if name in self.holding.hung}
        begin, end = self.segments[i].times[0], self.segments[i].times[-1]
        numbers = []
        for k, other in enumerate(self.segments):
            if (
                other.robot in holders
                and other.times[0] < end - TIME_TOLERANCE
                and other.times[-1] > begin + TIME_TOLERANCE
            ):
                if max(abs(other.times[0] - begin), abs(other.times[-1] - end)) > TIME_TOLERANCE:
                    raise Unfounded(f"but {other.robot} begins or ends to move meanwhile")
                numbers.append(k)
        if i not in numbers:
            raise Unfounded(f"but {self.segments[i].robot} holds neither of them")
        window = Window(begin, end, tuple(numbers), tuple(numbers), tuple(numbers))
        return window_path(window, self.segments, self.world.arms, self.holding.q, self.how, fine=True)

    def _joined(self, pair: frozenset[str], time: float) -> bool:
        """Whether two bodies are joined at or after a time, before an arm that holds one of them moves again."""
        holders = {self.holding.holder(name) for name in pair if name in self.holding.hung}
        when = [s.times[-1] for s in self.segments for name, to in s.attach if frozenset((name, to)) == pair]
        joined = min((t for t in when if t >= time - TIME_TOLERANCE), default=None)
        if joined is None:
            return False
        later = [
            s
            for s in self.segments
            if s.robot in holders and self.is_arm(s) and s.times[0] >= time - TIME_TOLERANCE
        ]
        return all(s.times[0] >= joined - TIME_TOLERANCE for s in later)

    def _insertion(self, fit: Fitting, path: Path) -> Permits:
        """The contact that the insertion of a mate grants; no point may leave its line by more than the tolerance."""
        stroke, tolerance = fit.mate.insertion, fit.mate.tolerance
        if stroke is None:
            raise Unfounded("but that mate has no insertion: it grants no contact on the way")
        pose = self._at_end(path)
        roles = {
            name: self.world.role(own, pose(own)) for name, own in (("moving", fit.moving), ("fixed", fit.fixed))
        }
        into = direction(stroke, roles)
        if into is None:
            raise Unfounded(f"but {stroke.along} is not there")
        name, other, away = fit.moving, fit.fixed, -into
        if self.holding.holder(name) not in path.arms:  # the fixed part is the one that moves
            name, other, away = other, name, -away
        mount, beside = self.holding.mount(name), self._mount(other, path)
        assert mount is not None
        own = self.world.surface_of(self.world.scene.bodies[name])
        turn, place = mount.joint_T_body[:3, :3], mount.joint_T_body[:3, 3]
        points = own_corners(own) @ turn.T + place
        limits = of_mate(stroke.minimum, stroke.maximum, tolerance)
        wrong = Stroke(path, mount, points, away, limits, True, len(points), beside).fault()
        if wrong is not None:
            raise Unfounded(f"but its insertion {wrong.text}")
        still = SweptBody(other, self.world.surface_of(self.world.scene.bodies[other]), pose(other))
        depth = touching(SweptBody(name, own), pose(name), [still], away, CONTACT_DEPTHS)
        if depth is None:
            raise Unfounded("but where they are put together the two overlap")
        return Permits(shifted={frozenset((name, other)): (name, depth * away)})

    def _mount(self, name: str, path: Path) -> Mount | None:
        """The mount of a body on a robot that moves along the path; None if it does not move."""
        held = name in self.holding.hung and self.holding.holder(name) in path.arms
        return self.holding.mount(name) if held else None

    def _at_end(self, path: Path) -> Callable[[str], Array]:
        """The function that gives the poses of bodies at the end of a path."""
        later = self.holding.copy()
        for robot in path.arms:
            later.q[robot] = path.configurations[-1][path.columns[robot]]
        return later.pose


def own_corners(surface: object) -> Array:
    """The corners (8, 3) of the bounding box of a surface, in the frame of the surface's body."""
    return box_corners(surface.lower, surface.upper)  # type: ignore[attr-defined]
