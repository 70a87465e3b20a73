"""Reparameterisation [T 3.4.1]: how much shorter pick and place is when phases of one scene follow without stops.

The same solution is timed three ways within the same limits of velocity and acceleration: resting at every way point,
resting at the end of every phase (corners inside are rounded), and resting only where the scene changes. A solution
of the thesis' figure 3.3 became 10 % shorter.
"""

from collections.abc import Sequence
from statistics import fmean, median
from time import process_time
from typing import Any

import numpy as np
from table import Table
from tasks_applications import Application, applications
from tasks_judge import Judge
from tasks_pick_and_place import permitted

from kabo.scene import Scene, motion_limits
from kabo.tasks import Solution
from kabo.tasks.robots import Reparameterise, Stretch, segments, stretches

SPACING = 0.002  # rad: along both paths, where their distance is measured
DEVIATIONS = (0.02, 0.05, 0.1)
TOLERANCE = 1e-3  # of the limits: times are whole microseconds


def reparameterisation_tables(robots: list[str], seeds: int) -> list[Table]:
    """A table for each robot: a row for each deviation."""
    return [_table(each, seeds) for each in applications("pick_and_place", robots, "panda.yaml")]


def _table(application: Application, seeds: int) -> Table:
    table, judge = Table(f"Reparameterisation, {application.scene.name}"), Judge(application.scene)
    solutions = []
    for seed in range(seeds):
        task, scene = application.start(seed)
        solutions += task.plan(scene, 1)
    for deviation in DEVIATIONS:
        rows = [_row(solution, application.scene, judge, deviation) for solution in solutions]
        table.add(f"{deviation} rad", solutions=len(solutions), **_all(rows))
    return table


def _row(solution: Solution, scene: Scene, judge: Judge, deviation: float) -> dict[str, Any]:
    phases = _made(solution, deviation=deviation, across=False)
    began = process_time()
    made = _made(solution, deviation=deviation)
    seconds = process_time() - began
    resting = _made(solution, deviation=0.0, across=False)
    speeds, accelerations = _shares(made, scene)
    return {
        "s resting at way points": _duration(resting, scene),
        "s resting after phases": _duration(phases, scene),
        "s": _duration(made, scene),
        "processor s": seconds,
        "deviation": _deviation(solution, made),
        "speed share": speeds,
        "acceleration share": accelerations,
        "collisions": len(judge.replay(made, permitted(judge)).collisions),
        "stops": made.comment != "no stops inside",
    }


def _made(solution: Solution, **properties: Any) -> Solution:
    """The solution as the wrapper changes it."""
    stage = Reparameterise("reparameterised", **properties)
    values = {name: stage.properties.value(name) for name in stage.PROPERTIES}
    (result,) = stage.transform(solution, values, 0)
    return Solution(
        stage, solution.start, solution.end, result.cost, result.comment, motion=result.motion, parts=(solution,)
    )


def _duration(solution: Solution, scene: Scene) -> float:
    return segments(solution, scene, "")[-1].times[-1]


def _deviation(solution: Solution, made: Solution) -> float:
    """How far motion without stops and the old path are from each other at most, either way round [rad, L2].

    Over each run between two changes of the scene, borders between its phases included; both densely sampled.
    """
    old = iter(zip((each for _, each in stretches(solution)), (each for _, each in stretches(made)), strict=True))
    found, pairs = 0.0, [(before, after) for before, after in old if after.timed is not None]
    for run in _runs(made):
        before = _path([next(b for b, a in pairs if a is each) for each in run])
        found = max(found, _away(before, _path(run)), _away(_path(run), before))
    return found


def _path(run: Sequence[Stretch]) -> Any:
    return np.concatenate([run[0].path[:1], *(each.path[1:] for each in run)])


def _away(path: Any, other: Any) -> float:
    """The greatest distance of points all along a path of straight pieces from another such path."""
    starts, ways = other[:-1], np.diff(other, axis=0)
    squares, found = np.maximum((ways * ways).sum(axis=1), 1e-18), 0.0
    for a, b in zip(path, path[1:], strict=False):
        count = max(2, int(np.ceil(np.linalg.norm(b - a) / SPACING)) + 1)
        steps = (a + np.linspace(0.0, 1.0, count)[:, None] * (b - a))[:, None] - starts
        shares = np.clip((steps * ways).sum(axis=2) / squares, 0.0, 1.0)
        found = max(found, float(np.linalg.norm(steps - shares[..., None] * ways, axis=2).min(axis=1).max()))
    return found


def _shares(solution: Solution, scene: Scene) -> tuple[float, float]:
    """The greatest velocity and acceleration of any joint, as a share of its limit; by differences of way points."""
    speeds, accelerations = [0.0], [0.0]
    for group in _runs(solution):
        robot = scene.robots[group[0].robot]
        limits = motion_limits(robot, robot.planned_joints)
        path = _path(group)[:, : robot.planned]
        steps = np.concatenate([np.diff(each.timed.times) for each in group if each.timed is not None])
        velocities = np.diff(path, axis=0) / steps[:, None]
        speeds.append(float((np.abs(velocities) / limits.velocity).max()))
        between = (steps[1:] + steps[:-1])[:, None] / 2
        accelerations.append(float((np.abs(np.diff(velocities, axis=0) / between) / limits.acceleration).max()))
        ends = np.abs(velocities[[0, -1]]) / (steps[[0, -1]] / 2)[:, None]  # from rest, and to it
        accelerations.append(float((ends / limits.acceleration).max()))
    return max(speeds), max(accelerations)


def _runs(solution: Solution) -> list[list[Stretch]]:
    """Stretches that follow each other without a change of the scene."""
    runs: list[list[Stretch]] = [[]]
    for _, each in stretches(solution):
        if each.timed is not None:
            runs[-1].append(each)
        elif runs[-1]:
            runs.append([])
    return [run for run in runs if run]


def _all(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    gains = [1.0 - row["s"] / row["s resting after phases"] for row in rows]
    return {
        "mean gain": fmean(gains),
        "least gain": min(gains),
        "gain over resting at way points": fmean(1.0 - row["s"] / row["s resting at way points"] for row in rows),
        "s": fmean(row["s"] for row in rows),
        "processor s": median(row["processor s"] for row in rows),
        **{name: max(row[name] for row in rows) for name in ("deviation", "speed share", "acceleration share")},
        "collisions": sum(row["collisions"] for row in rows),
        "with stops": sum(row["stops"] for row in rows),
    }
