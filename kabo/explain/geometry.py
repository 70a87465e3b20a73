"""Explains why a symbolic plan has no motions: solves with geometry, examines failed calls, tries single changes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any, Literal

from kabo.errors import InputError
from kabo.explain.counterfactuals import MAX_CHANGES, TrialBudget, candidates, tried
from kabo.explain.failed_calls import counted_only, examined
from kabo.explain.findings import Change, Counterfactual, Finding, Obstacles
from kabo.explain.sentences import main_finding, not_repeated, not_tried, summary
from kabo.geometry_server import StartFault, start_faults, start_findings
from kabo.knowledge import GroundedTask, ground
from kabo.language.problem import Problem
from kabo.planner.result import Progress, Reason, Result
from kabo.planner.solve import solve
from kabo.tasks.procedures import GeometricProcedures

MAX_SAMPLES = 40_000  # samples of procedures, if neither the caller nor the problem says otherwise
KNOWN, OPEN = "There is a plan as far as knowledge goes", "; whether there are motions for it is open"
SOLVING_SHARE = 0.5  # of the time, after which solving is cut off
LOOKING_SHARE = 0.65  # of the time, after which the examination of failed calls is cut off
LOOKING = "looking for motions"  # what is unfinished as long as the problem is being solved
CUT_OFF = ("so_far", "time", "memory")  # budgets after which more might have been found
TOLD_EVERY_S = 1.0  # while the problem is being solved; for explanations that are killed

Known = Callable[[Obstacles], None]


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
    known: Known = lambda _: None,
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
        known: called with what is known so far, whenever more is known, and from time to time while solving.
        options: the options of `solve`.

    Raises:
        InputError: the scene does not load.
    """
    clock = _Clock(seconds, cancelled)
    samples = next(
        n for n in (options.get("max_samples"), problem.options.get("max_samples"), MAX_SAMPLES) if n is not None
    )
    options = {**options, "max_samples": samples, "max_expansions": expansions}
    task, told = ground(problem), _foreseen(problem)
    first = Obstacles("exhausted", (f"{KNOWN}{OPEN}.", *told[:1]), start=told, unfinished=(LOOKING,))
    known(first)
    solving = _Solving(task, first, cancelled, known)
    result = solve(
        problem,
        **options,
        timeout=clock.left(SOLVING_SHARE),
        certificate=False,
        cancelled=solving.look,
        progress=progress,
        on_procedures=solving.asked.append,
    )
    if result.reason is None:
        return Obstacles("solvable", ("There is a plan, with a motion for every action.",), start=told)
    if not solving.asked:  # cut off before any procedure could be asked
        why = "; ".join((result.reason.message, *result.reason.details))
        return replace(first, summary=(f"{KNOWN}{OPEN}: {why}.", *told[:1]))
    (asked,) = solving.asked
    surroundings, used = asked.server.surroundings, asked.statistics.samples
    if cancelled is not None and cancelled():
        result = replace(result, reason=replace(result.reason, budget="so_far"))
    explained = _Explained(result, start_faults(surroundings, parts=False), surroundings.budget.epsilon, told)
    findings = examined(asked, task, clock.stop, lambda found: known(explained.so_far(found)))
    others, left = tried(
        problem,
        surroundings,
        candidates(problem, surroundings, findings, changes),
        TrialBudget(samples, expansions, used, result.statistics["expanded"], clock.left, cancelled),
        lambda found, left: known(explained.so_far(findings, found, left)),
        **options,
    )
    return explained.so_far(findings, others, left)


@dataclass
class _Solving:
    """The run that looks for motions, which tells from time to time what was refused until then."""

    task: GroundedTask
    first: Obstacles
    cancelled: Callable[[], bool] | None
    known: Known
    asked: list[GeometricProcedures] = field(default_factory=list)
    told_at: float = field(default_factory=perf_counter)

    def look(self) -> bool:
        """Whether the run has to end; called often."""
        if self.asked and perf_counter() > self.told_at + TOLD_EVERY_S:
            self.known(self._so_far(self.asked[0]))
            self.told_at = perf_counter()
        return self.cancelled is not None and self.cancelled()

    def _so_far(self, asked: GeometricProcedures) -> Obstacles:
        findings = counted_only(asked, self.task)
        result = Result("exhausted", None, reason=Reason(None, "so_far", LOOKING))
        faults = start_faults(asked.server.surroundings, parts=False)
        epsilon = asked.server.budget.epsilon
        return _Explained(result, faults, epsilon, self.first.start).so_far(findings) if findings else self.first


@dataclass(frozen=True)
class _Explained:
    """What a run without a plan left: from it and from findings about its failed calls obstacles are made."""

    result: Result
    faults: Sequence[StartFault]
    epsilon: float
    start: tuple[str, ...]

    def so_far(
        self, findings: Sequence[Finding], others: Sequence[Counterfactual] = (), left: Sequence[Change] = ()
    ) -> Obstacles:
        """The obstacles as they are known, with the changes tried so far, and those that are left."""
        found = _summarised(self.result, findings, others, self.faults, self.epsilon)
        lines = found.summary if findings else (*found.summary, *self.start[:1])
        cut_off = self.result.reason is not None and self.result.reason.budget in CUT_OFF
        unfinished = (*((LOOKING,) if cut_off else ()), *not_repeated(findings), *not_tried(left))
        return replace(found, summary=lines, start=self.start, unfinished=unfinished)


def _foreseen(problem: Problem) -> tuple[str, ...]:
    """What `kabo check` warns about without convex parts, as sentences; nothing if the scene does not load."""
    assert problem.scene is not None
    try:
        return tuple(f"{finding.message}." for finding in start_findings(problem.scene, parts=False))
    except InputError:
        return ()


def _summarised(
    result: Result,
    findings: Sequence[Finding],
    others: Sequence[Counterfactual],
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
