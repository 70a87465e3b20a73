"""Bottle pouring [T 3.9.2]: three ways to choose among configurations, in three variants of the task.

Closest: one configuration for each pose; all grasps: up to 16 for each grasp; all: up to 16 everywhere. The thesis (30
runs, 10 workers): closest solves pour left only (in 1.4 s on average, all grasps in 6.5 s), all grasps pour right as
well, all also with an obstacle.

Here the three take the same way to a first solution, for another grasp is tried before another configuration for one
that was tried: more to choose from costs nothing before it is needed. So closest is not twice as fast as all grasps
to the first solution, as it is in the thesis: both are as fast. A second table says what few configurations save
beyond it: the times to more solutions, and until everything was tried, depth first at first and round by round, as
in [T 3.6]. To 20 solutions closest takes a sixth to a third less; all that there is to try is tried in an eighth of the
time of all grasps, and its best solution costs the same.
"""

from collections.abc import Sequence
from statistics import median
from time import process_time
from typing import Any

import numpy as np
from table import Table
from tasks_applications import Application, applications
from tasks_judge import Judge, looks

from kabo.scene import link_pose
from kabo.tasks import Solution
from kabo.tasks.robots import stretches

COUNTS, MORE_SEEDS = (1, 5, 20), 3
STRATEGIES = {"closest": (1, 1), "all grasps": (16, 1), "all": (16, 16)}
LEFT, RIGHT = np.pi / 2, -np.pi / 2
VARIANTS = {"pour left": (LEFT, ""), "pour right": (RIGHT, ""), "with obstacle": (RIGHT, "with_obstacle")}


def pouring_tables(robots: list[str], seeds: int, limit: float) -> list[Table]:
    """A table for each robot: a row for each variant and strategy."""
    plain = applications("bottle_pouring", robots, "ur5.yaml")
    blocked = applications("bottle_pouring", robots, "ur5_with_obstacle.yaml", "with_obstacle.yaml")
    tables = [_table(a, b, seeds, limit) for a, b in zip(plain, blocked, strict=True)]
    return tables + [_more(application, min(seeds, MORE_SEEDS), limit / 2) for application in plain]


def _table(plain: Application, blocked: Application, seeds: int, limit: float) -> Table:
    table = Table(f"Bottle pouring, {plain.scene.name}")
    for variant, (towards, obstacle) in VARIANTS.items():
        application = blocked if obstacle else plain
        judge = Judge(application.scene)
        _planned(application, 1000, towards, (16, 16), limit)  # compiles what is not compiled yet
        for strategy, most in STRATEGIES.items():
            rows = [_planned(application, seed, towards, most, limit) for seed in range(seeds)]
            table.add(f"{variant}, {strategy}", **_all(rows, judge))
    return table


def _planned(
    application: Application, seed: int, towards: float, most: tuple[int, int], limit: float
) -> dict[str, Any]:
    began = process_time()

    def late() -> bool:
        return process_time() - began >= limit

    arguments = {"towards": towards, "grasp_solutions": most[0], "other_solutions": most[1]}
    task, scene = application.start(seed, **arguments)
    task.plan(scene, 1, stop=late)
    calls = sum(figures.calls for figures in task.statistics.values())
    return {"seconds": process_time() - began, "calls": calls, "found": task.solutions, "tried": task.exhausted}


def _more(application: Application, seeds: int, limit: float) -> Table:
    """Processor seconds of each strategy to so many solutions, and until all was tried, pouring left."""
    table = Table(f"Bottle pouring left, more solutions, {application.scene.name}, {limit:g} s at most")
    _planned(application, 1000, LEFT, (16, 16), limit)  # compiles what is not compiled yet
    for order in ("depth first", "rounds"):
        for strategy, most in STRATEGIES.items():
            rows = [_counted(application, seed, most, limit, order) for seed in range(seeds)]
            table.add(f"{strategy}, {order}", **{name: median(row[name] for row in rows) for name in rows[0]})
    return table


def _counted(
    application: Application, seed: int, most: tuple[int, int], limit: float, order: str
) -> dict[str, float]:
    """Seconds to so many solutions, infinite if the limit came first or there were fewer; and what was found."""
    task, scene = application.start(seed, towards=LEFT, grasp_solutions=most[0], other_solutions=most[1])
    if order == "rounds":
        task.depth_first = 0
    began, row = process_time(), {}
    for wanted in (*COUNTS, None):
        task.plan(scene, wanted, stop=lambda: process_time() - began >= limit)
        done = task.exhausted if wanted is None else len(task.solutions) >= wanted
        row["s to all" if wanted is None else f"s to {wanted}"] = process_time() - began if done else np.inf
    costs = [solution.cost for solution in task.solutions]
    return row | {"solutions": len(costs), "best cost": min(costs, default=np.inf)}


def _all(rows: Sequence[dict[str, Any]], judge: Judge) -> dict[str, Any]:
    solved = [row for row in rows if row["found"]]
    figures: dict[str, Any] = {
        "solved": f"{len(solved)} of {len(rows)}",
        "proven unsolvable": sum(not row["found"] and row["tried"] for row in rows),
        "processor s": median(row["seconds"] for row in rows),
        "longest": max(row["seconds"] for row in rows),
        "stage calls": median(row["calls"] for row in rows),
    }
    found = [row["found"][0] for row in solved]
    if found:
        leans = [lean(solution, judge) for solution in found]
        figures |= {"lean way points": max(a for a, _ in leans), "lean between": max(b for _, b in leans)}
        figures["poured"] = min(poured(solution, judge) for solution in found)
        replays = [judge.replay(s, permitted(judge)) for s in found]
        figures["collisions"] = sum(len(each.collisions) for each in replays)
        figures |= {"looks": sum(each.looks for each in replays), "gap": max(each.gap for each in replays)}
    return figures


def permitted(judge: Judge) -> dict[str, list[frozenset[str]]]:
    """Fingers may touch the bottle, and the bottle its table while it is taken from there or put there."""
    gripper = judge.scene.robots["arm"].gripper
    assert gripper is not None
    standing = [frozenset(("bottle", "table"))]
    return {
        "": [frozenset((link, "bottle")) for link in gripper.touch_links],
        "pick/lift": standing,
        "place/lower": standing,
    }


def lean(solution: Solution, judge: Judge) -> tuple[float, float]:
    """How far the bottle leans at most while it is carried, but for pouring: at way points, and in between [rad]."""
    carried = [(p, e, a) for p, e, a in _carrying(solution, judge) if p != "pour"]
    at = [_leaning(a, q, judge) for _, e, a in carried for q in e.path]
    between = [_leaning(a, q, judge) for _, e, a in carried for q in looks(e, 0.02)]
    return max(at), max(between)


def poured(solution: Solution, judge: Judge) -> float:
    """How far the bottle leans when it pours [rad]."""
    return max(_leaning(a, q, judge) for p, e, a in _carrying(solution, judge) if p == "pour" for q in e.path)


def _carrying(solution: Solution, judge: Judge) -> list[tuple[str, Any, Any]]:
    """Stages and arm stretches while the bottle is in the hand, with its axis in the tool's frame."""
    found, axis, upright = [], None, np.array([0.0, 0.0, 1.0])
    for path, each in stretches(solution):
        if axis is not None and each.group == "arm":
            found.append((path, each, axis))
        if each.attach:
            axis = _tool(each.path[-1], judge)[:3, :3].T @ upright
        if each.detach:
            axis = None
    return found


def _tool(q: Any, judge: Judge) -> Any:
    return link_pose(judge.scene.robots["arm"], q, "tool0")


def _leaning(axis: Any, q: Any, judge: Judge) -> float:
    return float(np.arccos(np.clip((_tool(q, judge)[:3, :3] @ axis)[2], -1.0, 1.0)))
