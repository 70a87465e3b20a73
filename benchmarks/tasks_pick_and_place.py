"""Pick and place [T 3.9.1]: the first solution, ten of them, and what an independent replay says of each.

Figures of the thesis (C++, a processor with 24 cores, one thread): first solution below 0.2 s, ten in 1.12 s, the best
duration from 12.25 s down to 9.5 s over 100 solutions.
"""

from collections.abc import Sequence
from itertools import accumulate
from statistics import median

import numpy as np
from table import Table
from tasks_applications import Application, Clock, applications
from tasks_judge import Judge, Replay, tilt

from kabo.tasks import Solution

PLACE = (0.6, -0.15, 0.125)  # m: where the middle of the cylinder is to be
OUTSET = 0.001  # m


def pick_and_place_tables(robots: list[str], seeds: int, solutions: int, judged: int) -> list[Table]:
    """A table for each robot."""
    return [
        _table(each, seeds, solutions, judged) for each in applications("pick_and_place", robots, "panda.yaml")
    ]


def _table(application: Application, seeds: int, wanted: int, judged: int) -> Table:
    table = Table(f"Pick and place, {application.scene.name}")
    judge, rows = Judge(application.scene), []
    task, scene = application.start(1000)
    task.plan(scene, wanted)  # compiles what is not compiled yet
    for seed in range(seeds):
        row, found = _planned(application, seed, wanted)
        row |= _judged(judge, found[:judged])
        rows.append(row)
        table.add(f"seed {seed}", **row)
    table.add("all", **_all(rows, seeds, wanted))
    return table


def _planned(application: Application, seed: int, wanted: int) -> tuple[dict[str, object], Sequence[Solution]]:
    task, scene = application.start(seed)
    clock = Clock()
    task.plan(scene, 1)
    first = clock.passed()
    found = task.plan(scene, wanted)
    every = clock.passed()
    best = list(accumulate((solution.cost for solution in found), min))
    calls = sum(figures.calls for figures in task.statistics.values())
    row: dict[str, object] = {"solutions": len(found), "first s": first[0], "first processor s": first[1]}
    row |= {f"{wanted} s": every[0], f"{wanted} processor s": every[1], "stage calls": calls}
    if best:
        row |= {"first duration": best[0], "best duration": best[-1]}
        row["best never rises"] = (
            all(b <= a for a, b in zip(best, best[1:], strict=False))
            and task.best is not None
            and task.best.cost == best[-1]
        )
    return row, found


def _judged(judge: Judge, found: Sequence[Solution]) -> dict[str, object]:
    """What a replay says: gaps between stretches, collisions on the exact meshes, where the cylinder stands."""
    replays = [judge.replay(solution, permitted(judge)) for solution in found]
    if not replays:
        return {"replayed": 0}
    return {
        "replayed": len(replays),
        "gap": max(each.gap for each in replays),
        "collisions": sum(len(each.collisions) for each in replays),
        "off m": max(map(_off, replays)),
        "tilt rad": max(tilt(each.poses["object"]) for each in replays),
    }


def _off(replay: Replay) -> float:
    return float(np.linalg.norm(replay.poses["object"][:3, 3] - PLACE))


def permitted(judge: Judge) -> dict[str, list[frozenset[str]]]:
    """Fingers may touch the object, and the object its table while it is taken from there or put there."""
    gripper = judge.scene.robots["arm"].gripper
    assert gripper is not None
    standing = [frozenset(("object", "table"))]
    return {
        "": [frozenset((link, "object")) for link in gripper.touch_links],
        "pick/lift": standing,
        "place/lower": standing,
    }


def _all(rows: Sequence[dict[str, object]], seeds: int, wanted: int) -> dict[str, object]:
    def middle(name: str) -> float:
        return median(float(row[name]) for row in rows)  # type: ignore[arg-type]

    def most(name: str) -> float:
        return max(float(row.get(name, 0.0)) for row in rows)  # type: ignore[arg-type]

    timed = ("first s", "first processor s", f"{wanted} s", f"{wanted} processor s", "stage calls")
    solved = sum(row["solutions"] == wanted for row in rows)
    return (
        {"solutions": f"{solved} of {seeds} seeds"}
        | {name: middle(name) for name in timed}
        | {name: middle(name) for name in ("first duration", "best duration") if name in rows[0]}
        | {"best never rises": all(row.get("best never rises") for row in rows)}
        | {"replayed": sum(int(row["replayed"]) for row in rows)}  # type: ignore[call-overload]
        | {name: most(name) for name in ("gap", "collisions", "off m", "tilt rad")}
    )
