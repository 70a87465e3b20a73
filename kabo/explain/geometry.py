"""Explains why a symbolic plan has no motions: solves with geometry, examines failed calls, tries single changes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any, Literal

from kabo.errors import InputError
from kabo.explain.counterfactuals import MAX_CHANGES, TrialBudget, candidates, tried
from kabo.explain.failed_calls import examined
from kabo.explain.findings import Counterfactual, Finding, Obstacles
from kabo.explain.sentences import main_finding, summary
from kabo.geometry_server import StartFault, start_faults, start_findings
from kabo.knowledge import ground
from kabo.language.problem import Problem
from kabo.planner.result import Progress, Result
from kabo.planner.solve import solve
from kabo.tasks.procedures import GeometricProcedures

MAX_SAMPLES = 40_000  # samples of procedures, if neither the caller nor the problem says otherwise
KNOWN, OPEN = "There is a plan as far as knowledge goes", "; whether there are motions for it is open"
SOLVING_SHARE = 0.5  # of the time, after which solving is cut off
LOOKING_SHARE = 0.65  # of the time, after which the examination of failed calls is cut off


@dataclass
class _Clock:
    """The time limit of an explanation."""

    seconds: float
    cancelled: Callable[[], bool] | None
    began: float = field(default_factory=perf_counter)

    def left(self, share: float = 1.0) -> float:
        """The seconds until a share of the time has passed."""
        return max(0.0, share * self.seconds - (perf_counter() - self.began))

    def stop(self) -> bool:
        """Whether the examination of failed calls has to end."""
        return not self.left(LOOKING_SHARE) or (self.cancelled is not None and self.cancelled())


def obstacles(
    problem: Problem,
    seconds: float,
    cancelled: Callable[[], bool] | None,
    expansions: int,
    changes: int = MAX_CHANGES,
    progress: Callable[[Progress], None] | None = None,
    **options: Any,
) -> Obstacles:
    """The verdict on whether a problem with a symbolic plan has a plan with motions, and if not, the reasons.

    Args:
        problem: a problem with a scene.
        seconds: the time limit; steps for which no time is left are skipped.
        cancelled: called periodically; True ends the work soon.
        expansions: the greatest number of nodes to expand; each changed problem gets a fraction of this number.
        changes: the greatest number of changes to try.
        progress: called periodically while the problem is solved.
        options: the options of `solve`.

    Raises:
        InputError: the scene does not load.
    """
    clock = _Clock(seconds, cancelled)
    samples = next(
        n for n in (options.get("max_samples"), problem.options.get("max_samples"), MAX_SAMPLES) if n is not None
    )
    options = {**options, "max_samples": samples, "max_expansions": expansions}
    asked: list[GeometricProcedures] = []
    told = _foreseen(problem)
    result = solve(
        problem,
        **options,
        timeout=clock.left(SOLVING_SHARE),
        certificate=False,
        cancelled=cancelled,
        progress=progress,
        on_procedures=asked.append,
    )
    if result.reason is None:
        return Obstacles("solvable", ("There is a plan, with a motion for every action.",), start=told)
    if not asked:  # cut off before any procedure could be asked
        why = "; ".join((result.reason.message, *result.reason.details))
        first = f"{KNOWN}; whether there are motions for it is open: {why}."
        return Obstacles("exhausted", (first, *told[:1]), start=told)
    surroundings, used = asked[0].server.surroundings, asked[0].statistics.samples
    faults = start_faults(surroundings, parts=False)
    findings = examined(asked[0], ground(problem), clock.stop)
    others = tried(
        problem,
        surroundings,
        candidates(problem, surroundings, findings, changes),
        TrialBudget(samples, expansions, used, result.statistics["expanded"], clock.left, cancelled),
        **options,
    )
    found = _summarised(result, findings, others, faults, surroundings.budget.epsilon)
    return (
        replace(found, start=told) if findings else replace(found, start=told, summary=(*found.summary, *told[:1]))
    )


def _foreseen(problem: Problem) -> tuple[str, ...]:
    """What `kabo check` warns about without convex parts, as sentences; nothing if the scene does not load."""
    assert problem.scene is not None
    try:
        return tuple(f"{finding.message}." for finding in start_findings(problem.scene, parts=False))
    except InputError:
        return ()


def _summarised(
    result: Result,
    findings: list[Finding],
    others: list[Counterfactual],
    faults: Sequence[StartFault],
    epsilon: float,
) -> Obstacles:
    verdict: Literal["proved", "exhausted"] = "proved" if result.status == "no_plan" else "exhausted"
    main, reason = main_finding(findings, others), result.reason
    if main is None or reason is None:
        text = "" if reason is None else f": {reason.message}"
        found = ", but not for geometry" if verdict == "proved" else OPEN
        return Obstacles(verdict, (f"{KNOWN}{found}{text}.",))
    lines = summary(verdict, reason.budget, main, others, epsilon)
    blamed = [fault for fault in faults if fault.kind in ("overlap", "inside") and _concerns(fault, main)]
    if blamed:  # whatever was sampled, this came first
        lines[1] = f"{blamed[0].said}."
    ordered = (main, *(finding for finding in findings if finding is not main))
    return Obstacles(verdict, tuple(lines), ordered, tuple(others))


def _concerns(fault: StartFault, finding: Finding) -> bool:
    """Whether a fault at the start is about a thing that a failed call names."""
    return not {str(value) for value in finding.call.arguments}.isdisjoint(fault.things)
