"""Attachments of objects to robots, to other objects, or to the world; a group of attached objects moves as one.

The root of a group is the object that a hand holds or that stands on something; all other objects of the group are
attached to the root, directly or indirectly.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from kabo.arrays import Array
from kabo.verify.motion.arms import Arm, Mount
from kabo.verify.motion.surfaces import inverse


@dataclass
class AttachmentTree:
    """The parent of every object.

    Attributes:
        arms: the scene's robots.
        fixed: the poses world_T_body of the bodies that never move.
        q: the configuration of every robot to which something is attached.
        hung: object -> its parent (`world`, `robot.link`, a body) and the pose parent_T_object (4, 4).
    """

    arms: Mapping[str, Arm]
    fixed: Mapping[str, Array]
    q: dict[str, Array] = field(default_factory=dict)
    hung: dict[str, tuple[str, Array]] = field(default_factory=dict)

    def copy(self) -> "AttachmentTree":
        """A copy of the tree that can be changed independently."""
        return AttachmentTree(self.arms, self.fixed, dict(self.q), dict(self.hung))

    def root(self, name: str) -> str:
        """The object at the root of an object's group.

        Raises:
            RecursionError: the object is attached to itself.
        """
        for _ in range(len(self.hung) + 1):
            parent = self.hung[name][0]
            if parent not in self.hung:
                return name
            name = parent
        raise RecursionError

    def parent(self, name: str) -> str:
        """The parent of an object's group: `world`, a body that never moves, or `robot.link`."""
        return self.hung[self.root(name)][0]

    def holder(self, name: str) -> str | None:
        """The robot that carries an object, or None."""
        robot, dot, _ = self.parent(name).partition(".")
        return robot if dot else None

    def group(self, name: str) -> list[str]:
        """All objects of the group to which an object belongs, including the object."""
        root = self.root(name)
        return [each for each in self.hung if self.root(each) == root]

    def carried(self, robot: str) -> list[str]:
        """The objects that a robot carries, directly or attached to other objects."""
        return [name for name in self.hung if self.holder(name) == robot]

    def mount(self, name: str) -> Mount | None:
        """The mount of an object on the robot that carries it; None if no robot does."""
        parent, parent_T = self.hung[name]
        if parent in self.hung:
            below = self.mount(parent)
            return None if below is None else below.carrying(parent_T)
        robot, dot, link = parent.partition(".")
        return self.arms[robot].mounts[link].carrying(parent_T) if dot else None

    def pose(self, name: str) -> Array:
        """The present pose (4, 4) of an object in the world.

        Raises:
            KeyError: its parent does not exist.
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
        """Makes an object the root of its group; no pose changes."""
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
        """Attaches an object, together with its group, to a new parent; no pose changes."""
        world_T = self.pose(name)
        self.make_root(name)
        self.hung[name] = parent, inverse(self._frame(parent)) @ world_T
