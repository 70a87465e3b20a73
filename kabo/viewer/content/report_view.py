"""The report of a task's planning in the view document: words for the tree of stages, states and films for the stage."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

from kabo.tasks.core import shown
from kabo.tasks.files.describing import added, counted, counts, describe_report, duration, explain, number, said
from kabo.tasks.files.report_form import Report, RunReport, StageFigures, StageReport, Whole
from kabo.viewer.content.document import View
from kabo.viewer.content.films import film_view, flat_state

if TYPE_CHECKING:
    from kabo.scene import Scene

UNFOLDED_LEVELS = 2  # levels of the tree of stages that are unfolded at first
MAX_FILMS = 10  # solutions of one run, the first ones, whose motion the page plays: each has its weight
MIN_TIME_SHARE = 0.02  # share of the whole time from which on it is told


def report_view(report: Mapping[str, Any], scene: "Scene | None", solution: int | None = None) -> View:
    """The part `report` of a view document, of a report `kabo-task/2`; states and films only with the scene.

    `solution` is the number of the only one that has a film, from 1 in the order of all runs; None: the first ones.

    Raises:
        KeyError: the report names a robot, joint or object that is not in the scene.
        ValueError: a film is none.
    """
    read = cast("Report", report)
    runs = read["runs"]
    given = [f"{name} = {value}" for name, value in read["arguments"].items()]
    before = [sum(len(run["solutions"]) for run in runs[:k]) for k in range(len(runs))]
    return {
        "headline": describe_report(read, 0).split("\n", 1)[0].partition(": ")[2],
        "given": [*([read["file"]] if read["file"] else []), *given],
        "whys": [
            {"seed": run["seed"], "stage": run["explanation"]["stage"], "text": explain(run["explanation"])}
            for run in runs
            if run["explanation"] is not None
        ],
        "stages": _stages(read["stages"], runs, scene),
        "runs": [
            {
                "seed": run["seed"],
                "solutions": [
                    _whole(k, run, scene if _is_shown(first, k, solution) else None)
                    for k in range(len(run["solutions"]))
                ],
            }
            for first, run in zip(before, runs, strict=True)
        ],
    }


# ----------------------------------------------------------------------------------------------------- the stages
def _stages(
    stages: Sequence[StageReport], runs: Sequence[RunReport], scene: "Scene | None"
) -> list[dict[str, Any]]:
    blamed = {run["explanation"]["stage"] for run in runs if run["explanation"] is not None} - {None}
    total = sum(run["stages"][stage["path"]]["seconds"] for run in runs for stage in stages)
    made = []
    for stage in stages:
        figures = [run["stages"][stage["path"]] for run in runs]
        holds_blamed = any(str(path).startswith(f"{stage['path']}/") for path in blamed)
        guilty = stage["path"] in blamed
        made.append(
            {
                "path": stage["path"],
                "name": stage["name"],
                "type": stage["type"],
                "depth": stage["depth"],
                "arrows": stage["arrows"],
                "blamed": guilty,
                "open": guilty or holds_blamed or stage["depth"] < UNFOLDED_LEVELS,
                "properties": _properties(stage),
                **_figures(figures, total),
                "solutions": _solved(figures),
                "failures": _failures(figures, scene),
            }
        )
    return made


def _properties(stage: StageReport) -> list[list[str]]:
    given = dict(stage["properties"])
    if stage["monitors"]:
        given["monitors"] = stage["monitors"]
    return [[name, shown(value)] for name, value in given.items()]


def _figures(figures: Sequence[StageFigures], total: float) -> dict[str, Any]:
    """What a stage did, in numbers and words; `share` of the whole time, or None if that is too small to be told."""
    calls, seconds = sum(f["calls"] for f in figures), sum(f["seconds"] for f in figures)
    failures = added(f["failures"] for f in figures)
    return {
        "solved": sum(f["successes"] for f in figures),
        "failed": sum(failures.values()),
        "reasons": [[reason, said(reason), count] for reason, count in failures.items()],
        "mismatches": counts(added(f["mismatches"] for f in figures)),
        "work": f"{counted(calls, 'call')}, {duration(seconds)}" if calls else "",
        "share": seconds / total if seconds >= MIN_TIME_SHARE * total > 0.0 else None,
    }


def _solved(figures: Sequence[StageFigures]) -> dict[str, Any]:
    found = [each for f in figures for each in f["solutions"]]
    rows = [
        {"cost": number(each["cost"]), "comment": each["comment"], "changes": each["changes"]} for each in found
    ]
    return {"title": _title("solution", len(found), sum(f["successes"] for f in figures)), "rows": rows}


def _failures(figures: Sequence[StageFigures], scene: "Scene | None") -> dict[str, Any]:
    found = [each for f in figures for each in f["refusals"]]
    rows = []
    for each in found:
        sample = each.get("sample")
        rows.append(
            {
                "reason": each["reason"],
                "said": said(each["reason"]),
                "comment": each["comment"],
                "changes": each["changes"],
                "state": None if sample is None or scene is None else flat_state(sample["state"], scene),
                "between": None if sample is None else sample.get("between"),
            }
        )
    return {
        "title": _title("failure", len(found), sum(sum(f["failures"].values()) for f in figures)),
        "rows": rows,
    }


def _title(what: str, listed: int, count: int) -> str:
    return counted(count, what) if listed >= count else f"{what}s: the first {listed} of {count}"


# -------------------------------------------------------------------------------------------------- the solutions
def _whole(k: int, run: RunReport, scene: "Scene | None") -> dict[str, Any]:
    solution: Whole = run["solutions"][k]
    seconds = f", after {run['found'][k]['seconds']:.3g} s" if k < len(run["found"]) else ""
    film = None if scene is None or "motion" not in solution else film_view(solution["motion"], scene)
    return {
        "title": f"{k + 1}: cost {number(solution['cost'])}{seconds}",
        "comment": solution["comment"],
        "parts": [
            {
                "stage": part["stage"],
                "cost": number(part["cost"]),
                "comment": part["comment"],
                "changes": part["changes"],
                "time": _begin(part["stage"], solution),
            }
            for part in solution["parts"]
        ],
        "film": film,
    }


def _is_shown(first: int, k: int, solution: int | None) -> bool:
    """Whether solution `k` of a run before which there are `first` others is played."""
    return k < MAX_FILMS if solution is None else first + k + 1 == solution


def _begin(path: str, solution: Whole) -> float | None:
    """When the first motion of a stage, or of one inside it, begins in the film [s]; None if nothing moves in it."""
    segments = solution["motion"]["segments"] if "motion" in solution else []
    own = (s["times"][0] for s in segments if s["stage"] is not None and f"{s['stage']}/".startswith(f"{path}/"))
    return min(own, default=None)
