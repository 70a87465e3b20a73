"""Whether the solution of a task is right, by what shares nothing with the planner: pinocchio and coal.

The motion of a solution is replayed from its first scene in steps of a few milliradians, on the original meshes:
every robot link and everything in a hand against all else. Distances are measured, not bounded.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull

from kabo.arrays import Array
from kabo.scene import Scene, link_poses, world_T
from kabo.tasks import Solution
from kabo.tasks.robots import Stretch, stretches

Pair = frozenset[str]
Held = Mapping[str, tuple[str, str, Array]]  # by object: robot, link, and the object's pose there
STEP = 0.004  # rad or m: a joint moves no farther between two looks


@dataclass
class Replay:
    """What a replay found: collisions by pair, the largest gap between stretches, where objects are in the end."""

    collisions: dict[tuple[str, ...], str] = field(default_factory=dict)  # pair: the stage where it happened first
    gap: float = 0.0
    looks: int = 0
    poses: dict[str, Array] = field(default_factory=dict)


class Judge:
    """Replays solutions in one scene."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.originals = {name: body.mesh for name, body in scene.bodies.items()}
        for robot in scene.robots.values():
            links = ((f"{robot.name}.{link.name}", link.mesh) for link in robot.links.values())
            self.originals |= {name: mesh for name, mesh in links if mesh is not None}
        self.meshes = {name: _surface(mesh) for name, mesh in self.originals.items()}

    @cached_property
    def hulls(self) -> dict[str, Any]:
        """The convex hulls: their distances are lower bounds, and quickly found."""
        return {name: _hull(mesh) for name, mesh in self.originals.items()}

    def replay(
        self, solution: Solution, permitted: Mapping[str, Collection[Pair]], *, step: float = STEP
    ) -> Replay:
        """Replays a solution.

        Args:
            solution: of a task in the scene.
            permitted: the contacts that are in order beside those that the scene always allows, by the first words
                of the paths of stages; "" for all.
            step: how far a joint moves between two looks [rad or m].
        """
        found = Replay()
        state = solution.start.scene.situation.first  # type: ignore[union-attr]
        now = {name: np.array(q) for name, q in state.robots.items()}
        placed = {name: world_T(self.scene, state, name) for name in self.scene.bodies}
        held: dict[str, tuple[str, str, Array]] = {}
        for path, each in stretches(solution):
            found.gap = max(found.gap, float(np.abs(each.path[0] - now[each.robot]).max()))
            allowed = {pair for stages, pairs in permitted.items() if path.startswith(stages) for pair in pairs}
            view = _View(self, self.meshes, each, now, placed, held, allowed)
            for q in looks(each, step):
                found.looks += 1
                for pair in view.collisions(q):
                    found.collisions.setdefault(pair, path)
            now[each.robot] = each.path[-1]
            links = link_poses(self.scene.robots[each.robot], now[each.robot])
            placed |= {name: links[own] @ pose for name, (robot, own, pose) in held.items() if robot == each.robot}
            for name, link in each.attach:
                robot, _, own = link.partition(".")
                held[name] = robot, own, np.linalg.inv(links[own]) @ placed[name]
            for name in each.detach:
                del held[name]
        found.poses = placed
        return found

    def clearance(self, each: Stretch, thing: str, spacing: float) -> tuple[float, float]:
        """Bounds of the least distance [m] of a robot from a standing thing along a stretch.

        The lower one is the least distance of the convex hulls, as if it were measured wherever some point of the robot
        may have moved by `spacing` [m]: no point moves farther than the turn of every joint times what hangs behind it
        is long, so looks that cannot be the least are left out. The upper one is that of the meshes at that look.
        """
        robot, least, nearest = self.scene.robots[each.robot], np.inf, each.path[0]
        placed = {thing: world_T(self.scene, self.scene.start, thing)}
        now = {each.robot: np.array(each.start)}
        exact, hulls = (
            _View(self, shapes, each, now, placed, {}, frozenset()) for shapes in (self.meshes, self.hulls)
        )
        lengths = _lengths(robot)
        for a, b in zip(each.path, each.path[1:], strict=False):
            pieces = max(1, int(np.ceil((lengths * np.abs(b - a)).sum() / spacing)))
            k = 0
            while k <= pieces:
                q = a + (b - a) * (k / pieces)
                here = hulls.distance(q)
                if here < least:
                    least, nearest = here, q
                k += max(1, int((here - least) / spacing))
        return float(least), exact.distance(nearest)


class _View:
    """One stretch: what moves with its robot, against all else, as pinocchio has it."""

    def __init__(
        self,
        judge: Judge,
        shapes: Mapping[str, Any],
        each: Stretch,
        now: Mapping[str, Array],
        placed: Mapping[str, Array],
        held: Held,
        allowed: Collection[Pair],
    ) -> None:
        self.robot = judge.scene.robots[each.robot]
        self.model, self.data, self.geometry = self.robot.model, self.robot.model.createData(), pin.GeometryModel()
        frames = {frame.name: frame for frame in self.model.frames if frame.type == pin.FrameType.BODY}
        carried = {name: own for name, own in held.items() if own[0] == each.robot and each.group == "arm"}
        moving, names = set(), []
        for robot, q in now.items():
            for link, pose in link_poses(judge.scene.robots[robot], q).items():
                name = f"{robot}.{link}"
                if name not in shapes:
                    continue
                if robot == each.robot:
                    moving.add(name)
                    self._add(frames[link].parentJoint, frames[link].placement, shapes[name])
                else:
                    self._add(0, pin.SE3(pose), shapes[name])
                names.append(name)
        for name, pose in placed.items():
            if name in carried:
                frame = frames[carried[name][1]]
                self._add(frame.parentJoint, frame.placement * pin.SE3(carried[name][2]), shapes[name])
                moving.add(name)
            else:
                self._add(0, pin.SE3(pose), shapes[name])
            names.append(name)
        self.pairs: list[tuple[str, str]] = []
        for i, first in enumerate(names):
            for k, second in enumerate(names[i + 1 :], i + 1):
                if {first, second} & moving and not _apart(judge.scene, first, second, allowed):
                    self.geometry.addCollisionPair(pin.CollisionPair(i, k))
                    self.pairs.append((first, second))
        self.standing = [k for k, pair in enumerate(self.pairs) if not all("." in name for name in pair)]
        self.work = pin.GeometryData(self.geometry)

    def _add(self, joint: int, pose: Any, mesh: Any) -> None:
        self.geometry.addGeometryObject(pin.GeometryObject(str(self.geometry.ngeoms), joint, pose, mesh))

    def collisions(self, q: Array) -> list[tuple[str, ...]]:
        """The pairs that touch at a configuration."""
        full = self.robot.expand(q)
        if not pin.computeCollisions(self.model, self.data, self.geometry, self.work, full, False):
            return []
        results = zip(self.pairs, self.work.collisionResults, strict=True)
        return [tuple(sorted(pair)) for pair, result in results if result.isCollision()]

    def distance(self, q: Array) -> float:
        """The least distance of the robot's links from what stands, not from each other [m]."""
        pin.updateGeometryPlacements(self.model, self.data, self.geometry, self.work, self.robot.expand(q))
        return min(pin.computeDistance(self.geometry, self.work, k).min_distance for k in self.standing)


def _apart(scene: Scene, first: str, second: str, allowed: Collection[Pair]) -> bool:
    return frozenset((first, second)) in allowed or scene.never_collide(first, second)


def _surface(mesh: Any) -> Any:
    """A mesh as coal has it."""
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(mesh.faces), len(mesh.vertices))
    model.addVertices(mesh.vertices)
    model.addTriangles(mesh.faces.astype(np.uint64))
    model.endModel()
    return model


def _hull(mesh: Any) -> Any:
    """The convex hull of a mesh as coal has it."""
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    made = ConvexHull(mesh.vertices)
    numbers = {int(vertex): i for i, vertex in enumerate(made.vertices)}
    for vertex in made.vertices:
        points.append(mesh.vertices[vertex])
    for corners in made.simplices:
        triangles.append(coal.Triangle(*(numbers[int(corner)] for corner in corners)))
    return coal.Convex(points, triangles)


def _lengths(robot: Any) -> Array:
    """For each value of a configuration, how far from its axis what it moves may be [m]; 1 for what slides."""
    tree, lengths = robot.tree, np.zeros(robot.tree.size)
    steps = np.linalg.norm(tree.placement[:, 9:], axis=1)
    reach = np.zeros(len(tree.parent))
    for link in robot.links.values():
        if link.mesh is not None:
            points = link.mesh.vertices @ link.joint_T_link[:3, :3].T + link.joint_T_link[:3, 3]
            reach[link.joint] = max(reach[link.joint], float(np.linalg.norm(points, axis=1).max()))
    for j in range(len(tree.parent) - 1, 0, -1):
        slides = tree.kind[j] != 0
        own = 1.0 if slides else reach[j]
        if tree.ratio[j] != 0.0:
            lengths[tree.source[j]] = max(lengths[tree.source[j]], own * abs(tree.ratio[j]))
        travel = float(np.abs([tree.lower[tree.source[j]], tree.upper[tree.source[j]]]).max()) if slides else 0.0
        reach[tree.parent[j]] = max(reach[tree.parent[j]], reach[j] + steps[j] + travel)
    return lengths


def looks(each: Stretch, step: float) -> Iterator[Array]:
    """The configurations of a stretch, no joint farther from one to the next than `step`."""
    path = each.path
    yield path[0]
    for a, b in zip(path, path[1:], strict=False):
        pieces = max(1, int(np.ceil(np.abs(b - a).max() / step)))
        for k in range(1, pieces + 1):
            yield a + (b - a) * (k / pieces)


def tilt(pose: Array) -> float:
    """The angle [rad] of the z axis of a pose from the vertical."""
    return float(np.arccos(np.clip(pose[2, 2], -1.0, 1.0)))
