"""An exploration as one HTML page without scripts or other files: the numbers and maps of each case.

Colours follow the reader's choice of a light or dark page.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path

from kabo.exploration import INFERRED_ALPHA, Exploration
from kabo.tasks.files.describing import counted
from kabo.trials.describing import described_case, described_reason, described_trials, headline
from kabo.trials.drawing import number
from kabo.trials.figures import VALID_COLOUR, figures
from kabo.trials.maps import sections
from kabo.trials.summaries import CaseSummary, OutcomeSummary, summaries_of

UNFOLDED_CASES = 4  # shown when the page is opened; further ones on a click
REASON_COLOURS = 6  # --r0 to --r5; rarer reasons share the last

_STYLE = """
:root { color-scheme: light dark; --line: #8884; --ink: #222; --page: #fff; --dim: #666;
 --r0: #c2410c; --r1: #a21caf; --r2: #1d4ed8; --r3: #a16207; --r4: #be123c; --r5: #57534e; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8e8e8; --page: #121212; --dim: #a0a0a0;
 --r0: #fb923c; --r1: #e879f9; --r2: #7da8ff; --r3: #eac54f; --r4: #fb7185; --r5: #b8b0a8; } }
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 75em; padding: 0 1em;
 background: var(--page); color: var(--ink); }
h1 { font-size: 1.5em; margin-bottom: 0.2em; }
summary { cursor: pointer; font-size: 1.15em; font-weight: 600; margin-top: 1.4em; }
summary:focus-visible { outline: 2px solid; outline-offset: 1px; border-radius: 2px; }
.dim { color: var(--dim); } table { border-collapse: collapse; margin: 0.6em 0; }
td, th { border-bottom: 1px solid var(--line); padding: 0.15em 0.7em; text-align: left; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
.maps { display: flex; flex-wrap: wrap; gap: 0.4em 1.6em; } figure { margin: 0.4em 0; width: 322px; }
figcaption { font-size: 0.9em; } svg.map { display: block; max-width: 100%; }
svg text { font: 11px system-ui, sans-serif; fill: var(--ink); }
.axis { fill: none; stroke: var(--dim); } .strict { fill: none; stroke: var(--ink); stroke-width: 1.5; }
.loose { fill: none; stroke: var(--ink); stroke-width: 1.5; stroke-dasharray: 4 3; }
.dot { stroke: var(--page); stroke-width: 0.8; } .cross { fill: none; stroke-width: 1.7; }
.curve { fill: none; stroke: var(--ink); stroke-width: 1.6; } .band { fill: var(--ink); opacity: 0.14; }
.key { display: inline-block; width: 8em; height: 0.8em; vertical-align: middle; margin: 0 0.4em;
 border: 1px solid var(--line); background-origin: border-box; }
.said { margin: 0.3em 0; } .said span { margin-right: 1.2em; white-space: nowrap; } .mark { font-weight: 700; }
"""


def exploration_page(exploration: Exploration, model: Path | str) -> str:
    """The page of an exploration.

    Args:
        exploration: the exploration.
        model: its file, as the page names it.
    """
    return "".join(_page(exploration, str(model)))


def _page(exploration: Exploration, model: str) -> Iterator[str]:
    title = escape(exploration.name or "exploration")
    summaries = summaries_of(exploration)
    yield f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
    yield f'<meta name="viewport" content="width=device-width"><style>{_STYLE}</style></head><body><main>\n'
    yield f"<h1>{title}</h1><p>{escape(headline(exploration, summaries).removeprefix(f'{exploration.name}: '))}</p>\n"
    options = exploration.validity_options
    said = [model, f"scale {options.scale:g}", f"noise {options.noise:g}", f"model {exploration.digest[:12]}"]
    yield f'<p class="dim">{escape(" · ".join(said))}</p>\n'
    space = exploration.space
    rows = [
        [escape(name), number(lower), number(upper), escape(space.units.get(name, ""))]
        for name, (lower, upper) in space.parameters.items()
    ]
    yield _table(["parameter", "from", "to", "unit"], rows)
    tried = [each for each in summaries if each.trials]
    marks = _marks(tried)
    for i, each in enumerate(tried):
        opened = " open" if i < UNFOLDED_CASES else ""
        yield f"<details{opened}><summary>{escape(described_case(each.case))}</summary>\n"
        yield from _case(exploration, each, marks)
        yield "</details>\n"
    if len(tried) < len(summaries):
        yield f'<p class="dim">{counted(len(summaries) - len(tried), "case")} without trials</p>\n'
    yield "</main></body></html>\n"


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """An HTML table; all columns are numbers, except the first and those called `unit`."""
    kinds = ["" if k == 0 or name == "unit" else ' class="n"' for k, name in enumerate(header)]
    head = "".join(f'<th scope="col"{kind}>{name}</th>' for kind, name in zip(kinds, header, strict=True))
    body = "".join(
        f"<tr>{''.join(f'<td{kind}>{cell}</td>' for kind, cell in zip(kinds, row, strict=True))}</tr>"
        for row in rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>\n"


# ------------------------------------------------------------------------------------------------------- one case
def _marks(summaries: Sequence[CaseSummary]) -> dict[str, str]:
    """The CSS colour of each reason, the same in all cases; only the most frequent reasons have their own."""
    counts: Counter[str] = Counter()
    for each in summaries:
        counts.update(each.reasons)
    return {reason: f"var(--r{min(k, REASON_COLOURS - 1)})" for k, (reason, _) in enumerate(counts.most_common())}


def _case(exploration: Exploration, found: CaseSummary, marks: Mapping[str, str]) -> Iterator[str]:
    yield f'<p class="said">{described_trials(found)}</p>\n'
    if found.outcomes:
        header = ["outcome", "lowest", "highest", "error, leaving one out", "unit"]
        yield _table(header, [_row(name, each) for name, each in found.outcomes.items()])
    yield _legend(found, marks)
    for section in sections(exploration, found.case):
        yield f'<div class="maps">{"".join(figures(exploration, found.case, section, marks))}</div>\n'


def _row(name: str, found: OutcomeSummary) -> list[str]:
    values = (found.lowest, found.highest, found.error)
    return [escape(name), *("–" if value is None else number(value) for value in values), escape(found.unit)]


def _legend(found: CaseSummary, marks: Mapping[str, str]) -> str:
    keys = [f'<span><b class="mark">●</b> {found.valid} valid</span>']
    keys += [
        f'<span><b class="mark" style="color:{marks[reason]}">×</b> {count} {escape(described_reason(reason))}</span>'
        for reason, count in found.reasons.items()
    ]
    gradient = "linear-gradient(90deg, transparent, rgb({},{},{}))".format(*VALID_COLOUR)
    keys.append(
        f'<span>probability of being valid: 0<b class="key" style="background-image:{gradient}"></b>1</span>'
    )
    keys.append(f"<span>– – above {found.alpha:.3g}: tried next</span>")
    keys.append(f"<span>— above {INFERRED_ALPHA:g}: inferred</span>")
    return f'<p class="said">{"".join(keys)}</p>\n'
