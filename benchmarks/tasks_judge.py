"""Whether the solution of a task is right, by what shares nothing with the planner: pinocchio and python-fcl.

The motion of a solution is replayed from its first scene in steps of a few milliradians, on the original meshes:
every robot link and everything in a hand against all else. Distances are measured, not bounded.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import fcl
import numpy as np
import numpy.typing as npt

from kabo.scene import Scene, link_poses, world_T
from kabo.tasks import Solution
from kabo.tasks.robots import Stretch, stretches

Array = npt.NDArray[np.float64]
Pair = frozenset[str]
STEP = 0.004  # rad or m: a joint moves no farther between two looks


@dataclass
class Replay:
    """What a replay found: collisions by pair, the largest gap between stretches, where objects are in the end."""

    collisions: dict[tuple[str, ...], str] = field(default_factory=dict)  # pair: the stage where it happened first
    gap: float = 0.0
    looks: int = 0
    clearance: dict[tuple[str, str], float] = field(default_factory=dict)  # (stage, thing): least distance [m]
    poses: dict[str, Array] = field(default_factory=dict)


class Judge:
    """Replays solutions in one scene."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.shapes: dict[str, tuple[Any, float, Array]] = {}  # the mesh, radius and centre of a ball around it
        for robot in scene.robots.values():
            for link in robot.links.values():
                if link.mesh is not None:
                    self._add(f"{robot.name}.{link.name}", link.mesh)
        for name, body in scene.bodies.items():
            self._add(name, body.mesh)

    def _add(self, name: str, mesh: Any) -> None:
        model = fcl.BVHModel()
        model.beginModel(len(mesh.faces), len(mesh.vertices))
        model.addSubModel(mesh.vertices, mesh.faces)
        model.endModel()
        centre = (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 2
        radius = float(np.linalg.norm(mesh.vertices - centre, axis=1).max())
        self.shapes[name] = model, radius, centre

    def replay(
        self,
        solution: Solution,
        permitted: Mapping[str, Collection[Pair]],
        measured: tuple[str, Collection[str]] | None = None,
        *,
        step: float = STEP,
    ) -> Replay:
        """Replays a solution.

        Args:
            solution: of a task in the scene.
            permitted: the contacts that are in order beside those that the scene always allows, by the first words
                of the paths of stages; "" for all.
            measured: a thing, and the stages in which the distance of robots from it is measured.
            step: how far a joint moves between two looks [rad or m].
        """
        found = Replay()
        state = solution.start.scene.situation.first  # type: ignore[union-attr]
        now = {name: np.array(q) for name, q in state.robots.items()}
        links = {name: link_poses(self.scene.robots[name], q) for name, q in now.items()}
        placed = {name: world_T(self.scene, state, name) for name in self.scene.bodies}
        held: dict[str, tuple[str, str, Array]] = {}
        for path, each in stretches(solution):
            found.gap = max(found.gap, float(np.abs(each.path[0] - now[each.robot]).max()))
            allowed = {pair for stages, pairs in permitted.items() if path.startswith(stages) for pair in pairs}
            for q in looks(each, step):
                links[each.robot] = link_poses(self.scene.robots[each.robot], q)
                for name, (robot, link, pose) in held.items():
                    placed[name] = links[robot][link] @ pose
                found.looks += 1
                poses = self._poses(links, placed)
                self._collisions(found, path, each, poses, allowed, held)
                if measured is not None and path in measured[1]:
                    self._measure(found, path, each, poses, measured[0])
            now[each.robot] = each.path[-1]
            for name, link in each.attach:
                robot, _, own = link.partition(".")
                held[name] = robot, own, np.linalg.inv(links[robot][own]) @ placed[name]
            for name in each.detach:
                del held[name]
        found.poses = placed
        return found

    def _poses(
        self, links: Mapping[str, Mapping[str, Array]], placed: Mapping[str, Array]
    ) -> dict[str, tuple[Array, Array]]:
        poses = {f"{robot}.{link}": pose for robot, own in links.items() for link, pose in own.items()} | dict(
            placed
        )
        return {
            name: (pose, pose[:3, :3] @ self.shapes[name][2] + pose[:3, 3])
            for name, pose in poses.items()
            if name in self.shapes
        }

    def _collisions(
        self,
        found: Replay,
        path: str,
        each: Stretch,
        poses: Mapping[str, tuple[Array, Array]],
        allowed: Collection[Pair],
        held: Mapping[str, tuple[str, str, Array]],
    ) -> None:
        carried = [name for name in held if held[name][0] == each.robot and each.group == "arm"]
        moving = [name for name in poses if name.startswith(each.robot + ".") or name in carried]
        names = list(poses)
        centres = np.array([poses[name][1] for name in names])
        radii = np.array([self.shapes[name][1] for name in names])
        for first in moving:
            i = names.index(first)
            near = np.linalg.norm(centres - centres[i], axis=1) <= radii + radii[i]
            for k in np.flatnonzero(near):
                second = names[k]
                if second == first or (second in moving and k < i):
                    continue
                pair = frozenset((first, second))
                if (
                    pair in allowed
                    or self.scene.never_collide(first, second)
                    or tuple(sorted(pair)) in found.collisions
                ):
                    continue
                if fcl.collide(
                    self._body(first, poses),
                    self._body(second, poses),
                    fcl.CollisionRequest(),
                    fcl.CollisionResult(),
                ):
                    found.collisions[tuple(sorted(pair))] = path

    def _measure(
        self, found: Replay, path: str, each: Stretch, poses: Mapping[str, tuple[Array, Array]], thing: str
    ) -> None:
        key = path, thing
        least = found.clearance.get(key, np.inf)
        for name, (_, centre) in poses.items():
            far = np.linalg.norm(centre - poses[thing][1]) - self.shapes[name][1] - self.shapes[thing][1]
            if name.startswith(each.robot + ".") and far < least and not self.scene.never_collide(name, thing):
                answer = fcl.DistanceResult()
                fcl.distance(self._body(name, poses), self._body(thing, poses), fcl.DistanceRequest(), answer)
                least = min(least, answer.min_distance)
        found.clearance[key] = least

    def _body(self, name: str, poses: Mapping[str, tuple[Array, Array]]) -> Any:
        pose = poses[name][0]
        return fcl.CollisionObject(self.shapes[name][0], fcl.Transform(pose[:3, :3], pose[:3, 3]))


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
