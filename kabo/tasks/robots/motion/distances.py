"""Distances between a robot and everything else along a motion: for costs, not for proofs."""

from collections.abc import Iterator

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import ScenePredicates
from kabo.tasks.robots.scenes import Stretch, TaskScene


def distances_along(scene: TaskScene, each: Stretch, greatest: float, step: float) -> Iterator[float]:
    """The least distance [m], at most `greatest`, at configurations along the stretch that are `step` [rad] apart."""
    for q in _sampled(each, step):
        yield _least(scene.at(each.robot, q), each.robot, greatest)


def _sampled(each: Stretch, step: float) -> Iterator[Array]:
    path = each.path
    yield path[0]
    for a, b in zip(path, path[1:], strict=False):
        pieces = max(1, int(np.ceil(np.abs(b - a).max() / step)))
        for k in range(1, pieces + 1):
            yield a + (b - a) * (k / pieces)


def _least(scene: TaskScene, robot: str, greatest: float) -> float:
    workspace = scene.workspace(robot)
    predicates = ScenePredicates(scene.context.surroundings, scene.situation.first)
    least = greatest
    for first, second in workspace.pairs:
        if any(extra.name in (first, second) for extra in scene.extras):
            continue
        bounds = predicates.distance(first, second)
        least = min(least, max(bounds.lower, 0.0))
    return least
