"""Checks what a robot's camera sees at the end of a sensing action, on the original meshes [docs/how-to/sensing.md].

All sight lines from the camera's point to the object must be free, but for their last two millimetres, where the object
touches what it stands on; and all of the object must be within the camera's field of view and range.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array, Integers
from kabo.scene import Mesh, Sensor
from kabo.verify.motion.calls import Call
from kabo.verify.motion.contacts.attachment_tree import AttachmentTree
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.surfaces import Surface, hull_gap, inverse, mesh_distance, surface
from kabo.verify.motion.sweep import SweptBody
from kabo.verify.report import Finding

CONTACT = 2e-3  # [m] of a sight line, before the object, that need not be free
TOLERANCE = 1e-9  # [m] of distances, [rad] of angles: rounding


def check_view(
    node: str, call: Call, world: SceneModel, holding: AttachmentTree, standing: Sequence[SweptBody], time: float
) -> Iterator[Finding]:
    """A finding unless a camera of the sensing robot sees the object; nothing if the robot has no camera.

    Args:
        node: the id of the node.
        call: the call of the node.
        world: the scene.
        holding: the robots and objects as the action leaves them.
        standing: all bodies that `holding` does not have, in each pose that they may have.
        time: when the motion ends [s].
    """
    robot, name = str(call.role("robot")), str(call.role("object"))
    sensors = world.scene.robots[robot].sensors
    chosen = [sensor for sensor in sensors.values() if call.sensor in (None, sensor.name)]
    if not sensors or robot not in holding.q:
        return
    view = _View(world, holding, standing, robot, name)
    reasons = [view.lacking(sensor) for sensor in chosen]
    if all(reason is not None for reason in reasons):
        reason = reasons[0] if reasons else Lacking(f"{robot} has no camera {call.sensor}")
        assert reason is not None
        yield Finding(node, f"{call}: {name} is not seen: {reason.text}", time, reason.bodies)


@dataclass(frozen=True)
class Lacking:
    """Why an object is not seen, and the bodies concerned."""

    text: str
    bodies: tuple[str, ...] = ()


class _View:
    def __init__(
        self, world: SceneModel, holding: AttachmentTree, standing: Sequence[SweptBody], robot: str, name: str
    ) -> None:
        self.world, self.robot, self.name = world, robot, name
        self.q = holding.q[robot].tolist()
        pose = holding.pose(name)
        mesh = world.scene.bodies[name].mesh
        self.points, self.faces = mesh.vertices @ pose[:3, :3].T + pose[:3, 3], mesh.faces
        self.others = [(body.name, body.surface, body.pose({})) for body in standing if body.name != name]
        for other in holding.q:
            links = world.links_at(other, holding.q[other].tolist())
            self.others += [(link.name, link.surface, link.pose({})) for link in links]
        for other in holding.hung:
            if other != name:
                own = world.surface_of(world.scene.bodies[other])
                self.others.append((other, own, holding.pose(other)))

    def lacking(self, sensor: Sensor) -> Lacking | None:
        """Why the object is not seen by a sensor; None if it is."""
        arm = self.world.arms[self.robot]
        pose = arm.pose(self.q, arm.mounts[sensor.link]) @ sensor.link_T_sensor
        seen = self.points @ inverse(pose)[:3, :3].T + inverse(pose)[:3, 3]
        return _out_of_view(sensor, seen, self.faces) or self._hidden(sensor, pose[:3, 3])

    def _hidden(self, sensor: Sensor, apex: Array) -> Lacking | None:
        away = self.points - apex
        points = apex + away * (1.0 - CONTACT / float(np.linalg.norm(away, axis=1).max()))
        lines = _sight_surface(apex, points, self.faces)
        exempt = {f"{self.robot}.{link}" for link in sensor.exempt}
        for name, own, pose in self.others:
            if name not in exempt and self._blocks(lines, apex, points, own, pose):
                return Lacking(f"{name} is in the way", (name, self.name))
        return None

    def _blocks(self, lines: Surface, apex: Array, points: Array, own: Surface, pose: Array) -> bool:
        """Whether a body is not proven to be apart from the sight lines; it may lie among them whole."""
        world = np.eye(4)
        if hull_gap(lines, world, own, pose) > 0.0:
            return False
        if mesh_distance(lines, world, own, pose) <= 0.0:
            return True
        inside = own.witnesses @ pose[:3, :3].T + pose[:3, 3]
        return any(_among(point, apex, points[self.faces]) for point in inside)


def _out_of_view(sensor: Sensor, points: Array, faces: Integers) -> Lacking | None:
    """Why points (N, 3) in the sensor's frame, corners of the triangles `faces`, are not all in view."""
    depth, farthest = points[:, 2], float(np.linalg.norm(points, axis=1).max())
    across = [np.hypot(points[:, 0], points[:, 1])] if len(sensor.angles) == 1 else [points[:, 0], points[:, 1]]
    for offset, angle in zip(across, sensor.angles, strict=True):
        beyond = float((np.arctan2(np.abs(offset), depth) - angle).max())
        if beyond > TOLERANCE:
            return Lacking(f"it is {np.degrees(beyond):.2g} deg outside of the field of view of {sensor.name}")
    if farthest > sensor.far + TOLERANCE:
        return Lacking(f"it is {1000 * (farthest - sensor.far):.2g} mm too far for {sensor.name}")
    nearest = float(min(_distance(corners) for corners in points[faces]))
    if nearest < sensor.near - TOLERANCE:
        return Lacking(f"it is {1000 * (sensor.near - nearest):.2g} mm too near for {sensor.name}")
    return None


def _distance(corners: Array) -> float:
    """The distance of the origin from a triangle (3, 3) [m]."""
    a, b, c = corners
    normal = np.cross(b - a, c - a)
    found = [_edge_distance(*pair) for pair in ((a, b), (b, c), (c, a))]
    length = float(np.linalg.norm(normal))
    if length > 0.0:
        foot = normal * (a @ normal) / length**2
        sides = [np.cross(q - p, foot - p) @ normal >= 0.0 for p, q in ((a, b), (b, c), (c, a))]
        if all(sides):
            found.append(float(np.linalg.norm(foot)))
    return min(found)


def _edge_distance(p: Array, q: Array) -> float:
    along = q - p
    square = float(along @ along)
    share = 0.0 if square == 0.0 else float(np.clip(-(p @ along) / square, 0.0, 1.0))
    return float(np.linalg.norm(p + share * along))


def _sight_surface(apex: Array, points: Array, faces: Integers) -> Surface:
    """The triangles between a point and all edges of a mesh, and those of the mesh: they bound all sight lines."""
    pairs = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    edges = np.unique(pairs, axis=0)
    fans = np.column_stack([np.full(len(edges), len(points)), edges])
    return surface(Mesh(np.vstack([points, apex]), np.vstack([faces, fans])))


def _among(point: Array, apex: Array, triangles: Array) -> bool:
    """Whether a point lies in the hull of the apex and one of the triangles (F, 3, 3)."""
    edges = np.swapaxes(triangles - apex, 1, 2)  # of each tetrahedron, as columns
    sound = np.abs(np.linalg.det(edges)) > 0.0
    shares = np.linalg.solve(edges[sound], np.broadcast_to((point - apex)[:, None], (int(sound.sum()), 3, 1)))[
        ..., 0
    ]
    return bool(((shares >= 0.0).all(axis=1) & (shares.sum(axis=1) <= 1.0)).any())
