"""Why a plan of knowledge has no motions: solves with geometry, looks at what failed, tries what one change would do."""

from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, Literal

from kabo.explain.counterfactuals import MOST, TrialBudget, candidates, tried
from kabo.explain.failed_calls import examined
from kabo.explain.findings import Counterfactual, Finding, Obstacles
from kabo.explain.sentences import main_finding, summary
from kabo.language.problem import Problem
from kabo.planner.result import Result
from kabo.planner.solve import solve
from kabo.tasks.procedures import GeometricProcedures

SAMPLES = 40_000  # of procedures, by default; each change may use a part of as many
KNOWN, OPEN = "There is a plan as far as knowledge goes", "; whether there are motions for it is open"
SOLVING, LOOKING = 0.5, 0.65  # the parts of the time after which solving and looking are cut off


@dataclass
class _Clock:
    """The time for everything; it only cuts off."""

    seconds: float
    cancelled: Callable[[], bool] | None
    began: float = field(default_factory=perf_counter)

    def left(self, share: float = 1.0) -> float:
        """Seconds until a part of the time has passed."""
        return max(0.0, share * self.seconds - (perf_counter() - self.began))

    def stop(self) -> bool:
        """Whether looking is to end."""
        return not self.left(LOOKING) or (self.cancelled is not None and self.cancelled())


def obstacles(
    problem: Problem,
    seconds: float,
    cancelled: Callable[[], bool] | None,
    expansions: int,
    changes: int = MOST,
    **options: Any,
) -> Obstacles:
    """What asking geometry adds to a problem that knowledge can solve.

    Args:
        problem: with a scene.
        seconds: for everything; where that is not enough, there is less to tell.
        cancelled: asked now and then; True ends it soon.
        expansions: nodes that may be expanded; each change may use a part of as many.
        changes: how many are tried at most.
        options: of `solve`.

    Raises:
        InputError: the scene does not load.
    """
    clock = _Clock(seconds, cancelled)
    samples = next(
        n for n in (options.get("max_samples"), problem.options.get("max_samples"), SAMPLES) if n is not None
    )
    options = {**options, "max_samples": samples, "max_expansions": expansions}
    asked: list[GeometricProcedures] = []
    result = solve(
        problem,
        **options,
        timeout=clock.left(SOLVING),
        certificate=False,
        cancelled=cancelled,
        on_procedures=asked.append,
    )
    if result.reason is None:
        return Obstacles("solvable", ("There is a plan, with a motion for every action.",))
    if not asked:  # cut off before any procedure could be asked
        return Obstacles(
            "exhausted", (f"{KNOWN}; whether there are motions for it is open: {result.reason.message}.",)
        )
    findings = examined(asked[0], clock.stop)
    surroundings, used = asked[0].server.surroundings, asked[0].statistics.samples
    others = tried(
        problem,
        surroundings,
        candidates(problem, surroundings, findings, changes),
        TrialBudget(samples, expansions, used, result.statistics["expanded"], clock.left, cancelled),
        **options,
    )
    return _told(result, findings, others, surroundings.budget.epsilon)


def _told(result: Result, findings: list[Finding], others: list[Counterfactual], epsilon: float) -> Obstacles:
    verdict: Literal["proved", "exhausted"] = "proved" if result.status == "no_plan" else "exhausted"
    main, reason = main_finding(findings, others), result.reason
    if main is None or reason is None:
        text = "" if reason is None else f": {reason.message}"
        found = ", but not for geometry" if verdict == "proved" else OPEN
        return Obstacles(verdict, (f"{KNOWN}{found}{text}.",))
    lines = summary(verdict, reason.budget, main, others, epsilon)
    ordered = (main, *(finding for finding in findings if finding is not main))
    return Obstacles(verdict, tuple(lines), ordered, tuple(others))
