"""The surroundings of all robots of a scene: bodies as convex parts and poses of links, computed once."""

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from kabo import geometry  # its names load when they are used: python-fcl only for `--geometry exact`
from kabo.arrays import Array, Integers
from kabo.children import never
from kabo.content_cache import ContentCache
from kabo.errors import InputError
from kabo.geometry import Budget, CollisionChecker, Enclosure, FixedGroup, MovingGroup
from kabo.geometry_server.answers import GeometryStatistics, Pair
from kabo.geometry_server.situation import Situation
from kabo.meshes import hull_of
from kabo.scene import Configuration, KinematicTree, Mesh, Scene, link_poses
from kabo.scene.transforms import transform

MAX_REMEMBERED = 160  # workspaces and containers kept for further questions about the same things


_ENCLOSURES: ContentCache[Enclosure] = ContentCache(16 << 20, lambda made: made.nbytes)


def _enclosed(mesh: Mesh, tolerance: float, look: Callable[[], None]) -> Enclosure:
    """The parts of a mesh, kept across scenes, by the content of the mesh and of the parts file beside it."""
    key = mesh.digest, geometry.digest_beside(mesh.path), tolerance
    return _ENCLOSURES.get_or_make(key, lambda: geometry.enclosing_parts(mesh, tolerance, look=look))


class SceneSurroundings:
    """The bodies of a scene as convex parts, which are computed on first use, and the poses of links."""

    def __init__(self, scene: Scene, budget: Budget, exact: bool, statistics: GeometryStatistics) -> None:
        self.scene, self.budget, self.exact, self.statistics = scene, budget, exact, statistics
        self.look: Callable[[], None] = never  # called while parts are made; an exception ends that
        # The scene keeps parts, since each seed has a server of its own.
        self._enclosures: dict[str, Enclosure] = scene.memory.setdefault(("enclosures", budget.geometry), {})
        self._links: dict[tuple[str, Configuration], Mapping[str, Array]] = {}
        self._apart: dict[Pair, bool] = {}
        self._memory: OrderedDict[tuple[object, ...], Any] = OrderedDict()

    def checker(
        self,
        tree: KinematicTree,
        moving: Sequence[MovingGroup],
        fixed: Sequence[FixedGroup],
        pairs: Integers,
    ) -> CollisionChecker:
        """A collision checker for these bodies: on convex parts, or on the original meshes if `exact`."""
        kind = geometry.ExactView if self.exact else geometry.CollisionView
        return kind(tree, moving, fixed, pairs, self.budget)

    def touch(self, first: FixedGroup, second: FixedGroup) -> bool:
        """Whether two standing bodies may collide."""
        if self.exact:
            return geometry.exact_collides(first, second)
        return geometry.collides(first, second, self.budget)

    def mesh(self, name: str) -> Mesh | None:
        """The mesh of a body or `robot.link`, in its own frame."""
        robot, dot, link = name.partition(".")
        return self.scene.robots[robot].links[link].mesh if dot else self.scene.bodies[name].mesh

    def enclosure(self, name: str) -> Enclosure:
        """The convex parts that enclose a body or `robot.link`, in its own frame."""
        mesh = self.mesh(name)
        if mesh is None:
            raise ValueError(f"{name} has no geometry")
        robot, dot, link = name.partition(".")
        try:
            if not dot or link not in self.scene.robots[robot].hulls:
                return self.enclosed(mesh)
            key = f"hull of {mesh.digest}"
            if key not in self._enclosures:
                self._enclosures[key] = self.enclosed(hull_of(mesh))
            return self._enclosures[key]
        except InputError as error:
            raise self._named(name, error) from None

    def _named(self, name: str, error: InputError) -> InputError:
        """The error about a mesh, at the place that people know: the body's shape, or the link in its URDF."""
        robot, dot, link = name.partition(".")
        place = self.scene.robots[robot].links[link].place if dot else self.scene.bodies[name].shape.place
        thing = f'link "{link}" of robot "{robot}"' if dot else f'body "{name}"'
        found = []
        for finding in error.diagnostics:
            told = replace(finding, message=f"{thing}: {finding.message}")
            if place is not None and finding.file == "mesh":  # a mesh of several pieces has no file of its own
                told = replace(told, file=place.file, line=place.line, column=place.column, length=place.length)
            found.append(told)
        return type(error)(found)

    def enclosed(self, mesh: Mesh) -> Enclosure:
        """The convex parts that enclose a mesh, computed once."""
        if mesh.digest not in self._enclosures:
            self._enclosures[mesh.digest] = _enclosed(mesh, self.budget.geometry, self.look)
        return self._enclosures[mesh.digest]

    def links(self, robot: str, q: Configuration) -> Mapping[str, Array]:
        """The pose (4, 4) of every link of a robot at q."""
        if (robot, q) not in self._links:
            self._links[robot, q] = link_poses(self.scene.robots[robot], q)
        return self._links[robot, q]

    def never_collide(self, first: str, second: str) -> bool:
        """The result of `Scene.never_collide`, cached for each pair."""
        if (first, second) not in self._apart:
            self._apart[first, second] = self.scene.never_collide(first, second)
        return self._apart[first, second]

    def poses(self, situation: Situation, name: str) -> list[Array]:
        """The poses (4, 4) in the world that a body may have in a situation, without repetitions."""
        if name in self.scene.fixed_poses:
            return [self.scene.fixed_poses[name]]
        found = {}
        for value in situation.objects[name]:
            for parent in self._parents(situation, value.parent):
                pose = parent @ transform(value.position, value.quaternion)
                found[pose.tobytes()] = pose
        return list(found.values())

    def remembered(self, key: tuple[object, ...], make: Callable[[], Any]) -> Any:
        """The cached result for `key`, else that of `make()`; the least recently used results are dropped."""
        known = self._memory.pop(key, None)
        if known is None:
            known = make()
            if len(self._memory) >= MAX_REMEMBERED:
                self._memory.popitem(last=False)
        self._memory[key] = known
        return known

    def _parents(self, situation: Situation, parent: str) -> list[Array]:
        if parent == "world":
            return [np.eye(4)]
        robot, dot, link = parent.partition(".")
        if dot:
            return [self.links(robot, q)[link] for q in situation.robots[robot]]
        return self.poses(situation, parent)
