"""Pinocchio and coal on the arrangements of `kernel_scenes`: the same tree, the same pairs, parts or meshes."""

from collections.abc import Callable, Sequence
from typing import Any

import coal
import numpy as np
import numpy.typing as npt
import pinocchio as pin
from kernel_scenes import Arrangement, Thing
from scipy.spatial import ConvexHull

from kabo.arrays import Array
from kabo.scene import REVOLUTE

Ask = Callable[[tuple[Array, Array]], bool]  # of (q, values of all joints)
STEPS = 128  # of a segment whose paths are measured


class Kinematics:
    """An arrangement's tree as a pinocchio model: one value for each joint."""

    def __init__(self, scene: Arrangement) -> None:
        self.scene, tree, self.model = scene, scene.tree, pin.Model()
        for j in range(1, len(tree.parent)):
            joint = pin.JointModelRZ() if tree.kind[j] == REVOLUTE else pin.JointModelPZ()
            placement = pin.SE3(tree.placement[j, :9].reshape(3, 3), tree.placement[j, 9:])
            self.model.addJoint(int(tree.parent[j]), joint, placement, f"joint_{j}")
        self.data = self.model.createData()

    def points(self, q: Array, points: Sequence[tuple[int, Array]]) -> list[Array]:
        """Points of joints, in the world."""
        pin.forwardKinematics(self.model, self.data, self.scene.expand(q))
        return [self.data.oMi[joint].act(point) for joint, point in points]

    def longest_path(self, start: Array, end: Array) -> float:
        """How far the corner of a moving thing's box travels at most [m]."""
        corners = [(t.joint, _corners(t)) for t in self.scene.things[: self.scene.moving]]
        before, lengths = None, np.zeros((len(corners), 8))
        for i in range(STEPS + 1):
            pin.forwardKinematics(self.model, self.data, self.scene.expand(start + (end - start) * (i / STEPS)))
            poses = [self.data.oMi[joint] for joint, _ in corners]
            now = np.array([c @ m.rotation.T + m.translation for m, (_, c) in zip(poses, corners, strict=True)])
            if before is not None:
                lengths += np.linalg.norm(now - before, axis=2)
            before = now
        return float(lengths.max())

    def path_bound(self, start: Array, end: Array) -> float:
        """A bound of `longest_path` [m]: each joint carries everything beyond it at the length of the stretched arm."""
        first, last, tree, bound = self.scene.expand(start), self.scene.expand(end), self.scene.tree, 0.0
        turns, farthest = np.abs(last - first), np.maximum(np.abs(first), np.abs(last))
        for thing in self.scene.things[: self.scene.moving]:
            reach, path, joint = float(np.linalg.norm(_corners(thing), axis=1).max()), 0.0, thing.joint
            while joint > 0:
                slides = tree.kind[joint] != REVOLUTE
                path += turns[joint - 1] * (1.0 if slides else reach)
                reach += float(np.linalg.norm(tree.placement[joint, 9:])) + slides * farthest[joint - 1]
                joint = int(tree.parent[joint])
            bound = max(bound, path)
        return bound


def _corners(thing: Thing) -> Array:
    low, high = thing.mesh[0].min(axis=0), thing.mesh[0].max(axis=0)
    corners = np.array(
        [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    )
    return corners @ thing.pose[:3, :3].T + thing.pose[:3, 3]


def convex(vertices: Array) -> Any:
    """A convex part as coal has it."""
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for vertex in vertices:
        points.append(vertex)
    for corners in ConvexHull(vertices).simplices:
        triangles.append(coal.Triangle(*map(int, corners)))
    return coal.Convex(points, triangles)


def surface(vertices: Array, faces: npt.NDArray[np.int64]) -> Any:
    """A mesh as coal has it."""
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(faces), len(vertices))
    model.addVertices(vertices)
    model.addTriangles(faces.astype(np.uint64))
    model.endModel()
    return model


def geometry_model(scene: Arrangement, convex_parts: bool) -> Any:
    """All things, whole or in convex parts, with the scene's pairs."""
    model, numbers = pin.GeometryModel(), []
    for thing in scene.things:
        shapes = [convex(part) for part in thing.enclosure.parts] if convex_parts else [surface(*thing.mesh)]
        made = [
            pin.GeometryObject(f"{thing.name} {k}", thing.joint, pin.SE3(thing.pose), s)
            for k, s in enumerate(shapes)
        ]
        numbers.append([model.addGeometryObject(one) for one in made])
    for first, second in scene.pairs:
        for a in numbers[first]:
            for b in numbers[second]:
                model.addCollisionPair(pin.CollisionPair(a, b))
    return model


def geometry_data(model: Any) -> Any:
    """Working memory."""
    return pin.GeometryData(model)


def plain(model: Any, geometry: Any, data: Any) -> Ask:
    """Pinocchio's check of all pairs."""
    work = model.createData()
    return lambda value: pin.computeCollisions(model, work, geometry, data, value[1], True)


def tree_broad_phase(model: Any, geometry: Any, kind: str = "TreeBroadPhaseManager") -> Ask:
    """Pinocchio's check with one of its broad phases."""
    work, data = model.createData(), pin.GeometryData(geometry)
    manager = getattr(pin, f"{kind}_DynamicAABBTreeCollisionManager")(model, geometry, data)
    return _holding(lambda value: pin.computeCollisions(model, work, manager, value[1], True), geometry, data)


def _holding(ask: Any, *owned: Any) -> Ask:
    """The function, which keeps alive what managers of compiled libraries only point to."""
    ask.owned = owned
    return ask


def coal_managers(scene: Arrangement, model: Any, geometry: Any) -> Ask:
    """Coal's managers, driven from Python: each arm against the other and against all that stands.

    Coal's callback cannot be replaced from Python, hence all pairs of two managers count and none within one; the
    arms' bases, which touch their first links, are left out. Its answers are therefore not compared.
    """
    joints = len(model.parents) // 2
    work, data, moved = model.createData(), pin.GeometryData(geometry), []
    pin.updateGeometryPlacements(model, work, geometry, data, np.zeros(model.nq))
    managers = [coal.DynamicAABBTreeCollisionManager() for _ in range(3)]
    for index, thing in enumerate(geometry.geometryObjects):
        joint, pose = thing.parentJoint, data.oMg[index]
        if joint == 0 and "." in thing.name:
            continue
        body = coal.CollisionObject(thing.geometry, coal.Transform3s(pose.rotation, pose.translation))
        owner = 2 if joint == 0 else int(joint > joints)
        managers[owner].registerObject(body)
        moved.append((index, body))
    for manager in managers:
        manager.setup()
    moving = [(i, body) for i, body in moved if geometry.geometryObjects[i].parentJoint]
    meetings = [(managers[a], managers[b]) for a, b in ((0, 1), (0, 2), (1, 2))]
    callback = coal.CollisionCallBackDefault()

    def ask(value: tuple[Array, Array]) -> bool:
        pin.updateGeometryPlacements(model, work, geometry, data, value[1])
        for index, body in moving:
            pose = data.oMg[index]
            body.setTransform(coal.Transform3s(pose.rotation, pose.translation))
            body.computeAABB()
        for manager in managers[:2]:
            manager.update()
        for first, second in meetings:
            callback.init()
            first.collide(second, callback)
            if callback.data.result.isCollision():
                return True
        return False

    return _holding(ask, moved)
