"""Compares two reports by a statistical test of the calls, seconds, costs and failures of each stage [T 3.9].

The samples are runs (for costs, solutions); the test is Mann–Whitney's U, two-sided, which assumes no distribution.
Among many tests some are significant by chance: `adjusted` is p after Holm's correction for all tests.
"""

from collections.abc import Callable, Sequence
from statistics import fmean
from typing import Any, TypedDict

from kabo.tasks.files.report_form import Report, RunReport, StageFigures

FORMAT = "kabo-task-comparison/1"
SIGNIFICANCE = 0.05  # level of the tests, after correction

_FIGURES: dict[str, Callable[[StageFigures], list[float]]] = {
    "calls": lambda f: [float(f["calls"])],
    "seconds": lambda f: [f["seconds"]],
    "successes": lambda f: [float(f["successes"])],
    "failures": lambda f: [float(sum(f["failures"].values()) + sum(f["mismatches"].values()))],
    "costs": lambda f: f["costs"],
}
_WHOLE: dict[str, Callable[[RunReport], list[float]]] = {
    "seconds": lambda run: [run["seconds"]],
    "first solution": lambda run: [found["seconds"] for found in run["found"][:1]],
    "solutions": lambda run: [float(len(run["found"]))],
    "best cost": lambda run: [min(found["cost"] for found in run["found"])] if run["found"] else [],
}


class FigureComparison(TypedDict):
    """One figure in two reports: numbers of samples, means, U and p (None if a report has no samples)."""

    samples: list[int]
    means: list[float | None]
    u: float | None
    p: float | None
    adjusted: float | None


class ReportComparison(TypedDict):
    """The comparison of all figures of two reports: of whole runs, and of each stage that both reports have."""

    format: str
    tasks: list[str]
    runs: list[int]
    whole: dict[str, FigureComparison]
    stages: dict[str, dict[str, FigureComparison]]
    only: list[list[str]]  # the paths of stages that only the first, only the second report has


def compare(first: Report, second: Report) -> ReportComparison:
    """The comparison of two reports, stage by stage."""
    both = [first, second]
    paths = [[stage["path"] for stage in report["stages"]] for report in both]
    shared = [path for path in paths[0] if path in paths[1]]
    whole = {
        name: _compared(*([v for run in report["runs"] for v in figure(run)] for report in both))
        for name, figure in _WHOLE.items()
    }
    stages = {
        path: {
            name: _compared(
                *([v for run in report["runs"] for v in figure(run["stages"][path])] for report in both)
            )
            for name, figure in _FIGURES.items()
        }
        for path in shared
    }
    _adjust([*whole.values(), *(each for figures in stages.values() for each in figures.values())])
    return {
        "format": FORMAT,
        "tasks": [report["task"] for report in both],
        "runs": [len(report["runs"]) for report in both],
        "whole": whole,
        "stages": stages,
        "only": [[p for p in paths[0] if p not in paths[1]], [p for p in paths[1] if p not in paths[0]]],
    }


def _compared(first: Sequence[float], second: Sequence[float]) -> FigureComparison:
    means = [fmean(values) if values else None for values in (first, second)]
    u = p = None
    if first and second:
        from scipy.stats import mannwhitneyu  # loads for a second, which only this test needs

        if len(set(first) | set(second)) == 1:
            u, p = len(first) * len(second) / 2, 1.0  # all samples are equal
        else:
            found: Any = mannwhitneyu(first, second, alternative="two-sided")
            u, p = float(found.statistic), float(found.pvalue)
    return {"samples": [len(first), len(second)], "means": means, "u": u, "p": p, "adjusted": None}


def _adjust(tests: Sequence[FigureComparison]) -> None:
    """Fills in p after Holm's correction for all tests."""
    ordered = sorted((each for each in tests if each["p"] is not None), key=lambda each: each["p"] or 0.0)
    least = 0.0
    for i, each in enumerate(ordered):
        least = max(least, min(1.0, (each["p"] or 0.0) * (len(ordered) - i)))
        each["adjusted"] = least


def describe_comparison(found: ReportComparison) -> str:
    """The comparison as a text table in which significant differences are marked."""
    header = f"{found['tasks'][0]} ({found['runs'][0]} runs) and {found['tasks'][1]} ({found['runs'][1]} runs)"
    rows: list[tuple[str, ...]] = [("", "first", "second", "ratio", "U", "p", "")]
    rows += [_row(f"  {name}", each) for name, each in found["whole"].items()]
    for path, figures in found["stages"].items():
        shown = [(name, each) for name, each in figures.items() if any(each["means"])]
        if shown:
            rows.append((path, "", "", "", "", "", ""))
            rows += [_row(f"  {name}", each) for name, each in shown]
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = [header, ""]
    for row in rows:
        name, *cells = (
            f"{cell:<{w}}" if i == 0 else f"{cell:>{w}}"
            for i, (cell, w) in enumerate(zip(row, widths, strict=True))
        )
        lines.append("  ".join([name, *cells]).rstrip())
    for side, only in zip(("first", "second"), found["only"], strict=True):
        if only:
            lines.append(f"only in the {side}: {', '.join(only)}")
    lines += [
        "",
        f"* differs clearly: p below {SIGNIFICANCE} by Mann–Whitney's U, after Holm's correction for all tests",
    ]
    return "\n".join(lines)


def _row(name: str, each: FigureComparison) -> tuple[str, ...]:
    first, second = each["means"]
    ratio = "" if not first or second is None else f"{second / first:.2f}"
    u = "" if each["u"] is None else f"{each['u']:g}"
    p = "" if each["p"] is None else f"{each['p']:.2g}"
    mark = "*" if each["adjusted"] is not None and each["adjusted"] < SIGNIFICANCE else ""
    return name, _number(first), _number(second), ratio, u, p, mark


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"
