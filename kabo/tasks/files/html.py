"""A report as one self-contained HTML page: no script, no file beside it, nothing fetched; everything folds [T 3.1]."""

from collections.abc import Iterator, Sequence
from html import escape

from kabo.tasks.core import shown
from kabo.tasks.files.describing import added, counts, describe_report, explain, number, said
from kabo.tasks.files.report_form import Figures, Report, RunReport, StageReport, Whole

_STYLE = """
:root { color-scheme: light dark; --line: #8884; --good: #2a7d46; --bad: #b3402e; --dim: #777; }
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 75em; padding: 0 1em; }
h1 { font-size: 1.5em; margin-bottom: 0.2em; } h2 { font-size: 1.15em; margin-top: 1.8em; }
details { margin: 0; } details > *:not(summary) { margin-left: 1.4em; }
summary { cursor: pointer; padding: 0.12em 0; } summary:hover { background: #8881; }
.arrows { font-family: monospace; color: var(--dim); white-space: pre; } .type { color: var(--dim); font-size: 0.9em; }
.good { color: var(--good); } .bad { color: var(--bad); } .dim { color: var(--dim); }
table { border-collapse: collapse; margin: 0.4em 0 0.8em; } th { text-align: left; font-weight: 600; }
td, th { border-bottom: 1px solid var(--line); padding: 0.15em 0.7em; }
td { vertical-align: top; } td.n, th.n { text-align: right; }
pre { background: #8881; padding: 0.7em; overflow-x: auto; }
"""


def to_html(report: Report) -> str:
    """The page of a report: why it failed, the tree of stages, and all whole solutions."""
    return "".join(_page(report))


def _page(report: Report) -> Iterator[str]:
    title = escape(report["task"])
    headline = escape(describe_report(report, 0).split("\n", 1)[0].partition(": ")[2])
    yield f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
    yield f'<meta name="viewport" content="width=device-width"><style>{_STYLE}</style></head><body>\n'
    yield f"<h1>{title}</h1><p>{headline}</p>\n"
    given = [f"{name} = {value}" for name, value in report["arguments"].items()]
    if report["file"] or given:
        yield f'<p class="dim">{escape(" · ".join([*([report["file"]] if report["file"] else []), *given]))}</p>\n'
    for run in report["runs"]:
        if run["explanation"] is not None:
            text = explain(run["explanation"])
            yield f'<h2 class="bad">No solution with seed {run["seed"]}</h2><pre>{escape(text)}</pre>\n'
    yield "<h2>Stages</h2>\n"
    yield from _tree(report["stages"], report["runs"])
    yield from _solutions(report["runs"])
    yield "</body></html>\n"


# ----------------------------------------------------------------------------------------------------- the stages
def _tree(stages: Sequence[StageReport], runs: Sequence[RunReport]) -> Iterator[str]:
    """The stages, each inside what holds it."""
    depth = -1
    for stage in stages:
        yield "</details>\n" * (depth + 1 - stage["depth"])
        depth = stage["depth"]
        figures = [run["stages"][stage["path"]] for run in runs]
        yield f"<details{' open' if depth < 2 else ''}><summary>{_summary(stage, figures)}</summary>\n"  # noqa: PLR2004
        yield from _stage(stage, figures)
    yield "</details>\n" * (depth + 1)


def _summary(stage: StageReport, figures: Sequence[Figures]) -> str:
    successes, calls = sum(f["successes"] for f in figures), sum(f["calls"] for f in figures)
    failures, mismatches = added(f["failures"] for f in figures), added(f["mismatches"] for f in figures)
    failed = sum(failures.values())
    parts = [
        f'<span class="arrows">{escape(stage["arrows"])}</span> <b>{escape(stage["name"])}</b>',
        f'<span class="type">{escape(stage["type"])}</span>',
        f'<span class="{"good" if successes else "dim"}">{successes} solved</span>',
        f'<span class="{"bad" if failed else "dim"}">{failed} failed</span>',
    ]
    if failures:
        parts.append(f'<span class="bad">{escape(counts(failures))}</span>')
    if mismatches:
        parts.append(f'<span class="bad">never fit: {escape(counts(mismatches))}</span>')
    if calls:
        parts.append(f'<span class="dim">{calls} calls, {sum(f["seconds"] for f in figures):.3g} s</span>')
    return " ".join(parts)


def _stage(stage: StageReport, figures: Sequence[Figures]) -> Iterator[str]:
    given = dict(stage["properties"])
    if stage["monitors"]:
        given["monitors"] = stage["monitors"]
    if given:
        rows = ([escape(name), escape(shown(value))] for name, value in given.items())
        yield from _folded("properties", _table(["property", "value"], rows))
    found = [each for f in figures for each in f["solutions"]]
    if found:
        rows = ([number(each["cost"]), escape(each["comment"]), _changes(each["changes"])] for each in found)
        successes = sum(f["successes"] for f in figures)
        yield from _folded(
            _title("solutions", len(found), successes), _table(["cost", "comment", "changes"], rows)
        )
    refused = [each for f in figures for each in f["refusals"]]
    if refused:
        rows = (
            [escape(said(each["reason"])), escape(each["comment"]), _changes(each["changes"])] for each in refused
        )
        failures = sum(sum(f["failures"].values()) for f in figures)
        yield from _folded(
            _title("failures", len(refused), failures), _table(["reason", "comment", "changes"], rows)
        )


def _title(what: str, shown: int, count: int) -> str:
    return f"{count} {what}" if shown >= count else f"{what}: the first {shown} of {count}"


def _folded(title: str, content: str) -> Iterator[str]:
    yield f'<details><summary class="dim">{escape(title)}</summary>{content}</details>\n'


def _changes(lines: Sequence[str]) -> str:
    return "<br>".join(map(escape, lines))


# -------------------------------------------------------------------------------------------------- the solutions
def _solutions(runs: Sequence[RunReport]) -> Iterator[str]:
    several = len(runs) > 1
    for run in runs:
        if not run["solutions"]:
            continue
        seed = f" with seed {run['seed']}" if several else ""
        yield f"<h2>Solutions{seed}</h2>\n"
        for i, solution in enumerate(run["solutions"], 1):
            yield from _whole(i, run["found"][i - 1]["seconds"] if i <= len(run["found"]) else None, solution)


def _whole(i: int, seconds: float | None, solution: Whole) -> Iterator[str]:
    title = f"{i}: cost {number(solution['cost'])}" + (f", after {seconds:.3g} s" if seconds is not None else "")
    if solution["comment"]:
        title += f", {solution['comment']}"
    rows = (
        [escape(part["stage"]), number(part["cost"]), escape(part["comment"]), _changes(part["changes"])]
        for part in solution["parts"]
    )
    yield from _folded(title, _table(["stage", "cost", "comment", "changes"], rows))


def _table(header: Sequence[str], rows: Iterator[list[str]]) -> str:
    head = "".join(f"<th{_aligned(name)}>{name}</th>" for name in header)
    body = "".join(
        f"<tr>{''.join(f'<td{_aligned(name)}>{cell}</td>' for name, cell in zip(header, row, strict=True))}</tr>"
        for row in rows
    )
    return f"<table><tr>{head}</tr>{body}</table>"


def _aligned(name: str) -> str:
    return ' class="n"' if name == "cost" else ""
