"""The workspace of one robot in a situation: everything that moves with it, and all possible obstacles.

Carried objects are attached to the robot's joints. All other things are obstacles at every pose that they may have
in the situation, so one collision check covers all values of the other components.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from time import perf_counter
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from kabo.arrays import Array, Booleans, Integers
from kabo.geometry import CollisionChecker, FixedGroup, MovingGroup
from kabo.geometry_server.answers import Pair
from kabo.geometry_server.checked_pairs import CheckedPairs, Contacts, contacts, first_along
from kabo.geometry_server.configurations import joints_at
from kabo.geometry_server.driving.floor_view import FloorView
from kabo.geometry_server.extras import Extra
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.scene import Attachment, Configuration, Robot
from kabo.scene.transforms import flat, inverse, transform, unflat

_Answer = TypeVar("_Answer")
BOX_TOLERANCE = 1e-9  # [m]: far more than rounding of box coordinates


@dataclass(frozen=True)
class Workspace:
    """One robot, what it carries, and all other things, with the contacts that are permitted."""

    surroundings: SceneSurroundings
    robot: Robot
    situation: Situation
    carried: Mapping[str, Attachment]
    permitted: Contacts = frozenset()
    extras: tuple[Extra, ...] = ()
    base: "Workspace | None" = field(
        default=None, compare=False, repr=False
    )  # the same without permitted contacts

    @classmethod
    def of(
        cls,
        surroundings: SceneSurroundings,
        robot: str,
        situation: Situation,
        permitted: Contacts = frozenset(),
        extras: tuple[Extra, ...] = (),
    ) -> "Workspace":
        """The workspace of a robot with everything that it carries in the situation."""
        carried = {name: situation.held(name) for name in situation.carried(robot)}
        return cls(surroundings, surroundings.scene.robots[robot], situation, carried, permitted, extras)

    def relevant(self, permitted: Contacts) -> Contacts:
        """The permitted contacts that involve a moving thing, except those between the gripper and the objects it holds."""
        if not permitted:
            return permitted
        own = self.robot.name + "."
        moving = {name for pair in permitted for name in pair if name.startswith(own) or name in self.carried}
        moving |= {extra.name for extra in self.extras}
        return frozenset(pair for pair in permitted if pair & moving and pair not in self._touched)

    @cached_property
    def _touched(self) -> Contacts:
        """The contacts of the gripper with what it holds."""
        return contacts(pair for name in self.carried for pair in self.touching(name))

    def touching(self, name: str) -> tuple[Pair, ...]:
        """The contacts of the gripper's touch links with a held object; empty for an object attached to a held object."""
        gripper = self.robot.gripper
        if gripper is None or self.situation.root(name) != name:
            return ()
        return tuple((link, name) for link in gripper.touch_links)

    def first_hit(self, q: Array) -> Pair | None:
        """The first pair that is not proven apart at configuration q (n,), or None if all are."""
        index = self._asked(lambda view: view.configuration_hit(q))
        return None if index < 0 else self.pairs[index]

    def hits(self, configurations: Array) -> Integers:
        """For each configuration (N, n) the index of the first pair not proven apart, or -1."""
        return self._asked(lambda view: view.configurations_hit(configurations))

    def segment_hit(self, start: Array, goal: Array, deviation: Array | None = None) -> int:
        """-1 if a straight joint segment is proven free, and all by a `deviation` (n,) [rad or m] from it; else a pair."""
        return self._asked(lambda view: view.segment_hit(start, goal, deviation))

    def segments_hit(self, starts: Array, ends: Array, deviations: Array) -> Integers:
        """The result of `segment_hit` for every row of three arrays (N, n)."""
        return self._asked(lambda view: view.segments_hit(starts, ends, deviations))

    def segments_free_early(self, starts: Array, ends: Array, deviations: Array) -> Booleans:
        """Which rows (N,) are proven free without dividing any part, which takes seconds."""
        return self._asked(lambda view: view.segments_free_early(starts, ends, deviations))

    def path_hit(self, waypoints: Sequence[Array], deviations: Array | None = None) -> Pair | None:
        """The first pair not proven free on a path of straight joint segments, or None.

        `deviations` (m - 1, n): how far each joint may be from each segment [rad or m]; None for zeros.
        """
        index = first_along(self.segments_hit, np.array(waypoints), deviations, by_one=self.surroundings.exact)
        return None if index < 0 else self.pairs[index]

    @property
    def pairs(self) -> list[Pair]:
        """The names of all pairs that are checked, in the order of their indices."""
        return self._view[1]

    @property
    def checker(self) -> CollisionChecker:
        """The collision checker; who asks it without `counted` is not counted."""
        return self._view[0]

    def _asked(self, question: Callable[[CollisionChecker], _Answer]) -> _Answer:
        return self.counted(lambda: question(self.checker))

    def counted(self, question: Callable[[], _Answer]) -> _Answer:
        """The answer; counts its checks once for the robot and once for each thing that it carries."""
        view, began = self.checker, perf_counter()
        before = view.counters.numbers
        answer = question()
        configurations, sweeps, pairs, positive = (
            now - then for now, then in zip(view.counters.numbers, before, strict=True)
        )
        statistics = self.surroundings.statistics
        statistics.collision_checks += (1 + len(self.carried)) * (configurations + sweeps)
        statistics.positive_collision_checks += positive
        statistics.pair_checks += pairs
        statistics.collision_s += perf_counter() - began
        return answer

    def hand_hit(self, world_T_joint: Array, joint: int, joints: Sequence[int], q: Array) -> Pair | None:
        """The first pair of a body on the given joints and a standing thing that is not proven apart; None if all are.

        Args:
            world_T_joint: the pose (4, 4) of `joint`, whatever the arm's joint values.
            joint: the joint that is put at this pose.
            joints: `joint` and the joints that it carries.
            q: a configuration (n,), which determines the poses of `joints` relative to `joint`.
        """
        moving, fixed, pairs = self._bodies
        corners, low, high = self._boxes
        at = joints_at(self.robot.tree, q)
        shift = world_T_joint @ inverse(unflat(at[joint]))
        placed: dict[int, tuple[FixedGroup, npt.NDArray[np.bool_]]] = {}
        for i, own in enumerate(moving):
            if own.joint in joints:
                pose = shift @ unflat(at[own.joint]) @ unflat(own.joint_T_group)
                box = corners[i] @ pose[:3, :3].T + pose[:3, 3]
                slack = own.kept + BOX_TOLERANCE
                near = ((box.min(axis=0) <= high + slack) & (box.max(axis=0) >= low - slack)).all(axis=1)
                placed[i] = FixedGroup(flat(pose), own.enclosure, own.mesh, own.elements, own.kept), near
        for (i, k), pair in zip(pairs.indices.tolist(), pairs.names, strict=True):
            if i in placed and k >= len(moving):
                body, near = placed[i]
                if near[k - len(moving)] and self.surroundings.touch(body, fixed[k - len(moving)]):
                    return pair
        return None

    @cached_property
    def _boxes(self) -> tuple[list[Array], Array, Array]:
        """Corners (8, 3) of the box of each moving body in its own frame, boxes (F, 3) of all fixed ones in the world.

        The boxes of fixed ones are grown by what these keep from others.
        """
        if self.base is not None:
            return self.base._boxes
        moving, fixed = self._bodies[:2]
        poses = [unflat(body.world_T_group) for body in fixed]
        standing = [b.enclosure.box_corners() @ T[:3, :3].T + T[:3, 3] for b, T in zip(fixed, poses, strict=True)]
        around = np.array(standing).reshape(-1, 8, 3)
        kept = np.array([body.kept for body in fixed])[:, None]
        return (
            [body.enclosure.box_corners() for body in moving],
            around.min(axis=1) - kept,
            around.max(axis=1) + kept,
        )

    @cached_property
    def _bodies(self) -> tuple[list[MovingGroup], list[FixedGroup], CheckedPairs]:
        if self.base is not None:
            moving, fixed, pairs = self.base._bodies
            if self.surroundings.keeps:
                fixed = self._grasped(moving, fixed, pairs)
            return moving, fixed, pairs.without(self.permitted)
        moving, moving_names = self._moving()
        fixed, fixed_names = self._fixed()
        # They depend on what there is, not on where it is.
        key = "pairs", self.robot.name, self.permitted, self._touched, self.extras, *moving_names, *fixed_names
        checked = self.surroundings.lasting(key, lambda: self._pairs(moving_names, fixed_names))
        return moving, fixed, checked

    def _grasped(
        self, moving: list[MovingGroup], fixed: list[FixedGroup], pairs: CheckedPairs
    ) -> list[FixedGroup]:
        """The fixed bodies, of which some keep no distance from a hand of the robot, nor from what it holds.

        They are those that the hand may touch, and what is attached to a body that something in the hand may touch.
        """
        near: dict[str, int] = {}
        for i, (first, second) in pairs.among(self.permitted):
            if moving[i].hand:
                touched = self._attached_to(second) if first in self.carried else (second,)
                near |= dict.fromkeys(touched, moving[i].hand)
        found = list(fixed)
        for (_, k), (_, second) in zip(pairs.indices.tolist(), pairs.names, strict=True):
            if k >= len(moving) and second in near:
                found[k - len(moving)] = replace(fixed[k - len(moving)], hand=near[second])
        return found

    def _attached_to(self, name: str) -> tuple[str, ...]:
        """The other objects of an object's group, which move with it."""
        if name not in self.situation.objects:
            return ()
        return tuple(other for other in self.situation.group(name) if other != name)

    @cached_property
    def _view(self) -> tuple[CollisionChecker, list[Pair]]:
        moving, fixed, pairs = self._bodies
        view, drive = self.surroundings.checker(self.robot.tree, moving, fixed, pairs.indices), self.robot.drive
        if drive is None:
            return view, pairs.names
        epsilon, names = self.surroundings.budget.epsilon, pairs.names
        base = f"{self.robot.name}.{drive.links[0]}"
        return FloorView(view, drive, len(names), epsilon), [*names, (base, drive.floor)]

    def _moving(self) -> tuple[list[MovingGroup], list[tuple[str, int]]]:
        own = self.surroundings.lasting(("moving links", self.robot.name), self._moving_links)
        groups, names = list(own[0]), list(own[1])
        for name, held in self.carried.items():
            link = self.robot.links[held.parent.partition(".")[2]]
            pose = link.joint_T_link @ transform(held.position, held.quaternion)
            groups.append(self._group(name, link.joint, pose))
            names.append((name, link.joint))
        for extra in self.extras:
            hung = self._hung(extra)
            if hung is not None and self._moves(hung[0]):
                enclosure = self.surroundings.enclosed(extra.element)
                arrays = extra.mesh.vertices, extra.mesh.faces
                own = flat(hung[1] @ extra.parent_T)
                groups.append(MovingGroup(hung[0], own, enclosure, arrays, (extra.element,)))
                names.append((extra.name, hung[0]))
        return groups, names

    def _moving_links(self) -> tuple[list[MovingGroup], list[tuple[str, int]]]:
        links = [each for each in self.robot.links.values() if each.mesh is not None and self._moves(each.joint)]
        names = [(f"{self.robot.name}.{link.name}", link.joint) for link in links]
        return [
            self._group(name, j, link.joint_T_link) for (name, j), link in zip(names, links, strict=True)
        ], names

    def _hung(self, extra: Extra) -> tuple[int, Array] | None:
        """The joint that carries the parent of an extra body, and the parent's pose in its frame; None if there is none."""
        robot, dot, own = extra.parent.partition(".")
        if dot:
            link = self.robot.links[own] if robot == self.robot.name else None
            return None if link is None else (link.joint, link.joint_T_link)
        if extra.parent not in self.carried:
            return None
        held = self.carried[extra.parent]
        link = self.robot.links[held.parent.partition(".")[2]]
        return link.joint, link.joint_T_link @ transform(held.position, held.quaternion)

    def _moves(self, joint: int) -> bool:
        tree = self.robot.tree
        while joint > 0 and tree.ratio[joint] == 0.0:
            joint = int(tree.parent[joint])
        return joint > 0

    def _group(self, name: str, joint: int, joint_T_group: Array) -> MovingGroup:
        mesh = self.surroundings.mesh(name)
        arrays = None if mesh is None else (mesh.vertices, mesh.faces)
        elements = self.surroundings.elements(name)
        kept = self.surroundings.asked(name, self.robot.name if name in self.carried else None)
        return MovingGroup(
            joint,
            flat(joint_T_group),
            self.surroundings.enclosure(name),
            arrays,
            elements,
            kept,
            self.robot.hand(joint),
        )

    def _fixed(self) -> tuple[list[FixedGroup], list[str]]:
        groups, names = list[FixedGroup](), list[str]()
        for robot in self.surroundings.scene.robots.values():
            for q in self.situation.robots[robot.name]:
                # Where they are decides, which for links that do not move with the robot itself is always the same.
                key = "standing links", self.robot.name, robot.name, None if robot is self.robot else q
                keep = self.surroundings.lasting if robot is self.robot else self.surroundings.remembered
                links = keep(key, partial(self._standing_links, robot, q))
                groups.extend(links.values())
                names.extend(links)
        for name in self.surroundings.scene.bodies:
            if name not in self.carried:
                own = [self._standing(name, pose) for pose in self.surroundings.poses(self.situation, name)]
                groups.extend(own)
                names.extend([name] * len(own))
        for extra in self.extras:
            hung = self._hung(extra)
            if hung is None or not self._moves(hung[0]):
                enclosure, arrays = (
                    self.surroundings.enclosed(extra.element),
                    (extra.mesh.vertices, extra.mesh.faces),
                )
                for pose in self._poses(extra.parent):
                    groups.append(FixedGroup(flat(pose @ extra.parent_T), enclosure, arrays, (extra.element,)))
                    names.append(extra.name)
        return groups, names

    def _standing_links(self, robot: Robot, q: Configuration) -> dict[str, FixedGroup]:
        """The links of a robot at q that do not move with this one, by name."""
        poses, links = self.surroundings.links(robot.name, q), robot.links.values()
        own = robot is self.robot
        chosen = [each.name for each in links if each.mesh is not None and not (own and self._moves(each.joint))]
        return {f"{robot.name}.{name}": self._standing(f"{robot.name}.{name}", poses[name]) for name in chosen}

    def _poses(self, parent: str) -> list[Array]:
        robot, dot, link = parent.partition(".")
        if parent == "world":
            return [np.eye(4)]
        if dot:
            return [self.surroundings.links(robot, q)[link] for q in self.situation.robots[robot]]
        return self.surroundings.poses(self.situation, parent)

    def _standing(self, name: str, pose: Array) -> FixedGroup:
        mesh = self.surroundings.mesh(name)
        arrays = None if mesh is None else (mesh.vertices, mesh.faces)
        elements = self.surroundings.elements(name)
        others = (robot for robot in self.situation.robots if name in self.situation.carried(robot))
        kept = self.surroundings.asked(name, next(others, None) if self.surroundings.keeps else None)
        return FixedGroup(flat(pose), self.surroundings.enclosure(name), arrays, elements, kept)

    def _pairs(self, moving: list[tuple[str, int]], fixed: list[str]) -> CheckedPairs:
        indices, names = list[tuple[int, int]](), list[Pair]()
        for i, (first, joint) in enumerate(moving):
            for k, (second, other_joint) in enumerate(moving[i + 1 :], i + 1):
                if joint != other_joint and self._checked(first, second):
                    indices.append((i, k))
                    names.append((first, second))
            for k, second in enumerate(fixed, len(moving)):
                if self._checked(first, second):
                    indices.append((i, k))
                    names.append((first, second))
        return CheckedPairs(np.array(indices, np.int64).reshape(-1, 2), names)

    def _checked(self, first: str, second: str) -> bool:
        added = self.extras and [extra for extra in self.extras if extra.name in (first, second)]
        if not added and self.surroundings.never_collide(first, second):
            return False
        pair = frozenset((first, second))
        if pair in self.permitted or pair in self._touched:
            return False
        if added:
            return len(added) == 1 and self._checked_extra(added[0], second if added[0].name == first else first)
        return True

    def _checked_extra(self, extra: Extra, other: str) -> bool:
        """Whether an extra body is checked against a thing; padding may touch what its parent may touch."""
        if other == extra.parent:
            return False
        if extra.parent == "world":
            return True
        if extra.pads and self._hung(extra) is not None:
            with_it = other in self.carried or other.startswith(self.robot.name + ".")
            return not with_it and self._checked(extra.parent, other)
        return self._checked(extra.parent, other)


def workspace_of(
    surroundings: SceneSurroundings,
    robot: str,
    situation: Situation,
    permitted: Contacts = frozenset(),
    extras: tuple[Extra, ...] = (),
) -> "Workspace":
    """The workspace of a robot in a situation; recent workspaces are kept.

    It does not depend on the configuration of the robot itself.
    """
    others = tuple(item for item in situation.robots.items() if item[0] != robot)
    key = robot, others, tuple(situation.objects.items()), extras
    plain: Workspace = surroundings.remembered(
        (*key, None), lambda: Workspace.of(surroundings, robot, situation, extras=extras)
    )
    relevant = plain.relevant(permitted)
    if not relevant:
        return plain
    base = None if extras else plain
    found: Workspace = surroundings.remembered(
        (*key, relevant), lambda: replace(plain, permitted=relevant, base=base)
    )
    return found
