"""The margin over time of a plan's motions: at sampled moments, the pair of bodies that is nearest, and how far apart.

Distances are those of the convex parts for which the plan was made, so they are proven from below at these moments.
Between moments the certificate holds; the curve shows where it is tight. Pairs that may touch, and pairs that do not move
against each other, are left out, as in the certificate.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry import FixedGroup, distance
from kabo.geometry_server import SceneSurroundings
from kabo.plan import Plan, Segment
from kabo.planner.certify.component_values import ComponentValues
from kabo.planner.certify.motion_situation import MotionSituation
from kabo.planner.certify.motion_stretches import MotionStretch, stretches
from kabo.scene import Robot, link_poses
from kabo.scene.transforms import flat
from kabo.viewer.content.plan.moving_things import moving_joints, moving_things

EVERY = 0.06  # [s] between two moments
MOST = 60  # moments of a stretch
ALL = 4000  # moments of a plan: of longer ones, each stretch has fewer
DECIMALS = 5  # of times and distances
FAR = 0.5  # [m] farther pairs are not looked at: the curve ends there


@dataclass(frozen=True)
class _Thing:
    """A body or link: what carries it (robot and joint, or None and 0), its group, and its box in its own frame."""

    name: str
    robot: str | None
    joint: int
    enclosure: Any
    middle: Array
    half: Array


class MarginCurves:
    """The margins of the nodes of a plan; `pairs` are the names of all pairs that were nearest somewhere."""

    def __init__(self, plan: Plan, surroundings: SceneSurroundings, values: ComponentValues) -> None:
        self._surroundings, self._scene = surroundings, surroundings.scene
        self._plan, self._values = plan, values
        self._within = self._surroundings.budget.geometry
        self._boxes: dict[str, tuple[Array, Array]] = {}
        self._numbers: dict[tuple[str, str], int] = {}
        stretched = sum(len(node.motion) for node in plan.nodes.values())
        self._most = max(3, min(MOST, ALL // max(1, stretched)))

    @property
    def pairs(self) -> list[list[str]]:
        """The pairs, in the order of their numbers."""
        return [list(pair) for pair in self._numbers]

    def of(self, name: str) -> list[list[float]]:
        """The rows (time [s], distance [m], number of the pair; -1: nothing within FAR) of a node's motion.

        Raises:
            ValueError: something that moves may be in several places.
        """
        motion = self._plan.nodes[name].motion
        moving = list(dict.fromkeys(segment.robot for segment in motion))
        situation = MotionSituation.at(name, self._values, self._scene, moving)
        rows: list[list[float]] = []
        for stretch in stretches(motion, dict(self._scene.robots), situation.q):
            rows.extend(self._stretch(name, motion, stretch, situation))
            for i in stretch.ending:
                situation.end(motion[i])
        return rows

    # ------------------------------------------------------------------------------------------------ one stretch
    def _stretch(
        self, node: str, motion: Sequence[Segment], stretch: MotionStretch, situation: MotionSituation
    ) -> list[list[float]]:
        moving, standing = self._things(node, situation, stretch)
        permitted = {frozenset(pair) for i in stretch.segments for pair in motion[i].allowed_contacts}
        partners = self._partners(moving, standing, permitted, stretch)
        rows = []
        for time in _moments(stretch.times, self._most):
            poses = self._poses(moving, motion, stretch, time)
            least, pair = self._nearest(moving, poses, standing, partners)
            number = -1 if pair is None else self._numbers.setdefault(pair, len(self._numbers))
            rows.append([round(time, DECIMALS), round(least, DECIMALS), number])
        return rows

    def _things(
        self, node: str, situation: MotionSituation, stretch: MotionStretch
    ) -> tuple[list[tuple[_Thing, Array]], list[tuple[_Thing, FixedGroup, Array, Array]]]:
        """The moving things with their pose in their joint's frame, and the standing ones with their box in the world."""
        scene = self._scene
        moving = [
            (self._thing(each.name, each.robot, each.joint), each.joint_T)
            for each in moving_things(scene, situation, stretch)
        ]
        standing = [self._stood(name, pose) for name, pose in scene.fixed_poses.items()]
        for robot in scene.robots.values():
            if robot.name not in stretch.waypoints:
                known = situation.q.get(robot.name)
                for q in [known] if known is not None else self._values.configurations(node, robot.name):
                    standing += self._links(robot, q)
        moved = {thing.name for thing, _ in moving}
        for name in scene.movable:
            if name not in moved:
                places = situation.places.get(name)
                standing += [self._stood(name, pose) for pose in places or [situation.pose(name)]]
        return moving, standing

    def _links(self, robot: Robot, q: Sequence[float] | Array) -> list[tuple[_Thing, FixedGroup, Array, Array]]:
        poses = link_poses(robot, tuple(float(value) for value in q))
        links = [link.name for link in robot.links.values() if link.mesh is not None]
        return [self._stood(f"{robot.name}.{link}", poses[link]) for link in links]

    def _thing(self, name: str, robot: str | None = None, joint: int = 0) -> _Thing:
        if name not in self._boxes:
            mesh = self._surroundings.mesh(name)
            assert mesh is not None
            low, high = mesh.bounds
            self._boxes[name] = (low + high) / 2.0, (high - low) / 2.0 + self._within
        return _Thing(name, robot, joint, self._surroundings.enclosure(name), *self._boxes[name])

    def _stood(self, name: str, pose: Array) -> tuple[_Thing, FixedGroup, Array, Array]:
        thing = self._thing(name)
        return thing, FixedGroup(flat(pose), thing.enclosure), *_box(thing, pose)

    def _partners(
        self,
        moving: Sequence[tuple[_Thing, Array]],
        standing: Sequence[tuple[_Thing, FixedGroup, Array, Array]],
        permitted: set[frozenset[str]],
        stretch: MotionStretch,
    ) -> Array:
        """Which of all things (moving, then standing) each moving thing is compared with: (M, A) of booleans."""
        names = [thing.name for thing, _ in moving] + [thing.name for thing, *_ in standing]
        chains = [self._chain(thing, stretch) for thing, _ in moving]
        compared = np.zeros((len(moving), len(names)), bool)
        for i, (thing, _) in enumerate(moving):
            for k in range(i + 1, len(names)):
                own = chains[k] if k < len(moving) else frozenset()
                compared[i, k] = (
                    chains[i] != own
                    and thing.name != names[k]
                    and frozenset((thing.name, names[k])) not in permitted
                    and not self._surroundings.never_collide(thing.name, names[k])
                )
        return compared

    def _chain(self, thing: _Thing, stretch: MotionStretch) -> frozenset[tuple[str, int]]:
        """The joints that move between the world and a moving thing."""
        name = thing.robot or ""
        joints = moving_joints(self._scene.robots[name], thing.joint, stretch.waypoints[name])
        return frozenset((name, joint) for joint in joints)

    def _poses(
        self,
        moving: Sequence[tuple[_Thing, Array]],
        motion: Sequence[Segment],
        stretch: MotionStretch,
        time: float,
    ) -> list[Array]:
        joints: dict[tuple[str, int], Array] = {}
        found = []
        for segment in (motion[i] for i in stretch.segments):
            robot, q = self._scene.robots[segment.robot], stretch.waypoints[segment.robot][0].copy()
            q[robot.columns(segment.joints)] = segment.at(time)
            joints.update(_joint_poses(robot, q))
        for thing, joint_T in moving:
            found.append(joints[thing.robot or "", thing.joint] @ joint_T)
        return found

    def _nearest(
        self,
        moving: Sequence[tuple[_Thing, Array]],
        poses: Sequence[Array],
        standing: Sequence[tuple[_Thing, FixedGroup, Array, Array]],
        partners: Array,
    ) -> tuple[float, tuple[str, str] | None]:
        """The least distance, by pairs in the order of the distances of their boxes, until no box is nearer."""
        boxes = [_box(thing, pose) for (thing, _), pose in zip(moving, poses, strict=True)]
        boxes += [(middle, half) for _, _, middle, half in standing]
        middles, halves = np.array([middle for middle, _ in boxes]), np.array([half for _, half in boxes])
        count = len(moving)
        apart = np.abs(middles[:count, None] - middles[None]) - halves[:count, None] - halves[None]
        bound = np.where(partners, np.linalg.norm(np.maximum(apart, 0.0), axis=2), np.inf)
        groups: dict[int, FixedGroup] = {}
        least, pair = FAR, None
        for place in np.argsort(bound, axis=None, kind="stable"):
            i, k = divmod(int(place), len(boxes))
            if bound[i, k] >= least:
                break
            for j in (i, k):
                if j not in groups:
                    groups[j] = (
                        FixedGroup(flat(poses[j]), moving[j][0].enclosure) if j < count else standing[j - count][1]
                    )
            found = distance(groups[i], groups[k], self._within).lower
            if found < least:
                other = moving[k][0] if k < count else standing[k - count][0]
                least, pair = found, (moving[i][0].name, other.name)
        return least, pair


def _box(thing: _Thing, pose: Array) -> tuple[Array, Array]:
    """The box of a thing in the world: its middle and half its edges."""
    return pose[:3, :3] @ thing.middle + pose[:3, 3], np.abs(pose[:3, :3]) @ thing.half


def _moments(times: Array, most: int) -> list[float]:
    """The moments of a stretch: both ends, and evenly between."""
    begin, end = float(times[0]), float(times[-1])
    count = int(min(most, max(2, np.ceil((end - begin) / EVERY) + 1)))
    return [float(t) for t in np.linspace(begin, end, count)]


def _joint_poses(robot: Robot, q: Array) -> Mapping[tuple[str, int], Array]:
    """The poses (4, 4) of all joints of a robot in the world, by the robot's name and the joint."""
    from kabo.scene.kernels.poses import forward_kinematics
    from kabo.scene.transforms import unflat

    tree = robot.tree
    world_T = np.zeros((len(tree.parent), 12))
    world_T[0, [0, 4, 8]] = 1.0
    forward_kinematics(q, tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement, world_T)
    return {(robot.name, joint): unflat(row) for joint, row in enumerate(world_T)}
