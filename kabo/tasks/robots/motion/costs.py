"""Cost terms of motion: path length, duration, tool distance, clearance, distance to a reference [T 3.5].

Each function here is a cost term, or returns one: `stage.cost = path_length`, `stage.cost = clearance(0.1)`.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import candidate, tool_frame
from kabo.tasks.core import CostTerm, Solution
from kabo.tasks.robots.motion.configurations import goal_of
from kabo.tasks.robots.motion.exporting import segments
from kabo.tasks.robots.scenes import Stretch, TaskScene

INFINITE = float("inf")


def _scene(solution: Solution) -> TaskScene:
    state = solution.start or solution.end
    assert state is not None
    scene: TaskScene = state.scene
    return scene


def _moved(solution: Solution) -> Iterator[tuple[TaskScene, Stretch]]:
    """Every stretch in order of time, each with the scene in which it begins."""
    for leaf in solution.leaves:
        state = leaf.start or leaf.end
        for each in leaf.motion or ():
            assert state is not None
            yield state.scene, each


def path_length(solution: Solution) -> float:
    """The sum of the distances that all joints move [rad or m, L1]."""
    return float(sum(np.abs(np.diff(each.path, axis=0)).sum() for _, each in _moved(solution)))


def duration(solution: Solution) -> float:
    """The duration of the motion [s]."""
    made = segments(solution, _scene(solution).context.scene, "")
    return max((segment.times[-1] for segment in made), default=0.0)


def tool_distance(solution: Solution) -> float:
    """The length of the path of the tool frame, straight between way points [m]."""
    total = 0.0
    for scene, each in _moved(solution):
        robot = scene.robot(each.robot)
        if robot.tool is not None:
            points = np.array([candidate(robot, q).pose(tool_frame(robot))[:3, 3] for q in each.waypoints])
            total += float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    return total


def clearance(greatest: float = 0.2, *, along: bool = False, step: float = 0.05) -> CostTerm:
    """A cost term that is the reciprocal of the robot's least distance from everything else [1/m].

    Args:
        greatest: larger distances [m] count as this one.
        along: take the mean over the whole path instead of the least distance.
        step: distance [rad] between the configurations examined; this is an estimate, not a proof.
    """

    def cost(solution: Solution) -> tuple[float, str]:
        # Distances load hulls and scipy, which no other cost term needs.
        from kabo.tasks.robots.motion.distances import distances_along

        found = [d for scene, each in _moved(solution) for d in distances_along(scene, each, greatest, step)]
        if not found:
            return 0.0, ""
        value = float(np.mean(found)) if along else min(found)
        return (1.0 / value if value > 0.0 else INFINITE), f"clearance {value:.4f} m"

    return cost


def distance_to_reference(
    robot: str, reference: Any, weights: Mapping[str, float] | None = None, *, along: bool = False
) -> CostTerm:
    """A cost term: the weighted distance between the robot's last configuration and a reference [rad, L1].

    With `along` it is the mean distance over the path, evaluated at the midpoints of its straight pieces.
    """

    def cost(solution: Solution) -> float:
        state = solution.end or solution.start
        assert state is not None
        scene: TaskScene = state.scene
        chosen = scene.robot(robot)
        factors = np.array([(weights or {}).get(joint, 1.0) for joint in chosen.planned_joints])
        there = goal_of(scene, robot, reference)[: chosen.planned]
        if along:
            paths = [each.path[:, : chosen.planned] for _, each in _moved(solution) if each.robot == robot]
            lengths, middles = _pieces(paths)
            if lengths.sum() > 0.0:
                return float((lengths @ (np.abs(middles - there) @ factors)) / lengths.sum())
        return float((factors * np.abs(scene.configuration(robot)[: chosen.planned] - there)).sum())

    return cost


def _pieces(paths: Sequence[Array]) -> tuple[Array, Array]:
    """The lengths (m,) [L1] and the middles (m, n) of the straight pieces of the paths."""
    if not paths:
        return np.zeros(0), np.zeros((0, 0))
    lengths = np.concatenate([np.abs(np.diff(path, axis=0)).sum(axis=1) for path in paths])
    return lengths, np.concatenate([(path[:-1] + path[1:]) / 2 for path in paths])
