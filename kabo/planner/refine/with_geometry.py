"""The steps of a run that need a scene: loads geometry before the rounds, refines and certifies a plan after them.

This module and its imports load the kernels, so `solve` imports it only for problems with a scene.
"""

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from time import perf_counter

import numpy as np

from kabo.errors import Diagnostic, InputError
from kabo.geometry_server import (
    GeometryServer,
    Measure,
    Situation,
    Stream,
    moved_base,
    prepare,
    shortfall_of,
    start_faults,
    start_faults_so_far,
    workspace_of,
)
from kabo.geometry_server.answers import Refusal
from kabo.language.formulas import GroundCall
from kabo.plan import Plan, State, StateChange
from kabo.plan.writing import rounded_state
from kabo.planner.certify.certifying import UNFINISHED, certified
from kabo.planner.certify.granting import granted
from kabo.planner.geometry.assembly import assemble, files_read
from kabo.planner.geometry.eager import EagerGeometry
from kabo.planner.geometry.evaluation import Variant
from kabo.planner.geometry.refusals import RefusalTable
from kabo.planner.geometry.relations import require_explained
from kabo.planner.refine.refining import FoundMotion, refine
from kabo.planner.result import Result
from kabo.planner.run import SolveRun, statistics_of
from kabo.scene import KeptScenes, Scene, beginning_at
from kabo.tasks.procedures import GeometricProcedures

_SCENES = KeptScenes()
MAX_BASES = 4  # calls out of reach of which it is told where the base would do; each takes about half a second


def load_procedures(run: SolveRun) -> GeometricProcedures:
    """The server for the procedures in the problem's scene, whose parts are prepared.

    The run then also stops when its samples are spent.

    Raises:
        CutOff: time or memory was spent before the scene was loaded and prepared.
        InputError: the scene does not load, or has meshes that cannot be enclosed; or steps were done, and the state in
            which the plan begins does not say where they have left everything.
    """
    began = perf_counter()
    if run.problem.scene is None:
        raise ValueError("only a problem with a scene has geometry")
    if run.start is not None and run.start.done and run.start.geometry is None:
        text = "the state says what was done, and not where robots and objects are: it has no geometry"
        remedy = "plan and carry out with geometry; or solve with geometry none"
        raise InputError([Diagnostic("state", 1, 1, text, remedy)])
    memo = run.memo
    known = None if memo is None else memo.scene
    loaded, notes = _SCENES.scene(run.problem.scene, run.stop.look) if known is None else (known, set[Hashable]())
    begun = None if run.start is None else run.start.geometry
    scene = loaded if begun is None else beginning_at(loaded, rounded_state(begun))
    if run.start is not None and begun is not None:
        _require_explained(run, loaded, run.start, rounded_state(begun))
    exact = run.options.geometry == "exact"
    server = GeometryServer(scene, run.options.epsilon, run.options.seed, exact, clearance=run.options.clearance)
    run.stop.samples = lambda: server.statistics.samples > run.options.max_samples
    server.stop = run.stop
    processes = run.workers if run.workers > 1 else None
    tolerance = server.surroundings.enclosures.tolerance
    if known is None and tolerance not in notes:
        prepare(server.surroundings.enclosures, processes=processes, told=run.report_preparing)
        notes.add(tolerance)
    for line in (*_blocked_starts(server), *_faults_of_a_state(run, server)):
        run.report_line("looking at the start", line)
    run.load_s = perf_counter() - began
    domain = run.problem.domain.path
    procedures = GeometricProcedures(server, None if domain is None else domain.parent)
    if memo is not None:
        memo.scene = loaded
    run.counts = lambda: (sum(procedures.statistics.calls.values()), server.statistics.samples)
    return procedures


def _require_explained(run: SolveRun, scene: Scene, start: State, begun: StateChange) -> None:
    """Checks that bodies are where the former plan, if there is one, has left them, or that events say otherwise.

    Raises:
        InputError: what is known of a body comes from actions, and it is not where these have left it.
    """
    memo = run.memo
    foreseen = None if memo is None else memo.foreseen(start)
    if foreseen is not None:
        require_explained(run.problem, scene, foreseen[0], begun, foreseen[1])
    elif memo is not None and (why := memo.not_compared()) is not None:
        text = f"warning: {why}: whether things are where it left them is not known"
        run.report_line("looking at the start", text)


def _blocked_starts(server: GeometryServer) -> Iterator[str]:
    """A warning for each robot that cannot begin a motion: where it stands it is not apart from what nobody moves."""
    start = Situation.of(server.scene.start)
    graspable = {name for name, body in server.scene.bodies.items() if body.grasps}
    for robot in server.scene.robots.values():
        q = np.array(start.configuration(robot.name))
        hit = workspace_of(server.surroundings, robot.name, start).first_hit(q) if robot.planned else None
        if hit is not None and not any(name in graspable for name in hit):
            yield (
                f"warning: {robot.name} cannot move from where it stands: {hit[0]} and {hit[1]} are not proven apart; "
                "`kabo check` says how near they are, and what would help"
            )


def _faults_of_a_state(run: SolveRun, server: GeometryServer) -> Iterator[str]:
    """A warning for each thing that cannot be as the state of a run has it; of a scene's own start `kabo check` tells."""
    if run.start is not None and run.start.geometry is not None and run.progress is not None:
        yield from (f"warning: {fault.said}" for fault in start_faults(server.surroundings, parts=False))


def finished(run: SolveRun, variants: tuple[Variant, ...], server: GeometricProcedures) -> Result:
    """The result with the plan of a complete evaluation, refined and certified if the options ask for that.

    If refining or certifying is still to be done, `run.on_found` is first called with the plan as it was found; and
    `run.on_first`, as soon as the root's motion is as it will be.
    """
    plan, first = None, None if run.on_first is None else partial(_told_first, run, variants, server)
    found = FoundMotion(variants, server, None if run.options.quality == "good" else first)
    if run.on_found is not None and (run.options.quality == "good" or run.certifies):
        plan = _assembled(run, variants, server)
        run.on_found(Result("solved", _uncertified(run, plan), statistics_of(run, server)))
    if run.options.quality == "good":
        run.report_progress("refining")
        run.refined, plan = refine(found, server).written(), None
        if first is not None:
            first()
        if server.stop():
            run.note_cut("refining", "some of its motion is as it was found")
    if plan is None:
        plan = _assembled(run, variants, server)
    plan = _certified(run, plan, server)
    if run.memo is not None:
        run.memo.keep(plan, variants)
    return Result("solved", plan, statistics_of(run, server), None, tuple(run.cut_off))


def unsuccessful_calls(
    geometry: RefusalTable | EagerGeometry, server: GeometricProcedures
) -> list[tuple[GroundCall, Refusal]]:
    """All calls that were refused, each with its first refusal, including refusals that were discarded.

    A refusal is discarded before its call is repeated with more samples, and the run may end before the
    repetition.
    """
    records = server.records
    told = {
        call: each.places[0].refusal for call, each in records.of.items() if each.places and not each.successes
    }
    # What was tried with the greatest effort says more than what was known of the start.
    found = {call: told.get(call, refusal) for call, refusal in geometry.failures()}
    cut = {call: where.refusal for call, where in records.unfinished.items() if call not in records.of}
    return list({**told, **cut, **found}.items())


def with_bases(
    failures: Sequence[tuple[GroundCall, Refusal]], server: GeometricProcedures
) -> list[tuple[GroundCall, Refusal]]:
    """The refused calls; those that are proven out of reach by lengths of links say where the robot's base would do."""
    start, found, asked = Situation.of(server.scene.start), [], 0
    for call, refusal in failures:
        far = refusal.proof and refusal.reason == "out_of_reach" and not refusal.measures
        if far and asked < MAX_BASES:
            asked += 1
            bases = (_base(stream) for stream in server.wanted(call, start))
            nearest = min(filter(None, bases), key=lambda each: each.missing, default=None)
            if nearest is not None:
                said = f"{refusal.comment} by the lengths of its links alone; {nearest.said}"
                refusal = replace(refusal, comment=said, measures=(nearest,))
        found.append((call, refusal))
    return found


def _base(stream: Stream) -> Measure | None:
    """The least level move of a robot's base that brings a stream within reach; None if none was found, or if it drives."""
    short = None if stream.robot.drive is not None else shortfall_of(stream, level=True)
    return None if short is None or not short.metres else moved_base(stream.robot, short.metres, short.by)


def with_start_faults(result: Result, server: GeometricProcedures, *, late: bool) -> Result:
    """The result of a run without a plan, in whose reason stands first what is wrong with the scene at its start.

    `late`: time is spent, so that only what was looked at before is told.
    """
    surroundings = server.server.surroundings
    faults = start_faults_so_far(surroundings) if late else start_faults(surroundings, parts=False)
    if result.reason is None or not faults:
        return result
    details = (*(fault.said for fault in faults), *result.reason.details)
    return replace(result, reason=replace(result.reason, details=details))


def _assembled(run: SolveRun, variants: tuple[Variant, ...], server: GeometricProcedures) -> Plan:
    """The plan as it is written, with what grants its contacts."""
    assert run.problem.scene is not None
    plan = assemble(
        run.problem, variants, server, files_read(run.problem, server), run.options.written(), run.start
    )
    return granted(plan, server.scene)


def _told_first(run: SolveRun, variants: tuple[Variant, ...], server: GeometricProcedures) -> None:
    tell, run.on_first = run.on_first, None  # whoever is told is not kept by the run
    assert tell is not None
    tell(_assembled(run, variants, server), server.server.surroundings)


def _uncertified(run: SolveRun, plan: Plan) -> Plan:
    """The plan as it is before its certificate is made: it says that the certificate is missing, and why."""
    return replace(plan, certificate_gaps=(UNFINISHED,)) if run.certifies else plan


def _certified(run: SolveRun, plan: Plan, server: GeometricProcedures) -> Plan:
    """The plan with its certificate, if the run makes one and there is time; no samples are drawn any more."""
    if not run.certifies:
        return plan
    run.report_progress("certifying", again=False)
    run.stop = server.server.stop = run.stop.timely()
    plan, run.certified = certified(plan, server.server.surroundings, run.stop.look)
    if plan.certificate is None and run.stop.spent is not None:
        run.note_cut("certifying", "the plan has no certificate")
    return plan
