"""The integrated planner [K ch. 6]: knowledge proposes a contingent plan, geometry proves or refuses it.

until a plan is found, proven impossible, or the budget is spent:
    skeleton := a contingent plan on the knowledge level, taking every procedure as possible that is not refused
    ask the procedures along it, in order, wherever its branches lead
    if all have a motion: the plan;  else: note the refusals and what they rest on (`rounds.py`)
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

from kabo.budgets import default_memory
from kabo.errors import CutOff
from kabo.frozen_gc import older_objects_apart
from kabo.knowledge import Task, ground, verdict_of
from kabo.language.problem import Problem
from kabo.options import Options, SolveOptions, takes_options
from kabo.plan import Plan
from kabo.planner.geometry.external_procedures import Procedures, refuse_without_motion
from kabo.planner.proofs.reasons import beyond_reasoning, exhausted, no_plan
from kabo.planner.result import Progress, Reason, Result
from kabo.planner.run import Run, search_once, statistics_of, without_plan
from kabo.planner.search.skeleton import Exhausted, Found, Unreachable

if TYPE_CHECKING:  # the geometry is imported where a scene needs it: symbolic problems never pay for it
    from typing_extensions import Unpack  # Python 3.11 has it itself

    from kabo.tasks.procedures import GeometricProcedures


@takes_options
@older_objects_apart()
def solve(
    problem: Problem,
    *,
    workers: int = 1,
    progress: Callable[[Progress], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    procedures: Mapping[str, Callable[..., bool]] | None = None,
    witness: "Callable[[GeometricProcedures], None] | None" = None,
    on_found: Callable[[Result], None] | None = None,
    **options: "Unpack[SolveOptions]",
) -> Result:
    """A branched plan in which every leaf fulfils the goal and every motion is proven free, or why there is none.

    The same problem, options and seed give the same plan for any number of workers. Time, memory and whoever cancels
    only cut off. A plan that was found by then is kept: what it lacks for that stands in `Result.cut_off`.

    Args:
        problem: what to solve.
        workers: processes that ask procedures of geometry; one: this one does.
        progress: told now and then what is done.
        cancelled: asked now and then whether to stop.
        procedures: functions by the names of procedures: of external ones that the domain declares, or of those of
            geometry, which then nobody else is asked for. Called with the arguments (names of objects and numbers),
            and with a `seed` if they take one. They answer true for success, or with their value, None if there is
            none. Equal arguments must have equal answers. Tests and calls without a function always succeed.
        witness: given the procedures of geometry before any is called, to look at what came of them afterwards.
        on_found: given the result as soon as there is a plan, if that is still to be refined or certified.
        options: `kabo.options.SolveOptions`; what is None or absent is left to the problem, the scene or the default.

    Raises:
        InputError: the problem uses what the planner does not support, its scene does not load, or a procedure's
            answer is not as the domain declares it.
    """
    scene = problem.scene
    found: SolveOptions = {"memory": default_memory(), "epsilon": None if scene is None else scene.epsilon}
    chosen = Options.of(options, problem.options, found)
    asked = Procedures(problem, procedures or {}, chosen.geometry_order, chosen.seed)
    replaced = _stands_for_geometry(procedures, problem)
    has_geometry = scene is not None and chosen.geometry != "none" and not replaced
    if not has_geometry:
        chosen = replace(chosen, geometry="none")
    if has_geometry:
        refuse_without_motion(problem)
    asking = asked.answering() if procedures else problem
    run = Run(asking, chosen, progress, cancelled, workers, witness=witness)
    run.on_found = on_found
    task = ground(run.problem)
    run.symbolic_s = perf_counter() - run.began - asked.seconds
    if procedures is not None and not has_geometry:
        return _with_procedures(run, task, asked)
    result = _integrated(run, task) if has_geometry else _symbolic(run, task)
    return _with_figures(result, asked) if procedures else result


def _stands_for_geometry(procedures: Mapping[str, Callable[..., bool]] | None, problem: Problem) -> bool:
    """Whether the given functions answer for procedures of geometry, and not only for external ones."""
    return procedures is not None and not (procedures and problem.domain.procedures.keys() >= procedures.keys())


def _with_figures(result: Result, asked: Procedures) -> Result:
    """The result with what the given functions were asked among its statistics."""
    rows = {**asked.figures()["procedures"], **result.statistics.get("procedures", {})}
    return replace(result, statistics={**result.statistics, "procedures": rows})


def _symbolic(run: Run, task: Task) -> Result:
    from kabo.planner.geometry.assembly import assemble, symbolic_variants
    from kabo.planner.geometry.evaluation import in_order

    run.tell("searching")
    found = search_once(run, task, None)
    if not isinstance(found, Found):
        return without_plan(run, task, found, None)
    variants = symbolic_variants(found.skeleton.root, in_order(found.skeleton.root))
    plan = assemble(run.problem, variants, None, run.problem.files, run.options.written())
    return Result("solved", plan, statistics_of(run, None))


def _with_procedures(run: Run, task: Task, procedures: Procedures) -> Result:
    """Plans until all procedures along one succeed."""
    from kabo.planner.geometry.assembly import assemble, symbolic_variants
    from kabo.planner.geometry.evaluation import in_order

    while True:
        run.tell("asking", sum(counted.calls for counted in procedures.counted.values()))
        procedures.prepare(task)
        asked = procedures.seconds
        found = search_once(run, task, procedures)
        run.symbolic_s -= procedures.seconds - asked
        if not isinstance(found, Found):
            break
        if procedures.follow(found.skeleton):
            variants = symbolic_variants(found.skeleton.root, in_order(found.skeleton.root))
            plan = assemble(run.problem, variants, None, run.problem.files, run.options.written())
            return Result("solved", plan, statistics_of(run, None) | procedures.figures())
        if run.stop():
            break
    statistics = statistics_of(run, None) | procedures.figures()
    told = tuple(f"refused: {call}" for call in procedures.failed())
    unproved = beyond_reasoning(verdict_of(run.problem)) if isinstance(found, Unreachable) else None
    if unproved is not None:
        return Result("exhausted", None, statistics, replace(unproved, details=(*unproved.details, *told[:12])))
    if isinstance(found, Unreachable):
        if not told:
            return Result("no_plan", None, statistics, no_plan(run.problem, task, [], run.stop))
        text = f"no plan reaches the goal without one of {len(told)} calls that their procedures refused"
        return Result("no_plan", None, statistics, Reason("refusals", None, text, told[:12]))
    budget = found.budget if isinstance(found, Exhausted) else run.stop.spent or "time"
    return Result("exhausted", None, statistics, exhausted(budget, []))


def _integrated(run: Run, task: Task) -> Result:
    from kabo.planner.geometry.workers import Workers
    from kabo.planner.rounds import Rounds

    assert run.problem.scene is not None
    run.tell("loading the scene")
    try:
        server = _server(run)
    except CutOff:
        return without_plan(run, task, Exhausted(run.searched, run.stop.spent or "time"), None)
    if run.witness is not None:
        run.witness(server)
    with Workers(server, run.workers, run.stop) as workers:
        rounds = Rounds(run, task, server, workers.expect)
        found = rounds.played()
        if isinstance(found, Unreachable | Exhausted):
            return without_plan(run, task, found, server, rounds.geometry)
        plan = None
        if run.on_found is not None and (run.options.quality == "good" or run.certifies):
            plan = _assembled(run, found, server)
            run.on_found(Result("solved", _uncertified(run, plan), statistics_of(run, server)))
        if run.options.quality == "good":
            run.tell("refining", sum(server.statistics.calls.values()))
            run.refined, plan = _refined(found, server), None
            if server.stop():
                run.note_cut("refining", "some of its motion is as it was found")
        if plan is None:
            plan = _assembled(run, found, server)
        plan = _certified(run, plan, server)
        return Result("solved", plan, statistics_of(run, server), None, tuple(run.cut_off))


def _assembled(run: Run, found: Any, server: "GeometricProcedures") -> Plan:
    """The plan as it is written, with what grants its contacts."""
    from kabo.planner.certify.granting import granted
    from kabo.planner.geometry.assembly import assemble, files_read

    assert run.problem.scene is not None
    plan = assemble(run.problem, found, server, files_read(run.problem, server), run.options.written())
    return granted(plan, server.scene, {name: body.model for name, body in run.problem.scene.bodies.items()})


def _uncertified(run: Run, plan: Plan) -> Plan:
    """The plan as it is if nothing more can be done for it: it says that its certificate is missing, and why."""
    from kabo.planner.certify.certifying import UNFINISHED

    return replace(plan, certificate_gaps=(UNFINISHED,)) if run.certifies else plan


def _certified(run: Run, plan: Plan, server: "GeometricProcedures") -> Plan:
    """The plan with its certificate, if one is asked for and there is time; samples are not drawn any more."""
    if not run.certifies:
        return plan
    from kabo.planner.certify.certifying import certified

    run.tell("certifying", sum(server.statistics.calls.values()))
    run.stop = server.server.stop = run.stop.timely()
    plan, run.certified = certified(plan, server.server.surroundings, run.stop.look)
    if plan.certificate is None and run.stop.spent is not None:
        run.note_cut("certifying", "the plan has no certificate")
    return plan


def _refined(variants: Any, server: "GeometricProcedures") -> Mapping[str, float]:
    from kabo.planner.refine.refining import refine

    return refine(variants, server).written()


def _server(run: Run) -> "GeometricProcedures":
    began = perf_counter()
    from kabo.geometry_server import GeometryServer
    from kabo.scene import load_scene
    from kabo.tasks.procedures import GeometricProcedures

    if run.problem.scene is None:
        raise ValueError("only a problem with a scene has geometry")
    scene = load_scene(run.problem.scene, run.stop.look)
    exact = run.options.geometry == "exact"
    server = GeometryServer(scene, run.options.epsilon, run.options.seed, exact)
    run.stop.samples = lambda: server.statistics.samples > run.options.max_samples
    server.stop = run.stop
    run.load_s = perf_counter() - began
    domain = run.problem.domain.path
    return GeometricProcedures(server, None if domain is None else domain.parent)
