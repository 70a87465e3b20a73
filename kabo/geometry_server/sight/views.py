"""Views: whether a camera sees an object, proven within epsilon, or why it does not [docs/how-to/sensing.md].

An object is seen if the sight lines from the camera's origin to all of it are proven free of everything else, and all
of it is proven to lie within the camera's field of view and range.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.spatial import ConvexHull

from kabo import geometry  # its names load when they are used: python-fcl only for bodies that touch the object
from kabo.arrays import Array
from kabo.geometry import Enclosure, FixedGroup
from kabo.geometry_server.configurations import joints_at
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.scene import Robot, Sensor, beyond_angle
from kabo.scene.transforms import flat, inverse, transform, unflat

# [m] of the last sight line that do not count for what touches the object: contact is never exact, and a support
# seen from above is nearly this far from the sight lines.
CONTACT = 2e-3
ANGLE_ROUNDING = 1e-9  # [rad]: rounding of an angle is far smaller


@dataclass(frozen=True)
class Unseen:
    """Why a camera does not see an object: too near, too far or outside of its field of view, by so much; or hidden.

    `amount` is in metres, or radians for `outside`; `by` is the body or `robot.link` that hides the object.
    """

    reason: Literal["too_near", "too_far", "outside", "hidden"]
    amount: float = 0.0
    by: str | None = None

    def __str__(self) -> str:
        if self.reason == "hidden":
            return f"hidden by {self.by}"
        if self.reason == "outside":
            return f"outside of the field of view by {np.degrees(self.amount):.1f} deg"
        return f"{1000 * self.amount:.0f} mm too {'near' if self.reason == 'too_near' else 'far'}"


@dataclass(frozen=True)
class View:
    """A sensor of a robot and an object, in a situation in which the object has a single pose or hangs on the robot."""

    surroundings: SceneSurroundings
    situation: Situation
    robot: Robot
    sensor: Sensor
    object: str

    def unseen(self, q: Array, without: str | None = None) -> Unseen | None:
        """Why the object is not seen from the robot's configuration q (n,); None if it is proven to be seen.

        `without`: a body that is ignored.
        """
        joints = joints_at(self.robot.tree, q)
        world_T_sensor, body = self.origin(joints), self._object(joints)
        short = self.short(world_T_sensor, body)
        if short is not None:
            return short
        apex = world_T_sensor[:3, 3]
        lines = _Lines(apex, body, self.surroundings)
        for name, other in (*self._moving(joints), *self._standing):
            if name != without and lines.blocked(other):
                return Unseen("hidden", by=name)
        return None

    def origin(self, joints: Array) -> Array:
        """The pose (4, 4) of the sensor in the world, at poses (J, 12) of the robot's joints."""
        link = self.robot.links[self.sensor.link]
        return np.asarray(unflat(joints[link.joint]) @ link.joint_T_link @ self.sensor.link_T_sensor)

    def short(self, world_T_sensor: Array, body: FixedGroup) -> Unseen | None:
        """By how much a body is beyond the range or the field of view of the sensor; None if it is within."""
        pose = inverse(world_T_sensor) @ unflat(body.world_T_group)
        points = np.concatenate(body.enclosure.parts) @ pose[:3, :3].T + pose[:3, 3]
        beyond = float(beyond_angle(self.sensor, points).max())
        if beyond > -ANGLE_ROUNDING:
            return Unseen("outside", max(beyond, 0.0))
        numeric = self.surroundings.budget.numeric
        over = float(np.linalg.norm(points, axis=1).max()) + numeric - self.sensor.far
        if over > 0.0:
            return Unseen("too_far", over)
        apex = FixedGroup(flat(world_T_sensor), Enclosure((np.zeros((1, 3)),), 0.0))
        under = self.sensor.near + numeric - geometry.distance(apex, body).lower
        return Unseen("too_near", under) if under > 0.0 else None

    # --------------------------------------------------------------------------------------------- the bodies
    def _object(self, joints: Array) -> FixedGroup:
        held = {name: self.situation.held(name) for name in self.situation.carried(self.robot.name)}
        if self.object in held:
            pose = self._hung(joints, self.object)
        else:
            (pose,) = self.surroundings.poses(self.situation, self.object)
        mesh = self.surroundings.mesh(self.object)
        return FixedGroup(flat(pose), self._sharp, None if mesh is None else (mesh.vertices, mesh.faces))

    @cached_property
    def _sharp(self) -> Enclosure:
        from kabo.geometry.collision.sight_lines import sharp

        found: Enclosure = self.surroundings.remembered(
            ("sharp", self.object),
            lambda: sharp(self.surroundings.enclosure(self.object), self.surroundings.budget.geometry),
        )
        return found

    def _hung(self, joints: Array, name: str) -> Array:
        held = self.situation.held(name)
        link = self.robot.links[held.parent.partition(".")[2]]
        return np.asarray(
            unflat(joints[link.joint]) @ link.joint_T_link @ transform(held.position, held.quaternion)
        )

    def _moving(self, joints: Array) -> Iterator[tuple[str, FixedGroup]]:
        """The robot's own links, but those that are exempt, and what it holds, but the object."""
        for link in self.robot.links.values():
            if link.mesh is not None and link.name not in self.sensor.exempt:
                yield self._group(f"{self.robot.name}.{link.name}", unflat(joints[link.joint]) @ link.joint_T_link)
        for name in self.situation.carried(self.robot.name):
            if name != self.object:
                yield self._group(name, self._hung(joints, name))

    @cached_property
    def _standing(self) -> Sequence[tuple[str, FixedGroup]]:
        """All other robots and bodies, at every pose that they may have; movable ones last.

        So a movable body is blamed only where moving it would help.
        """
        carried, found = self.situation.carried(self.robot.name), []
        for robot in self.surroundings.scene.robots.values():
            for q in self.situation.robots[robot.name] if robot is not self.robot else ():
                poses = self.surroundings.links(robot.name, q)
                found += [
                    self._group(f"{robot.name}.{link.name}", poses[link.name])
                    for link in robot.links.values()
                    if link.mesh is not None
                ]
        scene = self.surroundings.scene
        for name in sorted(scene.bodies, key=lambda each: scene.bodies[each].movable):
            if name != self.object and name not in carried:
                found += [self._group(name, pose) for pose in self.surroundings.poses(self.situation, name)]
        return found

    def _group(self, name: str, pose: Array) -> tuple[str, FixedGroup]:
        mesh = self.surroundings.mesh(name)
        arrays = None if mesh is None else (mesh.vertices, mesh.faces)
        return name, FixedGroup(flat(pose), self.surroundings.enclosure(name), arrays)


class _Lines:
    """The sight lines from a point to a body, and what is in their way."""

    def __init__(self, apex: Array, body: FixedGroup, surroundings: SceneSurroundings) -> None:
        from kabo.geometry.collision.sight_lines import sight_lines

        self.apex, self.body, self.surroundings = apex, body, surroundings
        self.whole = self._as_group(sight_lines(apex, body))
        points = np.concatenate(self.whole.enclosure.parts)
        self.low, self.high = points.min(axis=0), points.max(axis=0)

    def blocked(self, other: FixedGroup) -> bool:
        """Whether a body is not proven to be out of the way; one that touches the object may come near its end."""
        if not self._near(other) or not self.surroundings.touch(self.whole, other):
            return False
        return not self.surroundings.touch(self.body, other) or self._hidden_at_contact(other)

    def _near(self, other: FixedGroup) -> bool:
        """Whether the box of a body is nearer than epsilon to that of the sight lines."""
        pose, enclosure = unflat(other.world_T_group), other.enclosure
        points = np.concatenate(enclosure.parts) @ pose[:3, :3].T + pose[:3, 3]
        round_by = max((rounding.radius + rounding.disc for rounding in enclosure.roundings), default=0.0)
        gap = self.surroundings.budget.epsilon + round_by
        return bool(np.all(points.min(axis=0) - gap <= self.high) and np.all(points.max(axis=0) + gap >= self.low))

    def _hidden_at_contact(self, other: FixedGroup) -> bool:
        """Whether what touches the object meets the sight lines that end `CONTACT` before the object's farthest point.

        Either the parts are proven apart, or the original meshes are, the object's with its hollows filled.
        """
        from kabo.geometry.collision.sight_lines import sight_lines

        points = np.concatenate(self.whole.enclosure.parts)
        share = 1.0 - CONTACT / float(np.linalg.norm(points - self.apex, axis=1).max())
        if not self.surroundings.touch(self._as_group(sight_lines(self.apex, self.body, share=share)), other):
            return False
        if self.body.mesh is None or other.mesh is None:
            return True
        return geometry.exact_collides(self._cone(share), other)

    def _cone(self, share: float) -> FixedGroup:
        """The hull of the point and the object's mesh, shortened, as a mesh."""
        assert self.body.mesh is not None
        pose = unflat(self.body.world_T_group)
        corners = self.body.mesh[0] @ pose[:3, :3].T + pose[:3, 3]
        return self._as_group(
            Enclosure((self.apex[None],), 0.0), np.vstack([self.apex, self.apex + share * (corners - self.apex)])
        )

    def _as_group(self, enclosure: Enclosure, corners: Array | None = None) -> FixedGroup:
        """Parts in the world as a body, with the mesh of their hull, which exact predicates use."""
        if corners is None and not self.surroundings.exact:
            return FixedGroup(flat(np.eye(4)), enclosure)
        points = np.concatenate(enclosure.parts) if corners is None else corners
        hull = ConvexHull(points)
        faces = hull.simplices.copy()
        normals = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
        inward = (normals * hull.equations[:, :3]).sum(axis=1) < 0.0
        faces[inward] = faces[inward][:, ::-1]
        return FixedGroup(flat(np.eye(4)), enclosure, (points, np.asarray(faces, np.int64)))
