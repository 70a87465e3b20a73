"""Summaries of explorations: of each case the trials, why some were invalid, and how well outcomes are predicted."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from kabo.exploration import Exploration, Trial
from kabo.trials.answers import FORMAT, CaseSummary, OutcomeSummary, Range, Shown

MOST_CASES = 1000  # cases without trials are listed up to so many cases


def summary(exploration: Exploration, model: Path | str) -> Shown:
    """The whole of an exploration and each of its cases, as `kabo explore show --json` prints it.

    Args:
        exploration: what is known.
        model: the file that it was read from, as the answer names it.
    """
    return {
        "format": FORMAT,
        "command": "show",
        "model": str(model),
        "exploration": exploration.name,
        "parameters": ranges(exploration),
        "seed": exploration.seed,
        "trials": len(exploration.trials),
        "valid": sum(trial.valid for trial in exploration.trials),
        "cases": [summary_of_case(exploration, case) for case in shown_cases(exploration)],
    }


def shown_cases(exploration: Exploration) -> Sequence[Mapping[str, str]]:
    """The cases to be listed, in order: all of them, or only those with trials if there are more than 1,000."""
    count = 1
    for values in exploration.space.cases.values():
        count *= len(values)
    if count <= MOST_CASES:
        return exploration.space.all_cases
    tried = {tuple(trial.case.items()): trial.case for trial in exploration.trials}
    return list(tried.values())


def summary_of_case(exploration: Exploration, case: Mapping[str, str]) -> CaseSummary:
    """The trials of one case, counted, with the least and the greatest value of each outcome."""
    trials = exploration.trials_of(case)
    errors = exploration.leave_one_out(case)
    reasons = Counter(reason_of(trial) for trial in trials if not trial.valid)
    return {
        "case": dict(case),
        "trials": len(trials),
        "valid": sum(trial.valid for trial in trials),
        "reasons": dict(sorted(reasons.items(), key=lambda each: (-each[1], each[0]))),
        "alpha": exploration.alpha(case),
        "outcomes": {
            name: _outcome(trials, name, errors.get(name), unit)
            for name, unit in units_of_outcomes(exploration).items()
        },
    }


def reason_of(trial: Trial) -> str:
    """Why a trial is invalid, in a word; `no reason given` if it was told without one."""
    return trial.reason or "no reason given"


def ranges(exploration: Exploration) -> dict[str, Range]:
    """The bounds and the unit of each parameter."""
    space = exploration.space
    return {
        name: {"lower": lower, "upper": upper, "unit": space.units.get(name, "")}
        for name, (lower, upper) in space.parameters.items()
    }


def units_of_outcomes(exploration: Exploration) -> dict[str, str]:
    """The unit of each outcome; an empty text where the exploration gives none."""
    return {name: exploration.units.get(name, "") for name in exploration.outcomes}


def describe(found: Shown) -> str:
    """The summary as text: the counts, and a table of outcomes for each case."""
    return "\n".join(_lines(found))


def describe_case(case: Mapping[str, str]) -> str:
    """A case as text, such as `string = d4, direction = in`; `the only case` if there are no variables."""
    return ", ".join(f"{name} = {value}" for name, value in case.items()) or "the only case"


def counted(count: int, thing: str) -> str:
    """A count with its noun: `1 trial`, `12 trials`."""
    return f"{count} {thing}{'' if count == 1 else 's'}"


def with_unit(value: float, unit: str) -> str:
    """A number with four significant digits and its unit."""
    return f"{value:.4g} {unit}".rstrip()


def _outcome(trials: Sequence[Trial], name: str, error: float | None, unit: str) -> OutcomeSummary:
    values = [float(trial.outcomes[name]) for trial in trials if trial.valid]
    return {
        "lowest": min(values, default=None),
        "highest": max(values, default=None),
        "error": None if error is None else float(error),
        "unit": unit,
    }


def _lines(found: Shown) -> Iterator[str]:
    name = f"{found['exploration']}: " if found["exploration"] else ""
    cases = counted(len(found["cases"]), "case")
    yield f"{name}{counted(found['trials'], 'trial')}, {found['valid']} valid, {cases}, seed {found['seed']}"
    for case in found["cases"]:
        yield ""
        yield from _lines_of_case(case)


def _lines_of_case(found: CaseSummary) -> Iterator[str]:
    trials = counted(found["trials"], "trial")
    share = f", {found['valid']} valid ({found['valid'] / found['trials']:.0%})" if found["trials"] else ""
    yield f"{describe_case(found['case'])}: {trials}{share}, alpha {found['alpha']:.3g}"
    if found["reasons"]:
        yield f"  invalid: {', '.join(f'{count} {reason}' for reason, count in found['reasons'].items())}"
    if found["valid"]:
        rows = [("outcome", "lowest", "highest", "error"), *map(_row, found["outcomes"].items())]
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        for row in rows:
            numbers = (cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))
            yield "  " + "  ".join([row[0].ljust(widths[0]), *numbers])


def _row(item: tuple[str, OutcomeSummary]) -> tuple[str, str, str, str]:
    name, found = item
    lowest, highest, error = (
        "-" if value is None else with_unit(value, found["unit"])
        for value in (found["lowest"], found["highest"], found["error"])
    )
    return name, lowest, highest, error
