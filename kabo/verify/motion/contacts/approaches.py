"""Checks that hands approach the objects that they take, and leave those that they release, by a family's strokes.

The arm's last segment before its hand takes an object must be the approach of a grasp family by which the hand
then holds the object. The arm's first segment after the release must be the retreat of the placement, or such an
approach backward.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from kabo.language.scene_description import Stroke as Described
from kabo.verify.motion.calls import Call
from kabo.verify.motion.constraints import Role
from kabo.verify.motion.contacts.attachment_tree import AttachmentTree
from kabo.verify.motion.contacts.families import direction, families_of, placements_of
from kabo.verify.motion.contacts.strokes import Stroke, first_fault, of_family
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.sweep import Path
from kabo.verify.report import Finding


@dataclass
class ApproachesAndRetreats:
    """The check of approaches and retreats in one node; the `Walk` shares and changes `holding`."""

    node: str
    call: Call
    world: SceneModel
    holding: AttachmentTree
    last: dict[str, Path] = field(default_factory=dict)  # robot -> the path of its last arm segment
    due: dict[str, tuple[str, list[tuple[Described, int]]]] = field(
        default_factory=dict
    )  # robot -> object, retreats

    def arm(self, robot: str, path: Path) -> Iterator[Finding]:
        """The findings when an arm begins to move along a path, which must be a retreat if one is due."""
        self.last[robot] = path
        name, strokes = self.due.pop(robot, ("", []))
        if strokes:
            yield from self._judge("leaves", robot, name, strokes, path, backward=False)

    def taken(self, robot: str, name: str, time: float) -> Iterator[Finding]:
        """A finding if a hand has taken an object without the approach of a fitting grasp family."""
        if self.call.spec is None:
            return
        q, pose = self.holding.q[robot], self.holding.pose(name)
        families = [
            family
            for family in families_of(self.world, robot, name, q, pose)
            if self.call.grasp in (None, family.name) or self.call.spec.takes is None
        ]
        if not families or any(family.approach is None for family in families):
            return
        strokes = [(family.approach, -1) for family in families if family.approach is not None]
        if robot not in self.last:
            yield Finding(self.node, f"{robot} takes {name} without an approach", time, (robot, name))
        else:
            yield from self._judge("approaches", robot, name, strokes, self.last[robot], backward=True)

    def letting_go(self, robot: str, name: str) -> None:
        """Records the retreats that are due after a hand lets an object go."""
        if self.call.spec is None or self.holding.holder(name) is None:
            return
        strokes: list[tuple[Described, int] | None] = []
        if self.call.spec.places:
            chosen = placements_of(self.call, self.world, self.holding.pose)
            strokes += [(family.retreat, 1) for family in chosen if family.retreat is not None]
        if not strokes:
            q, pose = self.holding.q[robot], self.holding.pose(name)
            for family in families_of(self.world, robot, name, q, pose):
                strokes.append(None if family.approach is None else (family.approach, -1))
        if None not in strokes and strokes:
            self.due[robot] = name, [each for each in strokes if each is not None]

    def ended(self, time: float) -> Iterator[Finding]:
        """The findings about retreats that are still due when the node has ended."""
        for robot, (name, _) in self.due.items():
            yield Finding(self.node, f"{robot} lets go of {name}, but does not leave it", time, (robot, name))

    def _judge(
        self,
        what: str,
        robot: str,
        name: str,
        described: Sequence[tuple[Described, int]],
        path: Path,
        *,
        backward: bool,
    ) -> Iterator[Finding]:
        arm = self.world.arms[robot]
        assert arm.robot.tool is not None
        mount = arm.mounts[arm.robot.tool.frame]
        q = path.configurations[-1 if backward else 0]
        roles: dict[str, Role] = {"this": self.world.role(name, self.holding.pose(name))}
        tool = self.world.tool_role(robot, q)
        roles |= {} if tool is None else {"tool": tool}
        strokes: list[tuple[str, Stroke]] = []
        for each, sign in described:
            along = direction(each, roles)
            if along is not None:
                limits = of_family(each.minimum, each.maximum)
                points = mount.joint_T_body[None, :3, 3]
                strokes.append((str(each.along), Stroke(path, mount, points, sign * along, limits, backward)))
        wrong = first_fault(strokes)
        if wrong is not None:
            along_what, fault = wrong
            text = f"{robot} {what} {name} by no stroke along {along_what}: it {fault.text}"
            yield Finding(self.node, text, fault.time, (robot, name), max(0.0, fault.by))
