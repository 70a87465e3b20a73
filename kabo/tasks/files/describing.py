"""Reports as text for a terminal: the tree of stages with their figures, and why there is no solution [T 3.1]."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from statistics import fmean, median
from unicodedata import category

from kabo.tasks.files.report_form import Report, RunReport, StageReport, Why

MAX_COMMENTS = 3  # comments shown for each stage


def describe_report(report: Report, comments: int = MAX_COMMENTS) -> str:
    """The tree of stages with counts, costs and failures over all runs, and why some runs have no solution."""
    lines = [_headline(report), ""]
    shown = [_stage_line(stage, report["runs"]) for stage in report["stages"]]
    width = max(len(left) for left, _ in shown)
    for stage, (left, right) in zip(report["stages"], shown, strict=True):
        lines.append(f"{left:<{width}}  {right}".rstrip())
        indent = " " * (2 * stage["depth"] + 8)
        lines += [indent + line for line in _comments(stage["path"], report["runs"], comments)]
    failed = [run for run in report["runs"] if run["explanation"] is not None]
    for run in failed[:1]:
        assert run["explanation"] is not None
        rest = f" (and in {len(failed) - 1} more of {len(report['runs'])} runs)" if len(failed) > 1 else ""
        until = "stopped before everything was tried; until then " if run["stopped"] else ""
        lines += ["", f"no solution with seed {run['seed']}{rest}: {until}{explain(run['explanation'])}"]
    return "\n".join(lines)


def _headline(report: Report) -> str:
    runs = report["runs"]
    if len(runs) == 1:
        return f"{in_one_line(report['task'])}: {_told_run(runs[0])}"
    solved = [run for run in runs if run["solutions"]]
    text = f"{report['task']}: {len(runs)} runs with seeds {runs[0]['seed']} to {runs[-1]['seed']}, {len(solved)} solved"
    if solved:
        first = median(run["found"][0]["seconds"] for run in solved)
        best = median(min(found["cost"] for found in run["found"]) for run in solved)
        text += f"; median: first solution after {first:.3g} s, best cost {number(best)}"
    return text


def _told_run(run: RunReport) -> str:
    count = len(run["found"])
    text = f"{count or 'no'} solution{'' if count == 1 else 's'}"
    if run["found"]:
        best = min(found["cost"] for found in run["found"])
        text += f", best cost {number(best)}, the first after {run['found'][0]['seconds']:.3g} s"
    rest = "there may be more" if run["found"] else "given up"
    ended = "everything was tried" if run["exhausted"] else "stopped" if run["stopped"] else rest
    return f"{text}; {run['seconds']:.3g} s in all, {ended}"


def _stage_line(stage: StageReport, runs: Sequence[RunReport]) -> tuple[str, str]:
    figures = [run["stages"][stage["path"]] for run in runs]
    left = f"{'  ' * stage['depth']}{stage['arrows']}  {in_one_line(stage['name'])}  [{stage['type']}]"
    calls, successes = sum(f["calls"] for f in figures), sum(f["successes"] for f in figures)
    failures = added(f["failures"] for f in figures)
    mismatches = added(f["mismatches"] for f in figures)
    parts = [f"{successes} solved", f"{sum(failures.values())} failed"]
    if calls:
        seconds = sum(f["seconds"] for f in figures)
        parts.append(f"{calls} call{'' if calls == 1 else 's'} in {seconds:.3g} s")
    costs = [cost for f in figures for cost in f["costs"]]
    if any(costs):
        parts.append(f"cost {_range(costs)}")
    if failures:
        parts.append(counts(failures))
    if mismatches:
        parts.append(f"pairs that never fit: {counts(mismatches)}")
    return left, " · ".join(parts)


def _range(costs: Sequence[float]) -> str:
    low, high = min(costs), max(costs)
    if low == high:
        return number(low)
    return f"{number(low)} to {number(high)}, mean {number(fmean(costs))}"


def _comments(path: str, runs: Sequence[RunReport], most: int) -> Iterator[str]:
    """The comments of solutions and failures, each once with its count, the most frequent first."""
    for sign, key in (("+", "solutions"), ("-", "refusals")):
        told: Counter[str] = Counter()
        for run in runs:
            for each in run["stages"][path][key]:  # type: ignore[literal-required]
                reason = each.get("reason")
                text = each["comment"]
                if text:
                    told[f"{reason}: {text}" if reason else text] += 1
        for text, count in told.most_common(most):
            yield f"{sign} {text}" + (f" ({count} times)" if count > 1 else "")
        if len(told) > most > 0:
            yield f"{sign} and {len(told) - most} more"


def explain(why: Why) -> str:
    """The text of an explanation: the first stage without successes, its failures and mismatches by reason."""
    if why["stage"] is None:
        return why["text"]
    lines = [f'the stage "{in_one_line(why["stage"])}" never succeeds']
    if why["failures"]:
        lines.append("  it was refused:")
        lines += [f"    {count:>5} × {said(reason)}" for reason, count in why["failures"].items()]
    if why["mismatches"]:
        lines.append("  pairs of states that it can never join:")
        lines += [f"    {count:>5} × {reason}" for reason, count in why["mismatches"].items()]
    if why["examples"]:
        lines.append("  such as:")
        lines += [f"    {comment}" for comment in why["examples"][:5]]
    if len(lines) == 1:
        lines.append("  it was asked and gave no answer at all")
    return "\n".join(lines)


_REASON_WORDS = {
    "out_of_reach": "out of reach, or no configuration found",
    "collision": "in collision",
    "constraint": "a constraint does not hold",
    "no_path": "no path found",
    "empty_family": "no grasp or placement of the family fits",
    "hidden": "something is in the way of the camera's view",
    "out_of_view": "out of the camera's range or field of view",
    "not_explored": "nothing has been tried",
    "nothing_valid": "no parameters are believed valid",
    "out_of_range": "no valid parameters give the wanted outcome",
}


def said(reason: str) -> str:
    """A failure reason as words for users."""
    return _REASON_WORDS.get(reason, reason.replace("_", " "))


def counts(found: Mapping[str, int]) -> str:
    """Counts by reason as text: `collision 8, no path 1`."""
    return ", ".join(f"{reason.replace('_', ' ')} {count}" for reason, count in found.items())


def added(several: Iterable[Mapping[str, int]]) -> dict[str, int]:
    """The sums of the counts of several runs, the most frequent first."""
    total: Counter[str] = Counter()
    for each in several:
        total.update(each)
    return dict(sorted(total.items(), key=lambda item: (-item[1], item[0])))


def in_one_line(name: str) -> str:
    """A name as text without line breaks and other control characters, which are written as in Python."""
    return "".join(repr(each)[1:-1] if category(each) in ("Cc", "Zl", "Zp") else each for each in name)


def number(value: float) -> str:
    """A number, such as a cost, as text."""
    return f"{value:.4g}"


def counted(count: int, what: str) -> str:
    """A count followed by its noun in the singular or plural: `1 call`, `2 calls`."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def duration(seconds: float) -> str:
    """A duration as text: `0.05 ms`, `1.2 s`."""
    return f"{seconds:.3g} s" if seconds >= 0.1 else f"{round(1e3 * seconds, 2):g} ms"  # noqa: PLR2004
