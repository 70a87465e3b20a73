"""Explains why a task has no solution: the first stage without successes, and the reasons of its failures [T 3.1]."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from kabo.tasks.core.model.circles import circle
from kabo.tasks.core.model.containers import Alternatives, Container, Fallbacks
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.results import StructuralReason
from kabo.tasks.core.model.solutions import Solution
from kabo.tasks.core.model.stages import Monitor, Stage
from kabo.tasks.core.run.nodes import StageStatistics


@dataclass(frozen=True)
class Explanation:
    """The first stage, in order of time, that was run without success (None if there is none), and a sentence about it.

    `failures` and `mismatches` count by reason, the most frequent first; `examples` are the stage's first failures.
    """

    stage: Stage | None
    text: str
    failures: Mapping[str, int] = field(default_factory=dict)
    mismatches: Mapping[str, int] = field(default_factory=dict)
    examples: tuple[Solution, ...] = ()


def explain(
    task: Container,
    flows: Mapping[Stage, Flow],
    statistics: Mapping[Stage, StageStatistics],
    kept: Mapping[Stage, list[Solution]],
) -> Explanation:
    """The explanation why a run found no solution, from the flow, the figures and the kept failures of each stage."""
    found = _blamed(task, statistics)
    if not found:
        return Explanation(None, _unasked(task, flows, statistics))
    mine = statistics[found[0]]
    text = "; ".join(_text(stage, _counts(statistics[stage].failures), statistics[stage]) for stage in found)
    return Explanation(
        found[0], text, _counts(mine.failures), _counts(mine.mismatches), tuple(kept[found[0]][:10])
    )


def _blamed(stage: Stage, statistics: Mapping[Stage, StageStatistics]) -> list[Stage]:
    """The first stage inside that was run without success; of alternatives and fallbacks, one in every child."""
    mine = statistics[stage]
    if mine.successes:
        return []
    inside = [found for child in stage.children if (found := _blamed(child, statistics))]
    if inside:
        every = isinstance(stage, (Alternatives, Fallbacks))
        return [one for found in inside for one in found] if every else inside[0]
    asked = bool(mine.calls or mine.mismatches or mine.failures)
    children_succeeded = bool(stage.children) and all(statistics[child].successes for child in stage.children)
    return [stage] if asked or children_succeeded else []


def _counts(counted: Mapping[str, int]) -> dict[str, int]:
    """The reasons, the most frequent first; those that lie in the order of the stages before all others."""
    return dict(
        sorted(counted.items(), key=lambda item: (not isinstance(item[0], StructuralReason), -item[1], item[0]))
    )


def _unasked(task: Container, flows: Mapping[Stage, Flow], statistics: Mapping[Stage, StageStatistics]) -> str:
    waiting = [s for s in task.walk() if not s.children and not statistics[s].successes]
    if statistics[task].successes or not waiting:
        return "no stage failed"
    planned = flows.keys() == set(task.walk())  # which stages may have left since, or come
    if planned and (around := circle(task, flows)) is not None:
        return around
    stage = waiting[0]
    why = f": {stage.monitored.path!r}, which it monitors, found nothing" if isinstance(stage, Monitor) else ""
    return f"{stage.path!r} was never asked{why}"


def _text(stage: Stage, failures: Mapping[str, int], figures: StageStatistics) -> str:
    parts = []
    if failures:
        parts.append("failed: " + ", ".join(f"{reason} {count}" for reason, count in failures.items()))
    if figures.mismatches:
        counts = ", ".join(f"{reason} {count}" for reason, count in _counts(figures.mismatches).items())
        parts.append(f"pairs that never fit: {counts}")
    if not parts:
        parts.append(
            "what its stages found never came together" if stage.children else "it gave no answers at all"
        )
    return f"{stage.path!r} found nothing; " + "; ".join(parts)
