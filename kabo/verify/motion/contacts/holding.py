"""What hangs on what: objects on robots, on other objects, or in the world; a group hangs together and moves as one.

The root of a group is what is held or stands; the others hang on it, directly or through each other.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from kabo.arrays import Array
from kabo.verify.motion.arms import Arm, Mount
from kabo.verify.motion.surfaces import inverse


@dataclass
class Holding:
    """Objects by name with what they hang on.

    Attributes:
        arms: of the scene's robots.
        fixed: world_T_body of the bodies that never move.
        q: the configuration of every robot that something hangs on.
        hung: object -> its parent (`world`, `robot.link`, a body) and parent_T_object (4, 4).
    """

    arms: Mapping[str, Arm]
    fixed: Mapping[str, Array]
    q: dict[str, Array] = field(default_factory=dict)
    hung: dict[str, tuple[str, Array]] = field(default_factory=dict)

    def copy(self) -> "Holding":
        """One that changes on its own."""
        return Holding(self.arms, self.fixed, dict(self.q), dict(self.hung))

    def root(self, name: str) -> str:
        """The object at the root of an object's group.

        Raises:
            RecursionError: it hangs on itself.
        """
        for _ in range(len(self.hung) + 1):
            parent = self.hung[name][0]
            if parent not in self.hung:
                return name
            name = parent
        raise RecursionError

    def parent(self, name: str) -> str:
        """What the group of an object hangs on: `world`, a body that never moves, or `robot.link`."""
        return self.hung[self.root(name)][0]

    def holder(self, name: str) -> str | None:
        """The robot that carries an object, if one does."""
        robot, dot, _ = self.parent(name).partition(".")
        return robot if dot else None

    def group(self, name: str) -> list[str]:
        """All that hangs together with an object, itself too."""
        root = self.root(name)
        return [each for each in self.hung if self.root(each) == root]

    def carried(self, robot: str) -> list[str]:
        """What a robot carries."""
        return [name for name in self.hung if self.holder(name) == robot]

    def mount(self, name: str) -> Mount | None:
        """Where an object hangs on a robot; None: on none."""
        parent, parent_T = self.hung[name]
        if parent in self.hung:
            below = self.mount(parent)
            return None if below is None else below.carrying(parent_T)
        robot, dot, link = parent.partition(".")
        return self.arms[robot].mounts[link].carrying(parent_T) if dot else None

    def pose(self, name: str) -> Array:
        """Where an object is now (4, 4), in the world.

        Raises:
            KeyError: its parent is nothing that exists.
        """
        if name in self.fixed:
            return self.fixed[name]
        parent, parent_T = self.hung[name]
        result: Array = self._frame(parent) @ parent_T
        return result

    def _frame(self, parent: str) -> Array:
        if parent == "world":
            return np.eye(4)
        if parent in self.fixed or parent in self.hung:
            return self.pose(parent)
        robot, dot, link = parent.partition(".")
        if not dot:
            raise KeyError(parent)
        return self.arms[robot].pose(self.q[robot].tolist(), self.arms[robot].mounts[link])

    def make_root(self, name: str) -> None:
        """Hangs the group of an object by that object: nothing moves."""
        chain = [name]
        while self.hung[chain[-1]][0] in self.hung:
            chain.append(self.hung[chain[-1]][0])
        top, top_T = self.hung[chain[-1]]
        placed = [top_T]
        for each in reversed(chain[:-1]):
            placed.append(placed[-1] @ self.hung[each][1])
        links = [(chain[k], self.hung[chain[k]][1]) for k in range(len(chain) - 1)]
        for k, (_, parent_T) in enumerate(links):
            self.hung[chain[k + 1]] = chain[k], inverse(parent_T)
        self.hung[name] = top, placed[-1]

    def hang(self, name: str, parent: str) -> None:
        """Hangs an object, and with it all of its group, on something else, where it is."""
        world_T = self.pose(name)
        self.make_root(name)
        self.hung[name] = parent, inverse(self._frame(parent)) @ world_T
