"""The scene as the verifier sees it: arms, surfaces of the original meshes, and which bodies may touch."""

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from kabo.arrays import Array
from kabo.plan import ObjectPose
from kabo.scene import Body, Link, Scene
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.constraints import Role
from kabo.verify.motion.floors import Floor, floor_of
from kabo.verify.motion.surfaces import Surface, identity, surface
from kabo.verify.motion.sweep import SweptBody


def matrix(pose: ObjectPose) -> Array:
    """The transform parent_T_object (4, 4) of a pose; its quaternion (x, y, z, w) is normalised."""
    x, y, z, w = np.asarray(pose.quaternion) / np.linalg.norm(pose.quaternion)
    result = np.eye(4)
    result[0, :3] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
    result[1, :3] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    result[2, :3] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
    result[:3, 3] = pose.position
    return result


class SceneModel:
    """A scene, with the arms of its robots and the surfaces of its meshes, each computed once."""

    def __init__(self, scene: Scene, models: Mapping[str, str | None] | None = None) -> None:
        self.scene = scene
        self.models = models or {}  # body -> its model, which mates refer to
        self.arms = {name: Arm(robot) for name, robot in scene.robots.items()}
        # The scene keeps surfaces, for whoever verifies several plans in it.
        self._surfaces: dict[bytes, Surface] = scene.memory.setdefault("surfaces", {})
        self._meet: dict[tuple[str, str], bool] = {}

    @cached_property
    def floors(self) -> dict[str, Floor | None]:
        """The floor of each robot whose base drives; None for the others."""
        return {name: floor_of(arm, self.scene.regions) for name, arm in self.arms.items()}

    def surface_of(self, thing: Body | Link) -> Surface:
        """The surface of a body, or of a link with geometry; equal ones share one."""
        assert thing.mesh is not None
        key = identity(thing.mesh, thing.elements)
        if key not in self._surfaces:
            self._surfaces[key] = surface(thing.mesh, thing.elements)
        return self._surfaces[key]

    def may_meet(self, first: str, second: str) -> bool:
        """Whether contact of two bodies (`robot.link` or an object) would be a collision."""
        pair = first, second
        if pair not in self._meet:
            self._meet[pair] = first != second and not self.scene.never_collide(first, second)
        return self._meet[pair]

    @cached_property
    def fixed(self) -> list[SweptBody]:
        """The bodies that never move."""
        poses = self.scene.fixed_poses
        return [SweptBody(name, self.surface_of(self.scene.bodies[name]), poses[name]) for name in poses]

    def links(self, robot: str) -> list[SweptBody]:
        """The links of a robot, each with its mount, for a robot that moves."""
        links, mounts = self.scene.robots[robot].links, self.arms[robot].mounts
        return [
            SweptBody(f"{robot}.{name}", self.surface_of(link), mount=mounts[name])
            for name, link in links.items()
            if link.mesh is not None
        ]

    def links_at(self, robot: str, q: Sequence[float]) -> list[SweptBody]:
        """The links of a robot that stands still in configuration q."""
        joints = {robot: self.arms[robot].joint_poses(q)}
        return [SweptBody(link.name, link.surface, link.pose(joints)) for link in self.links(robot)]

    def role(self, name: str, world_T: Array) -> Role:
        """The body in the given pose world_T (4, 4), with its features, as a role for constraints."""
        return Role(self.scene.bodies[name].features, world_T)

    def tool_role(self, robot: str, q: Array) -> Role | None:
        """The robot's tool in a configuration (n,), as a role for constraints; None if the robot has no tool."""
        tool = self.scene.robots[robot].tool
        if tool is None:
            return None
        return Role(tool.features, self.arms[robot].pose(q.tolist(), self.arms[robot].mounts[tool.frame]))

    def outside(self, body: str, world_T_body: Array, region: str) -> float:
        """The distance by which a body reaches out of a region [m]; 0 or less if it lies inside."""
        volume = self.scene.regions[region]
        region_T_body = np.linalg.inv(volume.world_T_region) @ world_T_body
        vertices = self.scene.bodies[body].mesh.vertices @ region_T_body[:3, :3].T + region_T_body[:3, 3]
        return float((vertices @ volume.normals.T - volume.offsets).max())
