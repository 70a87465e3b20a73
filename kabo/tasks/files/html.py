"""A report as one self-contained HTML page with collapsible sections, without scripts or other files [T 3.1]."""

from collections.abc import Iterator, Sequence
from html import escape

from kabo.tasks.core import shown
from kabo.tasks.files.describing import added, counted, counts, describe_report, duration, explain, number, said
from kabo.tasks.files.report_form import Report, RunReport, StageFigures, StageReport, Whole

_STYLE = """
:root { color-scheme: light dark; --line: #8884; --good: #1f6f3b; --bad: #b3402e; --dim: #666; }
@media (prefers-color-scheme: dark) { :root { --good: #6cc48a; --bad: #f08a76; --dim: #a0a0a0; } }
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 75em; padding: 0 1em; }
h1 { font-size: 1.5em; margin-bottom: 0.2em; } h2 { font-size: 1.15em; margin-top: 1.8em; }
details { margin: 0; } details > *:not(summary) { margin-left: 1.4em; }
details > details { border-left: 1px solid var(--line); padding-left: 0.4em; }
summary { cursor: pointer; padding: 0.12em 0 0.12em 3.8em; text-indent: -3.8em; }
summary:hover { background: #8881; }
summary > * { margin-right: 0.45em; display: inline-block; text-indent: 0; }
summary:focus-visible { outline: 2px solid; outline-offset: 1px; border-radius: 2px; }
.blame { background: #b3402e22; } .share { display: inline-block; height: 0.55em; margin-right: 0.6em; background: #8886; }
.arrows { font-family: monospace; color: var(--dim); white-space: pre; } .type { color: var(--dim); font-size: 0.9em; }
.good { color: var(--good); } .bad { color: var(--bad); } .dim { color: var(--dim); }
table { border-collapse: collapse; margin: 0.4em 0 0.8em; } th { text-align: left; font-weight: 600; }
td, th { border-bottom: 1px solid var(--line); padding: 0.15em 0.7em; }
td { vertical-align: top; } td.n, th.n { text-align: right; }
pre { background: #8881; padding: 0.7em; overflow-x: auto; }
"""


UNFOLDED_LEVELS = 2  # levels of the tree of stages that are unfolded at first
MIN_TIME_SHARE = 0.02  # share of the whole time from which on it is drawn


def to_html(report: Report) -> str:
    """The page of a report: why planning failed, the tree of stages, and all solutions of the task."""
    return "".join(_page(report))


def _page(report: Report) -> Iterator[str]:
    title = escape(report["task"])
    headline = escape(describe_report(report, 0).split("\n", 1)[0].partition(": ")[2])
    yield f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
    yield f'<meta name="viewport" content="width=device-width"><style>{_STYLE}</style></head><body><main>\n'
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
    yield "</main></body></html>\n"


# ----------------------------------------------------------------------------------------------------- the stages
def _tree(stages: Sequence[StageReport], runs: Sequence[RunReport]) -> Iterator[str]:
    """The stages, each inside its container."""
    depth = -1
    blamed = {run["explanation"]["stage"] for run in runs if run["explanation"] is not None} - {None}
    total = sum(run["stages"][stage["path"]]["seconds"] for run in runs for stage in stages)
    for stage, after in zip(stages, [*stages[1:], None], strict=True):
        yield "</details>\n" * (depth + 1 - stage["depth"])
        depth = stage["depth"]
        figures = [run["stages"][stage["path"]] for run in runs]
        guilty = stage["path"] in blamed
        above = any(str(path).startswith(f"{stage['path']}/") for path in blamed)
        holds = after is not None and after["depth"] > depth
        opened = " open" if (holds and depth < UNFOLDED_LEVELS) or guilty or above else ""
        yield f"<details{opened}><summary class='blame'>" if guilty else f"<details{opened}><summary>"
        yield f"{_summary(stage, figures, total)}{' – never succeeds' if guilty else ''}</summary>\n"
        yield from _stage(stage, figures)
    yield "</details>\n" * (depth + 1)


def _summary(stage: StageReport, figures: Sequence[StageFigures], total: float) -> str:
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
        parts.append(f'<span class="bad">({escape(counts(failures))})</span>')
    if mismatches:
        parts.append(f'<span class="bad">never fit: {escape(counts(mismatches))}</span>')
    if calls:
        seconds = sum(f["seconds"] for f in figures)
        parts.append(f'<span class="dim">{counted(calls, "call")}, {duration(seconds)}</span>')
        if seconds >= MIN_TIME_SHARE * total > 0.0:
            share = 100 * seconds / total
            bar = f'<span class="share" style="width: {share / 10:.1f}em"></span>'
            parts.append(f'<span class="dim">{bar}{share:.0f} % of the time</span>')
    return " ".join(parts)


def _stage(stage: StageReport, figures: Sequence[StageFigures]) -> Iterator[str]:
    given = dict(stage["properties"])
    if stage["monitors"]:
        given["monitors"] = stage["monitors"]
    if given:
        rows = [[escape(name), escape(shown(value))] for name, value in given.items()]
        yield from _folded("properties", _table(["property", "value"], rows))
    found = [each for f in figures for each in f["solutions"]]
    if found:
        rows = [[number(each["cost"]), escape(each["comment"]), _changes(each["changes"])] for each in found]
        successes = sum(f["successes"] for f in figures)
        yield from _folded(_title("solution", len(found), successes), _table(["cost", "comment", "changes"], rows))
    refused = [each for f in figures for each in f["refusals"]]
    if refused:
        rows = [
            [escape(said(each["reason"])), escape(each["comment"]), _changes(each["changes"])] for each in refused
        ]
        failures = sum(sum(f["failures"].values()) for f in figures)
        yield from _folded(
            _title("failure", len(refused), failures), _table(["reason", "comment", "changes"], rows)
        )


def _title(what: str, shown: int, count: int) -> str:
    return counted(count, what) if shown >= count else f"{what}s: the first {shown} of {count}"


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
    rows = [
        [escape(part["stage"]), number(part["cost"]), escape(part["comment"]), _changes(part["changes"])]
        for part in solution["parts"]
    ]
    yield from _folded(title, _table(["stage", "cost", "comment", "changes"], rows))


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table without its empty columns."""
    told = [k for k, _ in enumerate(header) if k == 0 or any(row[k] for row in rows)]
    head = "".join(f'<th scope="col"{_aligned(header[k])}>{header[k]}</th>' for k in told)
    body = "".join(f"<tr>{''.join(f'<td{_aligned(header[k])}>{row[k]}</td>' for k in told)}</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _aligned(name: str) -> str:
    return ' class="n"' if name == "cost" else ""
