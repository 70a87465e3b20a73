"""What is known of a loaded scene whatever its state: it lasts as long as the scene is loaded.

A process may solve, verify and repair problems of a scene again and again. What the scene, the accuracy and the distances
to be kept determine is computed once for all of them.
"""

import threading
from collections.abc import Callable
from typing import Any

from kabo import geometry  # its names load when they are used
from kabo.geometry import Budget
from kabo.scene import Scene

MOST_FACTS = 20_000  # of a scene; then all are forgotten
Key = tuple[object, ...]


class _OfThread(threading.local):
    """The arrays of views, which are scratch memory: each thread has its own."""

    def __init__(self) -> None:
        self.bodies = geometry.BodyMemories()


class Lasting:
    """Facts by key, pairs of things that never collide, and the arrays that collision views share."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene  # whose things the facts are about
        self.apart: dict[tuple[str, str], bool] = {}
        self._facts: dict[Key, Any] = {}
        self._own = _OfThread()

    @classmethod
    def of(cls, scene: Scene, budget: Budget, exact: bool, clearance: float) -> "Lasting":
        """What is known of a scene at some accuracy; scenes that differ in their state alone have it in common."""
        key = "lasting", budget, exact, clearance, tuple(sorted(scene.uncertain.items()))
        known: Lasting | None = scene.memory.get(key)
        if known is None or not known._is_about(scene):
            known = scene.memory[key] = cls(scene)
        return known

    def _is_about(self, scene: Scene) -> bool:
        names = "robots", "bodies", "regions", "allowed", "fixed_poses"
        return all(getattr(self.scene, name) is getattr(scene, name) for name in names)

    @property
    def bodies(self) -> geometry.BodyMemories:
        """The arrays that the views of this thread use in turn."""
        return self._own.bodies

    def found(self, key: Key, make: Callable[[], Any]) -> Any:
        """The fact for `key`, which is not None, else the result of `make()`."""
        known = self._facts.get(key)
        if known is None:
            known = make()
            if len(self._facts) >= MOST_FACTS:
                self._facts.clear()
            self._facts[key] = known
        return known
