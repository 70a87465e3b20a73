"""The integrated planner [K ch. 6]: knowledge proposes a contingent plan, and geometry confirms or refuses it.

until a plan is found, proven impossible, or the budget is spent (`planned`):
    skeleton := a contingent plan on the knowledge level, assuming that all calls not yet refused succeed
    make the procedure calls of the skeleton in order, in every branch
    if all have a motion: return the plan;  else: record the refusals and what they depend on (`rounds.py`)
"""

import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING

from kabo.budgets import default_memory
from kabo.errors import CutOff
from kabo.frozen_gc import frozen_gc
from kabo.given import require_functions, require_given, require_procedures
from kabo.knowledge import GroundedTask, ground, verdict_of
from kabo.language.problem import Problem
from kabo.options import Options, SolveOptions, require_workers, takes_options
from kabo.phases import timed
from kabo.plan import State
from kabo.planner.continuing import knowledge_after
from kabo.planner.geometry.assembly import assemble
from kabo.planner.geometry.external_procedures import ExternalProcedures, refuse_without_motion
from kabo.planner.geometry.workers import ProcedureWorkers
from kabo.planner.memo import Memo
from kabo.planner.proofs.needed_calls import needed_first
from kabo.planner.proofs.reasons import beyond_reasoning, exhausted, no_plan
from kabo.planner.result import Progress, Reason, Result
from kabo.planner.rounds import ExternalRounds, GeometricRounds, Rounds, SymbolicRounds, Variants
from kabo.planner.run import OnFirst, OnProcedures, SolveRun, search_once, statistics_of, without_plan
from kabo.planner.search.skeleton import Exhausted, FoundSkeleton, Unreachable
from kabo.planner.statistics import completed

if TYPE_CHECKING:  # Python 3.11 has it itself, older ones in a package that only type checkers need
    from typing_extensions import Unpack

_LOG = logging.getLogger("kabo.planner")
SHOWN_REFUSALS = 12  # calls that a reason names
SHARE_FOR_REASON, MOST_FOR_REASON_S = 0.1, 2.0  # of the time limit, kept for finding out why there is no plan


@takes_options
@frozen_gc()
def solve(
    problem: Problem,
    *,
    start: State | None = None,
    memo: Memo | None = None,
    workers: int = 1,
    progress: Callable[[Progress], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    procedures: Mapping[str, Callable[..., bool]] | None = None,
    on_procedures: OnProcedures | None = None,
    on_found: Callable[[Result], None] | None = None,
    on_refused: Callable[[Result], None] | None = None,
    on_first: OnFirst | None = None,
    **options: "Unpack[SolveOptions]",
) -> Result:
    """A plan whose leaves all fulfil the goal and whose motions are proven free, or the reason for having none.

    The same problem, options and seed give the same plan for any number of workers. Limits of time and memory, and
    `cancelled`, only end the run early. A plan that was found before is returned; `Result.cut_off` says what it
    lacks.

    Args:
        problem: the problem to solve.
        start: the state of a run in which the plan begins (`kabo.after`); None: where the problem begins.
        memo: of former solves of the problem, which make this one faster, and for later ones; without effect if functions
            answer for procedures. With it, the plan may be another one, as the former plan's continuation is tried first.
        workers: the number of processes that compute answers of geometric procedures; 1 means this process alone.
        progress: called periodically with the current progress.
        cancelled: called periodically; True stops the run.
        procedures: functions by procedure name, for external procedures that the domain declares, or in place of
            geometric ones. Each is called with the arguments (names of objects and numbers), and with `seed` if it
            has such a parameter. It returns True for success, or its value (None if there is none). Equal
            arguments must have equal answers. Tests and external calls without a function always succeed.
        on_procedures: called with the server of geometric procedures before any call is made; the server keeps the
            outcome of each call.
        on_found: called with the first result that has a plan, if this plan is still to be refined or certified.
        on_first: called once, with the plan and the scene's convex parts, as soon as the motion of its first node is final;
            other motions may have no times yet, and there is no certificate. Not called without a scene, or where `memo`
            has foreseen `start`.
        on_refused: called from time to time with a result without a plan: what was refused so far.
        options: `kabo.options.SolveOptions`; options that are None or absent are taken from the
            problem, the scene or the defaults.

    Raises:
        ArgumentError: an argument is of a wrong kind, or an option takes no such value; says what is expected.
        InputError: the problem uses what the planner does not support, its scene does not load, a procedure's
            answer is not as the domain declares it, or `start` is no state of the problem.

    Example:
        >>> result = kabo.solve(kabo.load_problem("domains/grid/n3.yaml"), seed=1)
        >>> result
        <Result solved: 11 nodes, 2 outcomes, 9 actions at most>
        >>> result.statistics["plan_leaves"]
        2
    """
    require_given("problem", problem, Problem)
    if start is not None:
        require_given("start", start, State)
    if memo is not None:
        require_given("memo", memo, Memo)
    workers = require_workers(workers)
    require_procedures(procedures)
    require_functions(progress=progress, cancelled=cancelled, on_found=on_found, on_refused=on_refused)
    require_functions(on_procedures=on_procedures, on_first=on_first)
    scene = problem.scene
    found: SolveOptions = {"memory": default_memory(), "epsilon": None if scene is None else scene.epsilon}
    chosen = Options.of(options, problem.options, found)
    external = ExternalProcedures(problem, procedures or {}, chosen.geometry_order, chosen.seed)
    has_geometry = scene is not None and chosen.geometry != "none" and not _replace_geometry(procedures, problem)
    if has_geometry:
        refuse_without_motion(problem)
    else:
        chosen = replace(chosen, geometry="none")
    run = SolveRun(external.answering() if procedures else problem, chosen, progress, cancelled, workers)
    run.on_procedures, run.on_found, run.on_refused, run.on_first = on_procedures, on_found, on_refused, on_first
    run.start = start
    if memo is not None and not procedures:
        memo.begin(problem, chosen)
        run.memo = memo
    rest = None if run.memo is None or start is None else run.memo.rest(start)
    if run.memo is not None:
        run.memo.continued = rest is not None
    if rest is not None:
        return Result("solved", rest, statistics_of(run), problem=problem)
    run.report_progress("grounding", again=False)
    with timed("grounding", _LOG):
        task = _task(run)
    run.symbolic_s = perf_counter() - run.began - external.seconds
    if has_geometry:
        result = _with_geometry(run, task)
    elif procedures is not None:
        return replace(_with_external(run, task, external), problem=problem)
    else:
        result = _symbolic(run, task)
    return replace(_with_figures(result, external) if procedures else result, problem=problem)


def _task(run: SolveRun) -> GroundedTask:
    """The grounded problem, with the knowledge of the state in which the plan is to begin."""
    memo, start = run.memo, run.start
    happened = start is not None and any(step.action in run.problem.domain.events for step in start.done)
    if happened:
        task = ground(run.problem.with_events())
    else:
        task = memo.task if memo is not None and memo.task is not None else ground(run.problem)
        if memo is not None:
            memo.task = task
    if start is None:
        return task
    task = replace(task, initial=knowledge_after(task, start.done))
    if happened:  # what happens, nobody plans; events come last, so that the others keep their numbers
        planned = tuple(action for action in task.actions if action.name not in run.problem.domain.events)
        task = replace(task, actions=planned)
    return task


def planned(run: SolveRun, task: GroundedTask, rounds: Rounds) -> Variants | Unreachable | Exhausted:
    """The variants of a skeleton whose calls all succeed; or the proof that there is none; or the spent budget."""
    known = None if run.memo is None or run.start is None else run.memo.skeleton(run.start)
    try:
        variants = None if known is None else rounds.evaluated(known)
        if variants is not None and run.memo is not None:
            run.memo.continued = True
            return variants
        while True:
            rounds.prepare()
            found = search_once(run, task, rounds.geometry)
            variants = rounds.evaluated(found.skeleton) if isinstance(found, FoundSkeleton) else None
            if variants is not None:
                return variants
            ending = rounds.ending(found)
            if ending is not None:
                return ending
    except CutOff:
        return Exhausted(run.searched, run.stop.spent or "time")


# ------------------------------------------------------------------------------------ with a scene's geometry
def _with_geometry(run: SolveRun, task: GroundedTask) -> Result:
    # Loads kernels for most of a second, which a problem without a scene never needs.
    from kabo.planner.geometry.clearance_alone import with_clearance
    from kabo.planner.geometry.epsilon_alone import with_epsilon
    from kabo.planner.refine.with_geometry import (
        finished,
        load_procedures,
        unsuccessful_calls,
        with_bases,
        with_start_faults,
    )
    from kabo.planner.telling import Telling, refused_so_far

    run.report_progress("loading the scene", again=False)
    try:
        with timed("loading the scene", _LOG):
            server = load_procedures(run)
    except CutOff as error:
        spent = Exhausted(run.searched, run.stop.spent or "time")
        result = without_plan(run, task, spent, statistics_of(run))
        return replace(result, reason=None if result.reason is None else result.reason.with_details(error.details))
    run.refusals = lambda: refused_so_far(server)
    if run.on_procedures is not None:
        run.on_procedures(server)
    run.stop.reserve = min(SHARE_FOR_REASON * run.stop.seconds, MOST_FOR_REASON_S)
    run.stop.cancelled = Telling(run, task, server, lambda result: with_start_faults(result, server, late=True))
    with ProcedureWorkers(server, run.workers, run.stop) as workers:
        rounds = GeometricRounds(run, task, server, workers.expect)
        found = planned(run, task, rounds)
        if isinstance(found, tuple):
            run.stop.reserve = 0.0
            return finished(run, found, server)
        geometry = rounds.geometry
        cut_off = isinstance(found, Exhausted)
        failures = unsuccessful_calls(geometry, server) if cut_off else geometry.failures()
        late = run.stop.spent == "time"
        failures = needed_first(task, failures)
        if not late:
            failures = with_bases(failures, server)
        for explained in (with_clearance, with_epsilon):  # in the reserve, if the time is spent
            failures = explained(failures, server, run.stop.timely())
        result = without_plan(run, task, found, statistics_of(run, server), failures, proved=geometry.proved())
        return with_start_faults(result, server, late=late)


# ------------------------------------------------------------------------------------------ without a scene's
def _symbolic(run: SolveRun, task: GroundedTask) -> Result:
    found = planned(run, task, SymbolicRounds(run))
    statistics = statistics_of(run)
    return _solved(run, found) if isinstance(found, tuple) else without_plan(run, task, found, statistics)


def _with_external(run: SolveRun, task: GroundedTask, external: ExternalProcedures) -> Result:
    """The result of planning until all external procedures along a plan succeed."""
    found = planned(run, task, ExternalRounds(run, task, external))
    statistics = completed(statistics_of(run) | external.figures())
    if isinstance(found, tuple):
        return replace(_solved(run, found), statistics=statistics)
    if isinstance(found, Exhausted):
        return Result("exhausted", None, statistics, exhausted(found.budget, []))
    refused = tuple(f"refused: {call}" for call in external.failed())
    shown = refused[:SHOWN_REFUSALS]
    unproved = beyond_reasoning(verdict_of(run.problem))
    if unproved is not None:
        return Result("exhausted", None, statistics, replace(unproved, details=(*unproved.details, *shown)))
    if not refused:
        return Result("no_plan", None, statistics, no_plan(run.problem, task, [], run.stop, begun=run.start))
    text = f"no plan reaches the goal without one of {len(refused)} calls that their procedures refused"
    return Result("no_plan", None, statistics, Reason("refusals", None, text, shown))


def _solved(run: SolveRun, variants: Variants) -> Result:
    """The result with a plan that has no motions."""
    plan = assemble(run.problem, variants, None, run.problem.files, run.options.written(), run.start)
    if run.memo is not None:
        run.memo.keep(plan, variants)
    return Result("solved", plan, statistics_of(run))


def _replace_geometry(procedures: Mapping[str, Callable[..., bool]] | None, problem: Problem) -> bool:
    """Whether the given functions stand for procedures of geometry: not all of them are declared as external."""
    return procedures is not None and not (procedures and problem.domain.procedures.keys() >= procedures.keys())


def _with_figures(result: Result, external: ExternalProcedures) -> Result:
    """The result with the calls of external procedures among its statistics."""
    rows = {**external.figures()["procedures"], **result.statistics["procedures"]}
    return replace(result, statistics=completed({**result.statistics, "procedures": rows}))
