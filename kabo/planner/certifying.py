"""Makes the certificate of a plan: for every stretch of motion, proofs that what moves stays apart from all else.

It works from the plan alone, as whoever checks it will: what is proven is what was written. Where a component may have
several values, each of them is a place of its own.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from kabo.geometry.certificate import Course, Parts, Placed, Prover, Unproven, Witness, ordered
from kabo.geometry_server.surroundings import Surroundings
from kabo.plan import (
    BodyParts,
    Certificate,
    Clearance,
    Node,
    ObjectPose,
    PairProof,
    Plan,
    StretchProof,
    topological_order,
)
from kabo.planner.component_values import ComponentValues, Value
from kabo.planner.motion_stretches import MotionStretch, stretches
from kabo.scene import KinematicTree, Robot, link_poses
from kabo.scene.transforms import flat, inverse, transform, unflat

Array = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
DECIMALS = 6  # of a clearance in metres; rounded down


class Mounted(NamedTuple):
    """An object on a robot that moves in this node: the joint of its tree, and the pose there."""

    robot: str
    joint: int
    joint_T: Array  # (4, 4)


class Thing(NamedTuple):
    """A body at one of its places; moving ones hang on a joint of a robot that is under way."""

    name: str
    place: int
    mesh: str
    robot: str | None
    joint: int
    pose: Array  # (12,) in the joint's frame, or in the world


@dataclass(frozen=True)
class Gap:
    """A pair that no proof was found for: of the node, the stretch with these segments, and where on its path."""

    node: str
    segments: tuple[int, ...]
    between: tuple[str, str]
    piece: float
    gap: float

    def __str__(self) -> str:
        first, second = self.between
        where = f"segment {', '.join(map(str, self.segments))}, piece {self.piece:.3f}"
        return f"{self.node}: {first} and {second} are not proven apart ({where}, gap {self.gap:.3g} m)"


def certify(plan: Plan, surroundings: Surroundings, near: float | None = None) -> Certificate | list[Gap]:
    """The certificate of a plan, or what of it cannot be proven.

    Args:
        plan: as it will be written.
        surroundings: the scene with the parts that the plan was made with.
        near: pairs farther apart than this need no axis [m]; epsilon if None.

    Raises:
        ValueError: the plan moves what may be in several places, or says nothing of its start.
    """
    return _Certifying(plan, surroundings, near or surroundings.budget.epsilon).made()


@dataclass
class _Moment:
    """Where everything is while a node's motion goes on: robots that move in it, and the places of objects."""

    q: dict[str, Array]
    objects: dict[str, list[Mounted | Array]]  # one entry for each place; arrays (4, 4) stand in the world
    hangs_on: dict[str, str] = field(default_factory=dict)


class _Certifying:
    def __init__(self, plan: Plan, surroundings: Surroundings, near: float) -> None:
        order = topological_order(plan)
        if order is None:
            raise ValueError("the plan has a cycle")
        self.plan, self.order, self.near = plan, order, near
        self.surroundings, self.scene = surroundings, surroundings.scene
        self.values = ComponentValues(plan, self.scene, order)
        self.parts = self._all_parts()
        self.prover = Prover(self.parts, near, surroundings.budget.clearance)
        self.gaps: list[Gap] = []
        self._pairs: dict[object, tuple[list[tuple[int, int]], Integers, dict[frozenset[str], list[int]]]] = {}
        self._links = {name: self._links_of(robot) for name, robot in self.scene.robots.items()}
        self._fixed = [
            Thing(name, 0, self._mesh(name), None, 0, flat(pose)) for name, pose in self.scene.fixed_poses.items()
        ]
        self._standing: dict[tuple[str, tuple[float, ...]], list[Array]] = {}

    def made(self) -> Certificate | list[Gap]:
        proofs: list[StretchProof] = []
        segments: list[Clearance] = []
        for name in self.order:
            node = self.plan.nodes[name]
            least: dict[int, tuple[float, tuple[str, str] | None]] = {}
            for proof, margin, between in self._node(name, node) if node.motion else ():
                proofs.append(proof)
                for i in proof.segments:
                    least[i] = min(least.get(i, (np.inf, None)), (margin, between), key=lambda entry: entry[0])
            for i in sorted(least):
                margin, between = least[i]
                told = float(np.floor(margin * 10**DECIMALS)) / 10**DECIMALS if margin < self.near else None
                permitted = node.motion[i].allowed_contacts
                segments.append(Clearance(name, i, told, None if told is None else between, permitted))
        if self.gaps:
            return self.gaps
        bodies = {
            f"sha256:{digest}": BodyParts(
                tuple(map(len, parts.vertices)), np.concatenate(parts.vertices).astype("<f8").tobytes()
            )
            for digest, parts in sorted(self.parts.items())
        }
        return Certificate(self.surroundings.budget.epsilon, tuple(segments), self.near, bodies, tuple(proofs))

    # ------------------------------------------------------------------------------------------------ the scene
    def _all_parts(self) -> dict[str, Parts]:
        names = [
            f"{robot.name}.{link.name}"
            for robot in self.scene.robots.values()
            for link in robot.links.values()
            if link.mesh is not None
        ]
        made: dict[str, Parts] = {}
        for name in [*names, *self.scene.bodies]:
            digest = self._mesh(name)
            if digest not in made:
                made[digest] = ordered(self.surroundings.enclosure(name))
        return made

    def _mesh(self, name: str) -> str:
        mesh = self.surroundings.mesh(name)
        assert mesh is not None
        return mesh.digest

    def _links_of(self, robot: Robot) -> list[Thing]:
        return [
            Thing(
                f"{robot.name}.{link.name}", 0, link.mesh.digest, robot.name, link.joint, flat(link.joint_T_link)
            )
            for link in robot.links.values()
            if link.mesh is not None
        ]

    def _links_at(self, robot: str, q: tuple[float, ...], place: int) -> list[Thing]:
        if (robot, q) not in self._standing:
            poses = link_poses(self.scene.robots[robot], q)
            self._standing[robot, q] = [flat(poses[link.name.partition(".")[2]]) for link in self._links[robot]]
        poses_at = self._standing[robot, q]
        return [
            link._replace(place=place, robot=None, joint=0, pose=pose)
            for link, pose in zip(self._links[robot], poses_at, strict=True)
        ]

    # ------------------------------------------------------------------------------------------------- a node
    def _node(self, name: str, node: Node) -> Iterator[tuple[StretchProof, float, tuple[str, str] | None]]:
        moving = list(dict.fromkeys(segment.robot for segment in node.motion))
        moment = self._moment(name, moving)
        start = moment.q
        for stretch in stretches(node.motion, dict(self.scene.robots), start):
            yield self._stretch(name, node, stretch, moment)
            for i in stretch.ending:
                for held, link in node.motion[i].attach:
                    self._attach(moment, held, link, node)
                for held in node.motion[i].detach:
                    self._detach(moment, held)

    def _moment(self, name: str, moving: Sequence[str]) -> _Moment:
        q = {}
        for robot in moving:
            values = self.values.configurations(name, robot)
            if len(values) != 1:
                raise ValueError(f"{name}: {robot} moves, but has {len(values)} configurations")
            q[robot] = np.array(values[0])
        objects: dict[str, list[Mounted | Array]] = {}
        hangs_on: dict[str, str] = {}
        for thing in self.scene.movable:
            states = self.values.states(name, thing)
            keyed = sorted({repr(key := _key(thing, state)): (key, state) for state in states}.items())
            objects[thing] = [self._placed(thing, state, moving) for _, (_, state) in keyed]
            parents = {state[thing].parent for state in states}  # type: ignore[union-attr]
            if len(parents) == 1:
                hangs_on[thing] = parents.pop()
            if len(objects[thing]) > 1 and any(isinstance(where, Mounted) for where in objects[thing]):
                raise ValueError(f"{name}: {thing} may hang on a robot that moves, or be elsewhere")
        return _Moment(q, objects, hangs_on)

    def _placed(self, name: str, state: Mapping[str, Value], moving: Sequence[str]) -> Mounted | Array:
        if name in self.scene.fixed_poses:
            return self.scene.fixed_poses[name]
        pose = state[name]
        assert isinstance(pose, ObjectPose)
        own = transform(pose.position, pose.quaternion)
        if pose.parent == "world":
            return own
        robot, dot, link = pose.parent.partition(".")
        if not dot:
            below = self._placed(pose.parent, state, moving)
            return Mounted(*below[:2], below.joint_T @ own) if isinstance(below, Mounted) else below @ own
        on = self.scene.robots[robot].links[link]
        if robot in moving:
            return Mounted(robot, on.joint, on.joint_T_link @ own)
        q = state[robot]
        assert isinstance(q, tuple)
        return np.asarray(link_poses(self.scene.robots[robot], q)[link] @ own)

    def _pose(self, moment: _Moment, where: Mounted | Array) -> Array:
        if not isinstance(where, Mounted):
            return where
        robot = self.scene.robots[where.robot]
        return np.asarray(_joint_pose(robot, moment.q[where.robot], where.joint) @ where.joint_T)

    def _attach(self, moment: _Moment, held: str, link: str, node: Node) -> None:
        """The object, and all that hangs on it or will by what the node records, goes on the link."""
        robot, _, own = link.partition(".")
        on = self.scene.robots[robot].links[own]
        joint_T_world = inverse(_joint_pose(self.scene.robots[robot], moment.q[robot], on.joint))
        recorded = {} if node.after is None else {n: pose.parent for n, pose in node.after.objects.items()}
        for name in self.scene.movable:
            if name == held or _descends(name, held, recorded) or _descends(name, held, moment.hangs_on):
                (where,) = moment.objects[name]
                moment.objects[name] = [Mounted(robot, on.joint, joint_T_world @ self._pose(moment, where))]
                moment.hangs_on[name] = (
                    link if name == held else recorded.get(name, moment.hangs_on.get(name, held))
                )

    def _detach(self, moment: _Moment, held: str) -> None:
        moment.hangs_on[held] = "world"
        for name in self.scene.movable:
            if name == held or _descends(name, held, moment.hangs_on):
                (where,) = moment.objects[name]
                moment.objects[name] = [self._pose(moment, where)]

    # ---------------------------------------------------------------------------------------------- a stretch
    def _stretch(
        self, name: str, node: Node, stretch: MotionStretch, moment: _Moment
    ) -> tuple[StretchProof, float, tuple[str, str] | None]:
        robots = [self.scene.robots[robot] for robot in stretch.waypoints]
        first_joint, tree = joined([robot.tree for robot in robots])
        moving, standing = self._things(name, moment, dict(zip(stretch.waypoints, first_joint, strict=True)))
        things = [*moving, *standing]
        permitted = frozenset(frozenset(p) for i in stretch.segments for p in node.motion[i].allowed_contacts)
        numbers, pairs = self._chosen(things, len(moving), permitted, tree)
        waypoints = np.hstack([stretch.waypoints[robot.name] for robot in robots])
        bodies = [Placed(thing.mesh, thing.joint, thing.pose) for thing in things]
        found = self.prover.prove(Course(tree, np.ascontiguousarray(waypoints), bodies, pairs))
        if isinstance(found, Unproven):
            a, b = (things[i].name for i in numbers[found.pair])
            self.gaps.append(Gap(name, stretch.segments, (a, b), found.start, found.gap))
            return StretchProof(name, stretch.segments), np.inf, None
        return self._proof(name, stretch, things, numbers, found)

    def _proof(
        self,
        name: str,
        stretch: MotionStretch,
        things: Sequence[Thing],
        numbers: Sequence[tuple[int, int]],
        found: Sequence[Witness | None],
    ) -> tuple[StretchProof, float, tuple[str, str] | None]:
        proofs, least, between = [], np.inf, None
        for (i, k), witness in zip(numbers, found, strict=True):
            if witness is not None:
                first, second = things[i], things[k]
                proofs.append(PairProof(first.name, second.name, second.place, witness.walk, witness.axes))
                if witness.margin < least:
                    least, between = witness.margin, (first.name, second.name)
        return StretchProof(name, stretch.segments, tuple(proofs)), least, between

    def _things(self, name: str, moment: _Moment, first: Mapping[str, int]) -> tuple[list[Thing], list[Thing]]:
        """What moves, on the joints of the joined tree, and what stands."""
        moving: list[Thing] = []
        standing = list(self._fixed)
        for robot in self.scene.robots:
            if robot in first:
                shift = first[robot]
                moving.extend(
                    link._replace(joint=link.joint + shift if link.joint else 0) for link in self._links[robot]
                )
            elif robot in moment.q:
                standing.extend(self._links_at(robot, tuple(moment.q[robot].tolist()), 0))
            else:
                for place, q in enumerate(self.values.configurations(name, robot)):
                    standing.extend(self._links_at(robot, q, place))
        for body, places in moment.objects.items():
            for place, where in enumerate(places):
                mesh = self.scene.bodies[body].mesh.digest
                if isinstance(where, Mounted) and where.robot in first:
                    joint = where.joint + first[where.robot] if where.joint else 0
                    moving.append(Thing(body, 0, mesh, where.robot, joint, flat(where.joint_T)))
                else:
                    standing.append(Thing(body, place, mesh, None, 0, flat(self._pose(moment, where))))
        return moving, standing

    def _chosen(
        self,
        things: Sequence[Thing],
        moving: int,
        permitted: frozenset[frozenset[str]],
        tree: KinematicTree,
    ) -> tuple[list[tuple[int, int]], Integers]:
        """The pairs to prove: their numbers, and with the joint in whose frame each is looked at."""
        key = moving, len(tree.parent), tuple((thing.name, thing.joint) for thing in things)
        if key not in self._pairs:
            self._pairs[key] = self._comparable(things, moving, tree)
        numbers, rows, by_names = self._pairs[key]
        left_out = [number for pair in permitted for number in by_names.get(pair, ())]
        if not left_out:
            return numbers, rows
        kept = np.ones(len(numbers), bool)
        kept[left_out] = False
        return [numbers[i] for i in np.flatnonzero(kept)], rows[kept]

    def _comparable(
        self, things: Sequence[Thing], moving: int, tree: KinematicTree
    ) -> tuple[list[tuple[int, int]], Integers, dict[frozenset[str], list[int]]]:
        """The pairs that may not touch, and the numbers of each by its names."""
        numbers: list[tuple[int, int]] = []
        rows: list[tuple[int, int, int]] = []
        by_names: dict[frozenset[str], list[int]] = {}
        chains = [_chain(tree, thing.joint) for thing in things]
        for i in range(moving):
            first, own = things[i].name, chains[i]
            for k in range(i + 1, len(things)):
                second = things[k].name
                if first != second and not self.surroundings.never_collide(first, second):
                    by_names.setdefault(frozenset((first, second)), []).append(len(numbers))
                    numbers.append((i, k))
                    rows.append((i, k, next((joint for joint in chains[k] if joint in own), 0)))
        return numbers, np.array(rows, np.int64).reshape(-1, 3), by_names


def _key(name: str, state: Mapping[str, Value]) -> tuple[object, ...]:
    """What decides where an object is, in numbers of the plan."""
    pose = state[name]
    assert isinstance(pose, ObjectPose)
    parent, dot, _ = pose.parent.partition(".")
    below: object = state[parent] if dot else _key(parent, state) if parent in state else ()
    return pose.parent, pose.position, pose.quaternion, below


def _descends(name: str, ancestor: str, hangs_on: Mapping[str, str]) -> bool:
    """Whether one object hangs on another, directly or through others."""
    seen = {name}
    while (parent := hangs_on.get(name)) is not None and parent not in seen:
        if parent == ancestor:
            return True
        seen.add(parent)
        name = parent
    return False


def _joint_pose(robot: Robot, q: Array, joint: int) -> Array:
    """The pose (4, 4) of a joint of the robot's tree."""
    from kabo.scene.kernels.poses import forward_kinematics

    tree = robot.tree
    world_T = np.zeros((len(tree.parent), 12))
    world_T[0, [0, 4, 8]] = 1.0
    forward_kinematics(q, tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement, world_T)
    return unflat(world_T[joint])


def _chain(tree: KinematicTree, joint: int) -> dict[int, None]:
    """The joints from one to the base; the first that is also in another chain is the last that carries both."""
    chain: dict[int, None] = {}
    while joint > 0:
        chain[joint] = None
        joint = int(tree.parent[joint])
    return chain


def joined(trees: Sequence[KinematicTree]) -> tuple[list[int], KinematicTree]:
    """Several trees as one whose configuration is theirs one after the other; by how much the joints of each shift."""
    if len(trees) == 1:
        return [0], trees[0]
    shifts, parents, sources = [], [np.zeros(1, np.int64)], [np.zeros(1, np.int64)]
    joints, values = 1, 0
    for tree in trees:
        shift = joints - 1
        shifts.append(shift)
        own = np.asarray(tree.parent[1:])
        parents.append(np.where(own > 0, own + shift, 0))
        sources.append(np.asarray(tree.source[1:]) + values)
        joints += len(own)
        values += tree.size
    first = trees[0]
    return shifts, KinematicTree(
        np.concatenate(parents),
        np.concatenate([first.kind[:1], *(tree.kind[1:] for tree in trees)]),
        np.concatenate(sources),
        np.concatenate([first.ratio[:1], *(tree.ratio[1:] for tree in trees)]),
        np.concatenate([first.shift[:1], *(tree.shift[1:] for tree in trees)]),
        np.concatenate([first.placement[:1], *(tree.placement[1:] for tree in trees)]),
        np.concatenate([tree.lower for tree in trees]),
        np.concatenate([tree.upper for tree in trees]),
        np.concatenate([tree.velocity for tree in trees]),
    )
