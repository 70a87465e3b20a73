"""Geometric questions behind failed attempts, stored so that they can be answered again in another context."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kabo.geometry_server import Measure, Pair, ProcedureContext, Refusal, Stream, pair_text, way_to
from kabo.scene import Configuration
from kabo.tasks.robots.motion.constraints import keep_of
from kabo.tasks.robots.motion.nearness import own_nearness
from kabo.tasks.robots.motion.targets import Target
from kabo.tasks.robots.scenes import TaskScene, configuration

MAX_REPEATED_SAMPLES = 60  # samples of a path search that is repeated


@dataclass(frozen=True)
class PathSearch:
    """The arguments of a path search: the key of its random stream, its number of samples, the stage's property `keep`."""

    key: tuple[str | int | float, ...]
    samples: int
    keep: Any = None


@dataclass(frozen=True)
class MotionQuestion:
    """The question whether a robot is free at a way point, along straight pieces, or along a path to be searched.

    With a `target` and no way points it asks whether the hand alone is free at the target's pose.
    """

    scene: TaskScene
    robot: str
    waypoints: tuple[Configuration, ...] = ()
    search: PathSearch | None = None
    target: Target | None = None

    @property
    def is_search(self) -> bool:
        """Whether the question needs a path search to be answered."""
        return self.search is not None

    @property
    def streams(self) -> list[Stream]:
        """The random stream of the question's target, as a list; empty if there is none."""
        stream = getattr(self.target, "stream", None)
        stream = getattr(stream, "stream", stream)
        return [stream] if isinstance(stream, Stream) else []

    def passes(self, context: ProcedureContext, without: str | None = None) -> bool:
        """Whether the robot is free in another context, optionally with the body `without` removed."""
        scene = replace(self.scene, context=context, _known={})
        if without is not None:
            links = (f"{self.robot}.{link}" for link in scene.robot(self.robot).links)
            scene = scene.permitting((mover, without) for mover in (*links, *scene.situation.carried(self.robot)))
        if not self.waypoints:
            return self.target is not None and self.target.blocked(scene) is None
        workspace, path = scene.workspace(self.robot), [np.array(q) for q in self.waypoints]
        if self.search is not None:
            key, samples, keep = self.search.key, self.search.samples, keep_of(scene, self.robot, self.search.keep)
            found = way_to(workspace, path[0], path[-1], key, min(samples, MAX_REPEATED_SAMPLES), keep)
            return not isinstance(found, Refusal)
        return workspace.first_hit(path[0]) is None and (len(path) == 1 or workspace.path_hit(path) is None)

    def nearness(self, pair: Pair) -> Measure | None:
        """How near two links of the robot come at the way points, or where it stands; None for other pairs."""
        return own_nearness(self.scene, self.robot, pair, self.waypoints)


def hand_blocked(scene: TaskScene, robot: str, target: Target) -> Refusal | None:
    """The refusal if the hand alone collides at a target, whatever the arm does.

    The result is None if no such collision is known.
    """
    hit = target.blocked(scene)
    if hit is None:
        return None
    asked = MotionQuestion(scene, robot, target=target)
    return Refusal.collision(hit, f"the hand would hit: {pair_text(hit)}", question=asked)


def along(scene: TaskScene, robot: str, *waypoints: Iterable[float]) -> MotionQuestion:
    """The question whether a robot is free at one way point (n,), or along straight pieces between several."""
    return MotionQuestion(scene, robot, tuple(map(configuration, waypoints)))
