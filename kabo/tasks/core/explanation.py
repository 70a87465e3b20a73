"""Why a task has no solution: the first stage without successes, and what it was refused for [T 3.1; research 10]."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from kabo.tasks.core.containers import Container
from kabo.tasks.core.nodes import StageStatistics
from kabo.tasks.core.solutions import Solution
from kabo.tasks.core.stages import Stage


@dataclass(frozen=True)
class Explanation:
    """The first stage, in order of time, that was asked and gave nothing; None if there is none.

    `failures` and `mismatches` count by reason, the most frequent first; `examples` are its first failures.
    """

    stage: Stage | None
    text: str
    failures: Mapping[str, int] = field(default_factory=dict)
    mismatches: Mapping[str, int] = field(default_factory=dict)
    examples: tuple[Solution, ...] = ()


def explain(
    task: Container, statistics: Mapping[Stage, StageStatistics], kept: Mapping[Stage, list[Solution]]
) -> Explanation:
    """The explanation of a run without solutions."""
    leaves = [s for s in task.walk() if s is not task and (not s.children or statistics[s].failures)]
    barren = [s for s in leaves if not statistics[s].successes]
    asked = [s for s in barren if statistics[s].calls or statistics[s].mismatches or statistics[s].failures]
    if statistics[task].failures:
        asked.append(task)
    if not asked:
        text = "no stage failed; the budget was spent" if not barren else f"{barren[0].path!r} was never asked"
        return Explanation(None, text)
    stage = asked[0]
    mine = statistics[stage]
    failures = dict(sorted(mine.failures.items(), key=lambda item: (-item[1], item[0])))
    mismatches = dict(sorted(mine.mismatches.items(), key=lambda item: (-item[1], item[0])))
    return Explanation(stage, _text(stage, failures, mismatches), failures, mismatches, tuple(kept[stage][:10]))


def _text(stage: Stage, failures: Mapping[str, int], mismatches: Mapping[str, int]) -> str:
    parts = []
    if failures:
        parts.append("failed: " + ", ".join(f"{reason} {count}" for reason, count in failures.items()))
    if mismatches:
        counts = ", ".join(f"{reason} {count}" for reason, count in mismatches.items())
        parts.append(f"pairs that never fit: {counts}")
    return f"{stage.path!r} found nothing; " + ("; ".join(parts) or "it gave no answers at all")
