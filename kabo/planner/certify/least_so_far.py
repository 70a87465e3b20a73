"""The least distances along a plan so far: of what comes behind, only what is less than on some branch matters."""

from collections.abc import Iterable

import numpy as np

from kabo.arrays import Array


class LeastSoFar:
    """The least distance of each object on the branches that lead to a node; nodes come in the order of time.

    A distance of an object that is not less than that on any branch to it changes nothing that is told of a branch. So the
    greatest one of all branches that lead to a node is kept.
    """

    def __init__(self, objects: Iterable[str], near: float) -> None:
        """`near` [m]: distances from this on do not count."""
        self._near, self._scopes = near, {name: number for number, name in enumerate(objects, 1)}
        self._arriving: dict[str, Array] = {}
        self.caps = self._fresh()

    def _fresh(self) -> Array:
        return np.full(len(self._scopes) + 1, self._near)

    def scope(self, name: str) -> int:
        """The number of an object; 0 for what is none."""
        return self._scopes.get(name, 0)

    def enter(self, node: str) -> None:
        """Goes on with what is known where a node begins."""
        self.caps = self._arriving.pop(node, self._fresh())

    def note(self, caps: Array) -> None:
        """Notes the least distances during a stretch; the first, that of the stretch, matters for it alone."""
        self.caps = np.minimum(self.caps, caps)
        self.caps[0] = self._near

    def leave(self, node: str, successors: Iterable[str]) -> None:
        """Hands over to the nodes behind one."""
        for after in successors:
            before = self._arriving.get(after)
            self._arriving[after] = self.caps.copy() if before is None else np.maximum(before, self.caps)
