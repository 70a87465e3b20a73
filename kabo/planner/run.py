"""One run of the planner: options, limits and statistics; and the results of runs without a plan."""

import logging
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

from kabo.budgets import StopFlag
from kabo.geometry_server.answers import Refusal
from kabo.knowledge import GroundedTask, verdict_of
from kabo.language.formulas import GroundCall
from kabo.language.problem import Problem
from kabo.options import Options
from kabo.phases import timed
from kabo.plan import Plan, State
from kabo.planner.geometry.procedure_server import ProcedureServer
from kabo.planner.memo import Memo
from kabo.planner.proofs.needed_calls import needed_calls
from kabo.planner.proofs.reasons import beyond_reasoning, exhausted, no_plan
from kabo.planner.proofs.refused_calls import most_refused
from kabo.planner.result import Progress, Result
from kabo.planner.search.contingent import find_skeleton
from kabo.planner.search.packed import PackedTask
from kabo.planner.search.skeleton import (
    Exhausted,
    Geometry,
    SearchLimits,
    SearchResult,
    SearchStatistics,
    Unreachable,
)
from kabo.planner.statistics import Statistics, completed

if (
    TYPE_CHECKING
):  # callers of `solve` are given this class; loading it takes a second, which only a scene is worth
    from kabo.geometry_server import Preparing
    from kabo.geometry_server.surroundings import SceneSurroundings
    from kabo.tasks.procedures import GeometricProcedures


_LOG = logging.getLogger("kabo.planner")
COUNTED_EVERY_S = 1.0  # what was refused most
OnProcedures = Callable[["GeometricProcedures"], None]
OnFirst = Callable[[Plan, "SceneSurroundings"], None]


@dataclass
class SolveRun:
    """One run of the planner: its options, its stop flag, and its statistics so far."""

    problem: Problem
    options: Options
    progress: Callable[[Progress], None] | None
    cancelled: Callable[[], bool] | None
    workers: int = 1
    stop: StopFlag = field(init=False)
    symbolic_s: float = 0.0
    geometric_s: float = 0.0
    load_s: float = 0.0
    searched: SearchStatistics = field(default_factory=SearchStatistics)
    packed: PackedTask | None = None
    refined: Mapping[str, float] = field(default_factory=dict)
    on_procedures: OnProcedures | None = None
    certified: Mapping[str, Any] = field(default_factory=dict)
    counts: Callable[[], tuple[int, int]] | None = None  # of procedure calls and samples, once there are any
    refusals: Callable[[], Sequence[tuple[GroundCall, Refusal]]] | None = None  # of calls that never succeeded
    cut_off: list[str] = field(default_factory=list)  # what a plan that was found lacks, in sentences
    on_found: Callable[[Result], None] | None = None
    on_refused: Callable[[Result], None] | None = None
    on_first: "OnFirst | None" = None
    start: State | None = None  # of a run, in which the plan begins; None: where the problem does
    memo: Memo | None = None  # of former solves, and for later ones

    def __post_init__(self) -> None:
        self.stop = StopFlag(self.options.timeout, self.options.memory, self.cancelled)
        self._process, self._doing, self._expanding = os.getpid(), "reading", 0
        self._refused, self._refused_at = "", self.began

    @property
    def began(self) -> float:
        """The start time of the run on the clock of `perf_counter` [s]."""
        return self.stop.began

    @property
    def certifies(self) -> bool:
        """Whether the run makes a certificate for its plan."""
        return self.options.certificate and self.options.geometry == "bounding"

    def note_cut(self, doing: str, lacks: str) -> None:
        """Records in a sentence that the step `doing` was cut off, why, and what the plan lacks as a result."""
        why = "it was interrupted" if self.stop.interrupted else f"{self.stop.spent} exhausted"
        self.cut_off.append(f"{doing} was cut off ({why}): {lacks}")

    def report_progress(self, doing: str, *, again: bool = True) -> None:
        """Calls `progress`, if it is set, with the present step and the counts so far; `again` from time to time."""
        self._doing = doing
        self._report()
        self.stop.told = self._report if again and self.progress is not None else None

    def note_expanded(self, expanded: int) -> None:
        """Notes the expansions of a search that goes on, which are not yet part of those of the run."""
        self._expanding = expanded

    def _report(self) -> None:
        if (
            self.progress is None or os.getpid() != self._process
        ):  # workers are forked with the flag that calls this
            return
        expanded, options, calls, drawn = self.searched.expanded + self._expanding, self.options, 0, 0
        if self.counts is not None:
            calls, drawn = self.counts()
        spent = max(expanded / max(1, options.max_expansions), drawn / max(1, options.max_samples))
        left = self.stop.seconds_left()
        generated, refused = self.searched.generated, self._most_refused()
        self.progress(
            Progress(self._doing, expanded, generated, calls, spent=spent, seconds_left=left, refused=refused)
        )

    def _most_refused(self) -> str:
        """The call that was refused most, counted anew at most every second: that goes through all refusals."""
        now = perf_counter()
        if self.refusals is not None and now >= self._refused_at + COUNTED_EVERY_S:
            self._refused = most_refused(self.refusals())
            self._refused_at = now
        return self._refused

    def report_line(self, doing: str, line: str) -> None:
        """Calls `progress`, if it is set, with a line that stays."""
        if self.progress is not None:
            self.progress(Progress(doing, line=line))

    def report_preparing(self, state: "Preparing") -> None:
        """Calls `progress`, if it is set, with the state of the preparation of geometry."""
        if self.progress is not None:
            self.progress(Progress(str(state), fraction=state.fraction, line=state.line))


def search_once(run: SolveRun, task: GroundedTask, geometry: Geometry | None) -> SearchResult:
    """The outcome of one search: a skeleton, a proof that there is none, or a spent budget.

    The counts and the time of the search are added to `run`.
    """
    began = perf_counter()
    left = run.options.max_expansions - run.searched.expanded
    most = left if geometry is None else int(min(left, geometry.most_expansions(run.options.search)))
    limits = SearchLimits(most, run.stop, run.note_expanded)
    run.packed = run.packed or PackedTask(task)
    with timed("searching", _LOG):
        found = find_skeleton(
            task,
            search=run.options.search,
            geometry=geometry,
            limits=limits,
            packed=run.packed,
        )
    run.note_expanded(0)
    if isinstance(found, Exhausted) and found.budget != "expansions" and run.stop.spent is not None:
        found = replace(found, budget=run.stop.spent)  # the search knows only that it was to stop
    run.searched += found.statistics
    run.symbolic_s += perf_counter() - began
    return found


def without_plan(
    run: SolveRun,
    task: GroundedTask,
    found: Unreachable | Exhausted,
    statistics: Statistics,
    failures: Sequence[tuple[GroundCall, Refusal]] = (),
    *,
    proved: bool = True,
) -> Result:
    """The result of a run that found no plan, including the reason.

    Args:
        run, task: the run, and the grounded problem for which it searched a plan.
        found: the outcome of the search.
        statistics: the statistics of the run.
        failures: the refused calls, each with one refusal.
        proved: whether all these refusals are proofs.
    """
    if isinstance(found, Exhausted):
        why = "interrupted" if run.stop.interrupted else found.budget
        needed = needed_calls(task, failures) if len(failures) > 1 else frozenset()
        return Result("exhausted", None, statistics, exhausted(found.budget, failures, why, needed))
    unproved = beyond_reasoning(verdict_of(run.problem), failures) if proved else None
    if unproved is not None:
        return Result("exhausted", None, statistics, unproved)
    if proved:
        return Result(
            "no_plan",
            None,
            statistics,
            no_plan(run.problem, task, failures, run.stop, begun=run.start),
        )
    needed = needed_calls(task, failures) if len(failures) > 1 else frozenset()
    return Result("exhausted", None, statistics, exhausted("samples", failures, needed=needed))


def statistics_of(run: SolveRun, server: ProcedureServer | None = None) -> Statistics:
    """The statistics of a run, as part of its result (docs/reference/plans.md#the-result)."""
    figures: dict[str, Any] = {
        "total_s": perf_counter() - run.began,
        "symbolic_s": run.symbolic_s,
        "geometric_s": run.geometric_s,
        "load_s": run.load_s,
        "expanded": run.searched.expanded,
        "generated": run.searched.generated,
    }
    if server is not None:
        counted = server.statistics
        figures |= {
            "inverse_kinematics_calls": counted.inverse_kinematics_calls,
            "inverse_kinematics_s": counted.inverse_kinematics_s,
            "collision_checks": counted.collision_checks,
            "positive_collision_checks": counted.positive_collision_checks,
            "collision_s": counted.collision_s,
            "pair_checks": counted.pair_checks,
            "geometric_states": server.states_met,
            "procedures": counted.procedures,
            **run.certified,
            **run.refined,
        }
    return completed(figures)
