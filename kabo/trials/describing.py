"""Explorations as text: counts and, for each case, the reasons of invalid trials and the errors of outcomes."""

from collections.abc import Iterator, Mapping, Sequence

from kabo.exploration import Exploration
from kabo.tasks.files.describing import counted
from kabo.trials.summaries import CaseSummary, OutcomeSummary


def describe_exploration(exploration: Exploration, summaries: Sequence[CaseSummary]) -> str:
    """The whole exploration as text: the counts, and each case that has trials.

    Args:
        exploration: the exploration.
        summaries: those of its cases (`summaries_of`).
    """
    tried = [each for each in summaries if each.trials]
    blocks = [headline(exploration, summaries), *("\n".join(_lines(each)) for each in tried)]
    if len(tried) < len(summaries):
        blocks.append(f"{counted(len(summaries) - len(tried), 'case')} without trials")
    return "\n\n".join(blocks)


def headline(exploration: Exploration, summaries: Sequence[CaseSummary]) -> str:
    """One line of counts, such as `plucks: 120 trials, 84 valid, 2 cases, seed 0`."""
    name = f"{exploration.name}: " if exploration.name else ""
    trials, valid = sum(each.trials for each in summaries), sum(each.valid for each in summaries)
    cases = counted(len(summaries), "case")
    return f"{name}{counted(trials, 'trial')}, {valid} valid, {cases}, seed {exploration.seed}"


def described_case(case: Mapping[str, str]) -> str:
    """A case as text, such as `string d4, direction in`; `the only case` if there are no variables."""
    return ", ".join(f"{name} {value}" for name, value in case.items()) or "the only case"


def described_trials(found: CaseSummary) -> str:
    """The trials of a case as text, such as `60 trials, 42 valid (70 %)`."""
    share = f", {found.valid} valid ({100 * found.valid / found.trials:.0f} %)" if found.trials else ""
    return counted(found.trials, "trial") + share


def described_values(values: Mapping[str, float], units: Mapping[str, str]) -> str:
    """Numbers with their names and units, such as `along 0.012 m, force 12.5 N`."""
    return ", ".join(f"{name} {with_unit(value, units.get(name, ''))}" for name, value in values.items())


def described_reason(reason: str) -> str:
    """A reason as it is shown: `no reason given` if a trial was told without one."""
    return reason or "no reason given"


def with_unit(value: float, unit: str) -> str:
    """A number with four significant digits and its unit."""
    return f"{value:.4g} {unit}".rstrip()


def _lines(found: CaseSummary) -> Iterator[str]:
    yield f"{described_case(found.case)}: {described_trials(found)}, alpha {found.alpha:.3g}"
    if found.reasons:
        told = (f"{count} {described_reason(reason)}" for reason, count in found.reasons.items())
        yield f"  invalid: {', '.join(told)}"
    if found.outcomes:
        rows = [("outcome", "lowest", "highest", "error"), *(_row(*each) for each in found.outcomes.items())]
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        for name, *cells in rows:
            numbers = (cell.rjust(width) for cell, width in zip(cells, widths[1:], strict=True))
            yield "  " + "  ".join([name.ljust(widths[0]), *numbers])


def _row(name: str, found: OutcomeSummary) -> tuple[str, str, str, str]:
    lowest, highest, error = (
        "-" if value is None else with_unit(value, found.unit)
        for value in (found.lowest, found.highest, found.error)
    )
    return name, lowest, highest, error
