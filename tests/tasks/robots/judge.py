"""A judge that shares no code with the geometry server: pinocchio's poses, fcl on the original meshes, fine samples."""

from collections.abc import Iterator

import fcl
import numpy as np

from kabo.scene import Scene, link_pose, link_poses
from kabo.scene.transforms import transform
from kabo.tasks.core import Solution
from kabo.tasks.robots import Stretch, TaskScene, stretches

STEP = 0.04  # rad: how far apart configurations are looked at


class Judge:
    """Follows a solution through the scene and says what is wrong with it."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._models: dict[str, fcl.BVHModel] = {}

    def findings(self, solution: Solution) -> list[str]:
        """What is wrong: jumps, contacts that nobody permitted, an end that is not the one recorded."""
        assert solution.start is not None and solution.end is not None
        before: TaskScene = solution.start.scene
        after: TaskScene = solution.end.scene
        robots = {name: np.array(before.situation.configuration(name)) for name in self.scene.robots}
        objects = {name: before.situation.attachment(name) for name in self.scene.movable}
        found: list[str] = []
        poses = {name: self._object(robots, objects, name) for name in objects}
        for path, each in stretches(solution):
            if np.abs(robots[each.robot] - np.array(each.start)).max() > 1e-6:
                found.append(f"{path} does not start where {each.robot} is")
            found += [f"{path}: {text}" for text in self._collisions(each, robots, objects)]
            robots[each.robot] = np.array(each.end)
            poses |= {n: self._object(robots, objects, n) for n in objects if "." in objects[n].parent}
            for name, link in each.attach:
                objects[name] = after.situation.attachment(name)
                ends = after.situation.attachment(name).parent
                if ends == "world":  # taken, and put down later: where in the hand, only a plan would say
                    objects[name] = self._held(solution, name, link)
                if np.abs(self._object(robots, objects, name) - poses[name]).max() > 1e-6:
                    found.append(f"{path}: {name} jumps when it is attached")
            for name in each.detach:
                objects[name] = after.situation.attachment(name)
                if np.abs(self._object(robots, objects, name) - poses[name]).max() > 1e-6:
                    found.append(f"{path}: {name} jumps when it is let go")
        for name, q in robots.items():
            if np.abs(q - np.array(after.situation.configuration(name))).max() > 1e-6:
                found.append(f"{name} does not end where the solution says")
        found += [f"{n} ends elsewhere" for n in objects if objects[n] != after.situation.attachment(n)]
        return found

    def clearance(self, each: Stretch, before: TaskScene, name: str, others: list[str]) -> float:
        """The least sampled distance [m] of one thing that moves with a robot from some others."""
        robots = {n: np.array(before.situation.configuration(n)) for n in self.scene.robots}
        objects = {n: before.situation.attachment(n) for n in self.scene.movable}
        least = np.inf
        for q in samples(each, STEP / 2):
            robots[each.robot] = q
            placed = dict(self._placed(robots, objects))
            for other, body in placed.items():
                if other in others:
                    least = min(
                        least, fcl.distance(placed[name], body, fcl.DistanceRequest(), fcl.DistanceResult())
                    )
        return float(least)

    def _held(self, solution: Solution, name: str, link: str) -> object:
        for leaf in solution.walk():
            if leaf.end is not None and any(pair == (name, link) for s in leaf.motion or () for pair in s.attach):
                return leaf.end.scene.situation.attachment(name)
        raise AssertionError(f"nobody attaches {name}")

    def _collisions(self, each: Stretch, robots: dict, objects: dict) -> Iterator[str]:
        held = {n for n, a in objects.items() if a.parent.startswith(each.robot + ".")}
        gripper = self.scene.robots[each.robot].gripper
        touch = set() if gripper is None else {frozenset((link, n)) for link in gripper.touch_links for n in held}
        told: set[frozenset[str]] = set()
        for q in samples(each, STEP):
            placed = list(self._placed({**robots, each.robot: q}, objects))
            for i, (a, first) in enumerate(placed):
                if not (a.startswith(each.robot + ".") or a in held):
                    continue
                for k, (b, second) in enumerate(placed):
                    pair = frozenset((a, b))
                    if (
                        k == i
                        or pair in each.permitted
                        or pair in touch
                        or pair in told
                        or self._joined(a, b, held)
                    ):
                        continue
                    if each.group == "gripper" and held & pair and not any("." in n for n in pair):
                        continue  # the gripper moves no object
                    if fcl.collide(first, second, fcl.CollisionRequest(), fcl.CollisionResult()):
                        told.add(pair)
                        yield f"{a} meets {b}"

    def _joined(self, a: str, b: str, held: set[str]) -> bool:
        """Whether two things cannot meet: neighbours, or an object and the link that carries it."""
        if self.scene.never_collide(a, b):
            return True
        for name, other in ((a, b), (b, a)):
            if name in held and "." in other:
                robot, _, link = other.partition(".")
                chosen = self.scene.robots[robot]
                if chosen.tool is not None and chosen.neighbours(link, chosen.tool.frame):
                    return True
        return False

    def _placed(self, robots: dict, objects: dict) -> Iterator[tuple[str, fcl.CollisionObject]]:
        for name, robot in self.scene.robots.items():
            poses = link_poses(robot, robots[name])
            for link in robot.links.values():
                if link.mesh is not None:
                    yield f"{name}.{link.name}", self._body(f"{name}.{link.name}", link.mesh, poses[link.name])
        for name, body in self.scene.bodies.items():
            pose = self.scene.fixed_poses.get(name)
            yield name, self._body(name, body.mesh, self._object(robots, objects, name) if pose is None else pose)

    def _object(self, robots: dict, objects: dict, name: str) -> np.ndarray:
        held = objects[name]
        own = transform(held.position, held.quaternion)
        if held.parent == "world":
            return own
        robot, _, link = held.parent.partition(".")
        return np.asarray(link_pose(self.scene.robots[robot], robots[robot], link) @ own)

    def _body(self, name: str, mesh: object, pose: np.ndarray) -> fcl.CollisionObject:
        if name not in self._models:
            model = fcl.BVHModel()
            model.beginModel(len(mesh.vertices), len(mesh.faces))  # type: ignore[attr-defined]
            model.addSubModel(mesh.vertices, mesh.faces)  # type: ignore[attr-defined]
            model.endModel()
            self._models[name] = model
        return fcl.CollisionObject(self._models[name], fcl.Transform(pose[:3, :3], pose[:3, 3]))


def samples(each: Stretch, step: float) -> Iterator[np.ndarray]:
    """Configurations along a stretch, none farther than `step` from the next."""
    path = each.path
    yield path[0]
    for a, b in zip(path, path[1:], strict=False):
        pieces = max(1, int(np.ceil(np.abs(b - a).max() / step)))
        yield from (a + (b - a) * (k / pieces) for k in range(1, pieces + 1))
