"""What a refused attempt had asked of geometry, kept so that it can be asked again elsewhere: exactly, say."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kabo.geometry_server import ProcedureContext, Refused, way_to
from kabo.scene import Configuration
from kabo.tasks.robots.motion.keeping import keep_of
from kabo.tasks.robots.scenes import TaskScene, configuration

if TYPE_CHECKING:
    from collections.abc import Iterable

    from kabo.tasks.robots.motion.targets import Target

FEW = 60  # samples of a search for a way that is made again


@dataclass(frozen=True)
class Search:
    """A way that was looked for: the key of its random stream, its samples, and the stage's property `keep`."""

    key: tuple[str | int | float, ...]
    samples: int
    keep: Any = None


@dataclass(frozen=True)
class Question:
    """Whether a robot may stand at one way point, move straight through several, or find a way between two.

    With a `target` and no way points it is the hand alone that is asked for, where the target wants it.
    """

    scene: TaskScene
    robot: str
    waypoints: tuple[Configuration, ...] = ()
    search: Search | None = None
    target: "Target | None" = None

    def passes(self, context: ProcedureContext, without: str | None = None) -> bool:
        """Whether the answer is yes in another context, or with a body out of the way; all else is the same."""
        scene = replace(self.scene, context=context, _known={})
        if without is not None:
            links = (f"{self.robot}.{link}" for link in scene.robot(self.robot).links)
            scene = scene.permitting((mover, without) for mover in (*links, *scene.situation.carried(self.robot)))
        if not self.waypoints:
            return self.target is not None and self.target.blocked(scene) is None
        workspace, path = scene.workspace(self.robot), [np.array(q) for q in self.waypoints]
        if self.search is not None:
            key, samples, keep = self.search.key, self.search.samples, keep_of(scene, self.robot, self.search.keep)
            found = way_to(workspace, path[0], path[-1], key, min(samples, FEW), keep)
            return not isinstance(found, Refused)
        return workspace.first_hit(path[0]) is None and (len(path) == 1 or workspace.path_hit(path) is None)


def along(scene: TaskScene, robot: str, *waypoints: "Iterable[float]") -> Question:
    """The question whether a robot may stand at a way point (n,), or move straight through several."""
    return Question(scene, robot, tuple(map(configuration, waypoints)))
