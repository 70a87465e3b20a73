"""The pairs of links of one robot that are checked, and which of them are not proven apart at configurations."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from kabo.arrays import Array, Booleans
from kabo.geometry import CollisionChecker, FixedGroup, MovingGroup
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.scene import Robot, link_poses
from kabo.scene.transforms import flat

LinkPair = tuple[str, str]


@dataclass
class LinkPairs:
    """One robot's links with the enclosures that its surroundings give; nothing else is in its way.

    `look` is called before each pair, and may raise.
    """

    surroundings: SceneSurroundings
    robot: Robot
    look: Callable[[], None] = lambda: None
    _checkers: dict[LinkPair, CollisionChecker] = field(default_factory=dict)

    @cached_property
    def pairs(self) -> list[LinkPair]:
        """All pairs of links that are checked: not on one joint, not neighbours, not allowed to touch."""
        names = [link.name for link in self.robot.links.values() if link.elements]
        own = f"{self.robot.name}."
        apart = self.surroundings.never_collide
        return [(a, b) for i, a in enumerate(names) for b in names[i + 1 :] if not apart(own + a, own + b)]

    def meets(self, pair: LinkPair, q: Sequence[float]) -> bool:
        """Whether two links may touch at a configuration."""
        return self._checker(pair).configuration_hit(np.asarray(q, np.float64)) >= 0

    def meets_at(self, pair: LinkPair, configurations: Array) -> Booleans:
        """The result of `meets` for each configuration (N, n)."""
        return np.asarray(self._checker(pair).configurations_hit(configurations) >= 0)

    def meeting(self, q: Sequence[float], pairs: Sequence[LinkPair] | None = None) -> list[LinkPair]:
        """The pairs that may touch at a configuration; of those given, or of all."""
        asked = self.pairs if pairs is None else pairs
        near = self._near(q)
        return [pair for pair in asked if near(pair) and self.meets(pair, q)]

    def any_meeting(self, configurations: Array, pairs: Sequence[LinkPair]) -> Booleans:
        """For each configuration (N, n) whether one of the pairs may touch."""
        if not pairs:
            return np.zeros(len(configurations), dtype=bool)
        names = sorted({name for pair in pairs for name in pair})
        moving, fixed, number = self._groups(names)
        chosen = np.array([sorted((number[a], number[b])) for a, b in pairs], dtype=np.int64)
        checker = self.surroundings.checker(self.robot.tree, moving, fixed, chosen)
        return np.asarray(checker.configurations_hit(configurations) >= 0)

    def _near(self, q: Sequence[float]) -> Callable[[LinkPair], bool]:
        """Whether the boxes of two links come near each other at a configuration."""
        poses = link_poses(self.robot, q)
        reach = 2.0 * self.surroundings.budget.epsilon if self.surroundings.budget.geometry < 1.0 else 1.0
        spheres: dict[str, tuple[Array, float]] = {}
        for name, link in self.robot.links.items():
            if link.mesh is not None and len(link.mesh.vertices):
                low, high = link.mesh.bounds
                middle = poses[name][:3, :3] @ (0.5 * (low + high)) + poses[name][:3, 3]
                spheres[name] = middle, 0.5 * float(np.linalg.norm(high - low))

        def near(pair: LinkPair) -> bool:
            (first, r), (second, s) = spheres[pair[0]], spheres[pair[1]]
            return float(np.linalg.norm(first - second)) <= r + s + reach

        return near

    def _checker(self, pair: LinkPair) -> CollisionChecker:
        if pair not in self._checkers:
            self.look()
            moving, fixed, number = self._groups(pair)
            chosen = np.array([sorted((number[pair[0]], number[pair[1]]))], dtype=np.int64)
            self._checkers[pair] = self.surroundings.checker(self.robot.tree, moving, fixed, chosen)
        return self._checkers[pair]

    def _groups(self, names: Sequence[str]) -> tuple[list[MovingGroup], list[FixedGroup], Mapping[str, int]]:
        """Links that move, links that stand, and the number of each among both."""
        standing = [name for name in names if self.robot.stands(name)]
        moving = [name for name in names if name not in standing]
        poses = link_poses(self.robot, np.zeros(self.robot.tree.size).tolist()) if standing else {}
        enclosures = {name: self.surroundings.enclosure(f"{self.robot.name}.{name}") for name in names}
        movers = []
        for name in moving:
            link = self.robot.links[name]
            movers.append(MovingGroup(link.joint, flat(link.joint_T_link), enclosures[name]))
        stands = [FixedGroup(flat(poses[name]), enclosures[name]) for name in standing]
        return movers, stands, {name: number for number, name in enumerate([*moving, *standing])}
