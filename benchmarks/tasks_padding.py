"""Retract, transit, approach [T 3.9.3]: every pair of configurations, with and without air around the thing.

Figures of the thesis (6 axes, 12 x 8 configurations): all 96 pairs; padded transits keep 5 cm, of the others 23 % come
closer than 1.5 cm; 0.31 s to the first solution and 3.4 s for all with ten workers, unpadded 0.15 s and 1.0 s.
"""

from collections.abc import Sequence

from table import Table, percentile
from tasks_applications import Application, Clock, applications
from tasks_judge import Judge

from kabo.tasks import Solution
from kabo.tasks.robots import stretches

AIR = 0.05  # m: what padding is to keep
CLOSE = 0.015  # m
SPACING = 0.001  # m: no point of the robot moves farther between two looks
TRANSIT = "padded transit/transit"


def padding_tables(robots: list[str], judged: int) -> list[Table]:
    """A table for each robot; with `judged` 0, nothing is measured."""
    tables = []
    for application in applications("retract_transit_approach", robots, "panda.yaml"):
        table = Table(f"Retract, transit, approach, {application.scene.name}")
        judge = Judge(application.scene)
        task, scene = application.start(1000)
        task.plan(scene, 1)  # compiles what is not compiled yet
        for name, arguments in (("padded", {}), ("unpadded", {"padded": []})):
            table.add(name, **_planned(application, judge, arguments, judged))
        tables.append(table)
    return tables


def _planned(
    application: Application, judge: Judge, arguments: dict[str, object], judged: int
) -> dict[str, object]:
    task, scene = application.start(0, **arguments)
    clock = Clock()
    task.plan(scene, 1)
    first = clock.passed()
    found = task.plan(scene)
    every = clock.passed()
    starts, ends = (task.statistics[name].successes for name in ("retract", "approach"))
    row: dict[str, object] = {"pairs": starts * ends, "solved": len(found)}
    row |= {"first s": first[0], "first processor s": first[1], "all s": every[0], "all processor s": every[1]}
    row["padding beside the transit"] = sum(map(_extras_beside, found))
    if not judged or not found:
        return row
    replays = [judge.replay(solution, {}) for solution in found[:judged]]
    row |= {
        "gap": max(each.gap for each in replays),
        "collisions": sum(len(each.collisions) for each in replays),
    }
    clearances = [_clearance(judge, solution) for solution in found]
    lower, upper = zip(*clearances, strict=True)
    row |= {"least m": min(lower), "median m": percentile(lower, 0.5)}
    row["at least 5 cm"] = f"{100 * sum(c >= AIR for c in lower) / len(found):.4g} %"
    row["below 1.5 cm"] = f"{100 * sum(c < CLOSE for c in upper) / len(found):.4g} %"
    return row


def _clearance(judge: Judge, solution: Solution) -> tuple[float, float]:
    """Bounds of the least distance of the robot from the thing on the way around it [m]."""
    ways = [each for path, each in stretches(solution) if path == TRANSIT]
    lower, upper = zip(*(judge.clearance(each, "object", SPACING) for each in ways), strict=True)
    return min(lower), min(upper)


def _extras_beside(solution: Solution) -> int:
    """In how many scenes before or after the transit there are bodies that do not belong there."""
    parts: Sequence[Solution] = [part for part in solution.walk() if not part.parts]
    scenes = [state.scene for part in parts for state in (part.start, part.end) if state is not None]
    inside = {
        id(state.scene)
        for part in parts
        if part.stage.path == TRANSIT
        for state in (part.start, part.end)
        if state
    }
    return sum(bool(scene.extras) and id(scene) not in inside for scene in scenes)
