"""Geometric questions behind failed attempts, stored so that they can be answered again in another context."""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np

from kabo.errors import CutOff
from kabo.geometry_server import Measure, Pair, ProcedureContext, Refusal, Situation, Stream, pair_text, way_to
from kabo.scene import Configuration
from kabo.tasks.robots.motion.constraints import keep_of
from kabo.tasks.robots.motion.nearness import own_nearness
from kabo.tasks.robots.motion.targets import GraspTarget, PlacementTarget, PoseTarget, Target
from kabo.tasks.robots.scenes import TaskScene, configuration

MAX_REPEATED_SAMPLES = 60  # samples of a path search that is repeated
POINTS_PER_PIECE = 8  # of a straight piece that was refused, where the first that is not free is looked for
MAX_BATCHES_SHOWN = 2  # batches of a target's configurations in which one to be shown is looked for


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

    def sample(self) -> Situation:
        """The situation with the robot where it was refused: at the first point of its way that is not free.

        Where no path was found, this is the path's end. Where the hand alone was asked about, it is the first
        configuration that reaches the target; as it stands if there is none.
        """
        q = self.refused_at()
        return self.scene.situation if q is None else self.scene.at(self.robot, q).situation

    def refused_at(self) -> Iterable[float] | None:
        """The configuration of `sample`; None if none is known that puts the hand at the target."""
        if not self.waypoints:
            few = () if self.target is None else islice(self.target.batches(), MAX_BATCHES_SHOWN)
            return next((candidate.q for batch in few for candidate in batch), None)
        if len(self.waypoints) == 1 or self.search is not None:
            return self.waypoints[-1]
        pieces = np.array(self.waypoints)
        steps = np.linspace(0.0, 1.0, POINTS_PER_PIECE, endpoint=False)[:, None]
        between = [a + steps * (b - a) for a, b in zip(pieces, pieces[1:], strict=False)]
        every = np.ascontiguousarray(np.concatenate([*between, pieces[-1:]]))
        with suppress(CutOff):
            hits = np.nonzero(self.scene.workspace(self.robot).hits(every) >= 0)[0]
            return self.waypoints[-1] if not len(hits) else [float(value) for value in every[hits[0]]]
        return self.waypoints[-1]


def hand_blocked(scene: TaskScene, robot: str, target: Target) -> Refusal | None:
    """The refusal if the hand alone collides at a target, whatever the arm does.

    The result is None if no such collision is known.
    """
    hit = target.blocked(scene)
    if hit is None:
        return None
    asked = MotionQuestion(scene, robot, target=target)
    return Refusal.collision(hit, f"the hand would hit: {pair_text(hit)}", question=asked)


def unreached(scene: TaskScene, robot: str, target: Target) -> Refusal:
    """The refusal if no configuration of a robot was found at a target, with the proof that there is none, if known."""
    short = target.unreached() if isinstance(target, PoseTarget) else None
    missing = None if short is None or short.missing == 0.0 else short.missing
    text = f"no configuration of {robot} was found" if short is None else f"the pose is {short} for {robot}"
    asked = MotionQuestion(scene, robot, target=target)
    measures = target.out_of_reach(scene) if isinstance(target, (GraspTarget, PlacementTarget)) else ()
    return Refusal("out_of_reach", text, missing=missing, question=asked, measures=measures)


def along(scene: TaskScene, robot: str, *waypoints: Iterable[float]) -> MotionQuestion:
    """The question whether a robot is free at one way point (n,), or along straight pieces between several."""
    return MotionQuestion(scene, robot, tuple(map(configuration, waypoints)))
