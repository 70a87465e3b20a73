"""The surroundings of all robots of a scene: bodies as convex parts and poses of links, computed once.

What does not depend on the state of a run is kept with the scene, for all who load it: `lasting`.
"""

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from kabo import geometry  # its names load when they are used: python-fcl only for `--geometry exact`
from kabo.arrays import Array, Integers
from kabo.geometry import Budget, CollisionChecker, Enclosure, FixedGroup, MovingGroup
from kabo.geometry_server.answers import GeometryStatistics
from kabo.geometry_server.lasting import Lasting
from kabo.geometry_server.preparation.enclosures import SceneEnclosures
from kabo.geometry_server.situation import Situation
from kabo.scene import Attachment, Configuration, Element, KinematicTree, Mesh, Scene, link_poses
from kabo.scene.transforms import transform

COARSE = (
    0.004  # [m], the share of a body in an epsilon of 1 cm: parts so near decide at first, however fine epsilon is
)
SPARED_SHARE = 0.8  # of the budget's clearance, which counts as what is to be kept; the rest makes proofs short
MAX_REMEMBERED = 640  # workspaces, pairs and containers kept for further questions about the same things


def widened(budget: Budget, kept: float) -> Budget:
    """The budget of bodies that keep more than the clearance from each other [m]."""
    return replace(budget, clearance=budget.clearance + kept, shared=None) if kept > 0.0 else budget


class SceneSurroundings:
    """The bodies of a scene as convex parts, which are computed on first use, and the poses of links."""

    def __init__(
        self,
        scene: Scene,
        budget: Budget,
        exact: bool,
        statistics: GeometryStatistics,
        enclosures: SceneEnclosures | None = None,
        clearance: float = 0.0,
    ) -> None:
        """`clearance` [m] is what bodies keep from each other beyond the budget's; what is uncertain is added."""
        self.clearance = clearance
        self.scene, self.budget, self.exact, self.statistics = scene, budget, exact, statistics
        self.enclosures = SceneEnclosures(scene, budget.geometry) if enclosures is None else enclosures
        self._links: dict[tuple[str, Configuration], Mapping[str, Array]] = {}
        self._own_poses: dict[Attachment, Array] = {}
        self._lasting = Lasting.of(scene, budget, exact, clearance)
        self._memory: OrderedDict[tuple[object, ...], Any] = OrderedDict()
        self._noted: dict[tuple[object, ...], Any] = {}

    @property
    def look(self) -> Callable[[], None]:
        """Called while parts are made; an exception ends that."""
        return self.enclosures.look

    @look.setter
    def look(self, look: Callable[[], None]) -> None:
        self.enclosures.look = look

    @cached_property
    def coarser(self) -> "SceneSurroundings | None":
        """The same surroundings with an accuracy at which few parts are divided, or none; None if these are no finer.

        There all parts within 4 mm of their bodies decide. What is proven free there is free here; what is not may be.

        Raises:
            MeshError: as `enclosure`.
        """
        every = [] if self.exact else [self.enclosures.of(name) for name in self.enclosures.things]
        roots = geometry.budget_of_roots(every, self.budget)
        coarse = 0.0 if roots is None else min(roots.geometry, COARSE)
        if roots is None or coarse <= self.budget.geometry:
            return None
        budget = replace(roots, geometry=coarse)
        return SceneSurroundings(self.scene, budget, False, self.statistics, self.enclosures, self.clearance)

    def checker(
        self,
        tree: KinematicTree,
        moving: Sequence[MovingGroup],
        fixed: Sequence[FixedGroup],
        pairs: Integers,
    ) -> CollisionChecker:
        """A collision checker for these bodies: on convex parts, or on the original meshes if `exact`."""
        if self.exact:
            return geometry.ExactView(tree, moving, fixed, pairs, self.budget)
        groups: list[MovingGroup | FixedGroup] = [*moving, *fixed]
        if any(group.mesh is None for group in groups):  # no surfaces that could be seen to meet
            return geometry.CollisionView(tree, moving, fixed, pairs, self.budget, None, self._lasting.bodies)
        exact: list[geometry.ExactView] = []

        def touch(q: Array, pair: int) -> bool:
            if not exact:  # made when it is first needed, which is seldom
                exact.append(geometry.ExactView(tree, moving, fixed, pairs, self.budget))
            return exact[0].surfaces_touch(q, pair)

        return geometry.CollisionView(tree, moving, fixed, pairs, self.budget, touch, self._lasting.bodies)

    def kept(self, name: str, carrier: str | None = None) -> float:
        """The share of a body or `robot.link` in the distance that a pair keeps [m].

        It is half of the clearance, and how uncertain the body's pose is; for a link, and for what the robot `carrier`
        holds, how uncertain the robot is.
        """
        uncertain = self.scene.uncertain
        owner = name.partition(".")[0]
        return 0.5 * self.clearance + uncertain.get(owner, 0.0) + uncertain.get(carrier or "", 0.0)

    def asked(self, name: str, carrier: str | None = None) -> float:
        """As `kept`, but what checks ask for beyond their budget, which keeps a part of the clearance anyway [m].

        Checks of the original meshes have no budget, so they ask for all.
        """
        spared = 0.0 if self.exact else min(self.clearance, SPARED_SHARE * self.budget.clearance)
        return self.kept(name, carrier) - 0.5 * spared

    @property
    def keeps(self) -> bool:
        """Whether bodies are to keep a distance from each other."""
        return self.clearance > 0.0 or any(self.scene.uncertain.values())

    @property
    def greatest_kept(self) -> float:
        """The greatest distance that any pair keeps, or more [m]."""
        scene = self.scene
        robot = max((self.scene.uncertain.get(name, 0.0) for name in scene.robots), default=0.0)
        return 2.0 * (max((self.kept(name) for name in (*scene.bodies, *scene.robots)), default=0.0) + robot)

    def touch(self, first: FixedGroup, second: FixedGroup) -> bool:
        """Whether two standing bodies may collide, or be nearer than what they keep."""
        kept = first.kept + second.kept
        if self.exact:
            hit = geometry.exact_collides(first, second)
            return hit or (kept > 0.0 and geometry.exact_distance(first, second) <= kept)
        budget = widened(self.budget, kept)
        coarse = geometry.budget_of_roots((first.enclosure, second.enclosure), budget)
        if coarse is not None and not geometry.collides(first, second, coarse):
            return False
        whole = first.mesh is not None and second.mesh is not None  # sight lines have parts alone
        if coarse is not None and whole and geometry.surfaces_touch(first, second):
            return True
        return geometry.collides(first, second, budget)

    def mesh(self, name: str) -> Mesh | None:
        """The mesh of a body or `robot.link`, in its own frame."""
        robot, dot, link = name.partition(".")
        return self.scene.robots[robot].links[link].mesh if dot else self.scene.bodies[name].mesh

    def elements(self, name: str) -> tuple[Element, ...]:
        """The elements of which a body or `robot.link` consists, in its own frame."""
        robot, dot, link = name.partition(".")
        return self.scene.robots[robot].links[link].elements if dot else self.scene.bodies[name].elements

    def enclosure(self, name: str) -> Enclosure:
        """The convex parts that enclose a body or `robot.link`, in its own frame.

        Raises:
            ValueError: it has no geometry.
            MeshError: a mesh cannot be enclosed; it is named with what it belongs to.
        """
        if self.mesh(name) is None:
            raise ValueError(f"{name} has no geometry")
        return self.enclosures.of(name)

    def enclosed(self, element: Element) -> Enclosure:
        """The convex parts that enclose an element, in its own frame."""
        return self.enclosures.of_element(element)

    def links(self, robot: str, q: Configuration) -> Mapping[str, Array]:
        """The pose (4, 4) of every link of a robot at q."""
        if (robot, q) not in self._links:
            self._links[robot, q] = link_poses(self.scene.robots[robot], q)
        return self._links[robot, q]

    def never_collide(self, first: str, second: str) -> bool:
        """The result of `Scene.never_collide`, cached for each pair."""
        found = self._lasting.apart.get((first, second))
        if found is None:
            found = self._lasting.apart[first, second] = self.scene.never_collide(first, second)
        return found

    def poses(self, situation: Situation, name: str) -> list[Array]:
        """The poses (4, 4) in the world that a body may have in a situation, without repetitions."""
        if name in self.scene.fixed_poses:
            return [self.scene.fixed_poses[name]]
        found = {}
        for value in situation.objects[name]:
            own = self._own_pose(value)
            for pose in [own] if value.parent == "world" else self._on(situation, value.parent, own):
                found[pose.tobytes()] = pose
        return list(found.values())

    def _own_pose(self, value: Attachment) -> Array:
        """The pose (4, 4) of an object in the frame of its parent."""
        if value not in self._own_poses:
            self._own_poses[value] = np.eye(4) @ transform(value.position, value.quaternion)
        return self._own_poses[value]

    def remembered(self, key: tuple[object, ...], make: Callable[[], Any]) -> Any:
        """The cached result for `key`, else that of `make()`; the least recently used results are dropped."""
        known = self._memory.pop(key, None)
        if known is None:
            known = make()
            if len(self._memory) >= MAX_REMEMBERED:
                self._memory.popitem(last=False)
        self._memory[key] = known
        return known

    def lasting(self, key: tuple[object, ...], make: Callable[[], Any]) -> Any:
        """As `remembered`, for what the key and the loaded scene alone determine: whoever loads the scene finds it."""
        return self._lasting.found(key, make)

    def noted(self, key: tuple[object, ...], make: Callable[[], Any]) -> Any:
        """As `remembered`, for the few results that are never dropped."""
        if key not in self._noted:
            self._noted[key] = make()
        return self._noted[key]

    def recalled(self, key: tuple[object, ...]) -> Any:
        """The result that is noted for `key`; None if there is none."""
        return self._noted.get(key)

    def _on(self, situation: Situation, parent: str, own: Array) -> list[Array]:
        """The poses (4, 4) in the world of what has its own pose in the frame of a link or of another body."""
        robot, dot, link = parent.partition(".")
        if dot:
            return [self.links(robot, q)[link] @ own for q in situation.robots[robot]]
        return [pose @ own for pose in self.poses(situation, parent)]
