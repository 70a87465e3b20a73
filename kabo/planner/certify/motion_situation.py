"""The poses of all objects during the motion of a node: robots, attached objects, and those with several poses.

Objects attached to each other move as one group. When one of them is grasped, it becomes the root of the group,
and the others are attached to it, directly or indirectly.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.plan import ObjectPose, Segment
from kabo.planner.certify.component_values import ComponentValues, Value
from kabo.scene import Robot, Scene, link_pose
from kabo.scene.kernels.poses import forward_kinematics
from kabo.scene.transforms import inverse, transform, unflat


class Mounted(NamedTuple):
    """The attachment of an object to a robot: a joint of the robot's tree, and the pose (4, 4) in its frame."""

    robot: str
    joint: int
    joint_T: Array


@dataclass
class MotionSituation:
    """The known robot configurations, attached objects with their poses, and the poses of objects with several.

    Robots with several possible configurations are left out.
    """

    scene: Scene
    q: dict[str, Array] = field(default_factory=dict)
    hung: dict[str, tuple[str, Array]] = field(default_factory=dict)  # object -> parent, parent_T_object (4, 4)
    places: dict[str, list[Array]] = field(default_factory=dict)  # object -> poses in the world

    @classmethod
    def at(cls, node: str, values: ComponentValues, scene: Scene, moving: Sequence[str]) -> "MotionSituation":
        """The situation at the start of a node's motion; `moving` names the robots that move.

        Raises:
            ValueError: a robot that moves, or what it carries, may be in several places.
        """
        made = cls(scene)
        for robot in scene.robots:
            found = values.configurations(node, robot)
            if len(found) == 1:
                made.q[robot] = np.array(found[0])
            elif robot in moving:
                raise ValueError(f"{node}: {robot} moves, but has {len(found)} configurations")
        for name in scene.movable:
            states = values.states(node, name)
            keyed = {repr(key_of(name, state)): state for state in states}
            if len(keyed) == 1:
                pose = states[0][name]
                assert isinstance(pose, ObjectPose)
                made.hung[name] = pose.parent, transform(pose.position, pose.quaternion)
            else:
                made.places[name] = [_world_T(scene, name, keyed[key]) for key in sorted(keyed)]
        return made

    def end(self, segment: Segment) -> None:
        """Applies the changes at the end of a segment: detaches objects, then attaches others."""
        for name in segment.detach:
            if self._root_parent(name).partition(".")[0] == segment.robot:
                self._hang(name, "world")
        for name, to in segment.attach:
            self._hang(name, to)

    def mounted(self, name: str) -> Mounted | None:
        """The robot joint that carries an object, and the object's pose there; None if no robot carries it."""
        parent, parent_T = self.hung[name]
        robot, dot, link = parent.partition(".")
        if dot:
            on = self.scene.robots[robot].links[link]
            return Mounted(robot, on.joint, on.joint_T_link @ parent_T)
        below = self.mounted(parent) if parent in self.hung else None
        return None if below is None else below._replace(joint_T=below.joint_T @ parent_T)

    def pose(self, name: str) -> Array:
        """The present pose (4, 4) of an object in the world."""
        parent, parent_T = self.hung[name]
        return np.asarray(self._frame(parent) @ parent_T)

    def _frame(self, parent: str) -> Array:
        if parent == "world":
            return np.eye(4)
        if parent in self.scene.fixed_poses:
            return self.scene.fixed_poses[parent]
        robot, dot, link = parent.partition(".")
        if not dot:
            return self.pose(parent)
        on = self.scene.robots[robot].links[link]
        return np.asarray(joint_pose(self.scene.robots[robot], self.q[robot], on.joint) @ on.joint_T_link)

    def root(self, name: str) -> str:
        """The object at the root of the group of attached objects that contains the named one."""
        while self.hung[name][0] in self.hung:
            name = self.hung[name][0]
        return name

    @property
    def roots(self) -> dict[str, str]:
        """For each object whose place is known, the root of its group."""
        return {name: self.root(name) for name in self.hung}

    def _root_parent(self, name: str) -> str:
        return self.hung[self.root(name)][0]

    def _hang(self, name: str, parent: str) -> None:
        """Hangs an object, with its whole group, on something else, without moving it."""
        world_T, chain = self.pose(name), [name]
        while self.hung[chain[-1]][0] in self.hung:
            chain.append(self.hung[chain[-1]][0])
        turned = [
            (above, (below, inverse(self.hung[below][1]))) for below, above in zip(chain, chain[1:], strict=False)
        ]
        self.hung.update(turned)
        self.hung[name] = parent, inverse(self._frame(parent)) @ world_T


def joint_pose(robot: Robot, q: Array, joint: int) -> Array:
    """The pose (4, 4) of a joint of the robot's tree in the world."""
    tree = robot.tree
    world_T = np.zeros((len(tree.parent), 12))
    world_T[0, [0, 4, 8]] = 1.0
    forward_kinematics(q, tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement, world_T)
    return unflat(world_T[joint])


def key_of(name: str, state: Mapping[str, Value]) -> tuple[object, ...]:
    """A key that determines an object's pose: its parent, its pose relative to it, and the parent's own key.

    If the parent is a link of a robot, the robot's configuration takes the place of the parent's key.
    """
    pose = state[name]
    assert isinstance(pose, ObjectPose)
    parent, dot, _ = pose.parent.partition(".")
    below: object = state[parent] if dot else key_of(parent, state) if parent in state else ()
    return pose.parent, pose.position, pose.quaternion, below


def _world_T(scene: Scene, name: str, state: Mapping[str, Value]) -> Array:
    if name in scene.fixed_poses:
        return scene.fixed_poses[name]
    pose = state[name]
    assert isinstance(pose, ObjectPose)
    own = transform(pose.position, pose.quaternion)
    if pose.parent == "world":
        return own
    robot, dot, link = pose.parent.partition(".")
    if not dot:
        return np.asarray(_world_T(scene, pose.parent, state) @ own)
    q = state[robot]
    assert isinstance(q, tuple)
    return np.asarray(link_pose(scene.robots[robot], q, link) @ own)
