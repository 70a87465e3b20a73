"""Verifies a plan: its graph, its files, the knowledge on every branch, and every motion."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from kabo.given import refuse, require_all, require_flags, require_given, require_procedures
from kabo.language import Problem
from kabo.language.scene_description import SceneDescription
from kabo.plan import Plan, State, plan_statistics
from kabo.verify.files import check_files
from kabo.verify.knowledge import check_knowledge
from kabo.verify.knowledge.external_procedures import with_functions
from kabo.verify.knowledge.past import begins_elsewhere, told_of_past
from kabo.verify.report import Finding, Report
from kabo.verify.scene_alone import scene_alone
from kabo.verify.structure import check_structure

if TYPE_CHECKING:
    from kabo.scene import Scene  # loads meshes, which plans without motion do not need

WITHOUT_GEOMETRY = "the plan was made with --geometry none: its motions do not exist and were not verified"


def verify_plan(
    problem: "Problem | Scene | SceneDescription",
    plan: Plan,
    *,
    knowledge_only: bool = False,
    procedures: Mapping[str, Callable[..., Any]] | None = None,
    paranoid: bool = False,
    changes: Sequence[Mapping[str, Any]] = (),
    start: State | None = None,
    scene: "Scene | None" = None,
    meshes: bool = True,
) -> Report:
    """Verifies that a plan reaches the goal of a problem on every branch, and that every motion is collision-free.

    Args:
        problem: the problem as its files now are; or a scene, in which the motion of tasks is judged
            (`kabo.task_plan`), not what they are for.
        plan: the plan to judge.
        knowledge_only: whether to leave motions out; the report then says so.
        procedures: functions by the names of external procedures, as for `kabo.solve`.
        paranoid: whether to check the plan's certificate in exact arithmetic, which takes much longer.
        changes: of a task's solution, as its report has them (`motion.changes`): nothing may touch the bodies and the
            padding that its stages add, which plans do not know.
        start: the state of a run in which the plan is to begin; None: where the plan itself says, which the report tells.
        scene: the problem's, loaded before: its files are not read again. For whoever verifies many plans in one scene.
        meshes: whether bodies are proven apart by their meshes, too, and measured, where the plan's certificate proves it;
            without that most plans take half the time. Contacts are always judged by the meshes.

    Raises:
        ArgumentError: an argument is of a wrong kind.
        InputError: the scene's meshes or URDFs do not load, or a procedure's answer is not as the domain declares it.

    Example:
        >>> problem = kabo.load_problem("domains/grid/n3.yaml")
        >>> kabo.verify(problem, kabo.solve(problem).plan)
        <Report verified: 2 outcomes>
    """
    require_all(plan=(plan, Plan), start=(start, State, type(None)), changes=(changes, list, tuple))
    require_all(scene=(scene, "Scene", type(None)))
    require_flags(knowledge_only=knowledge_only, paranoid=paranoid, meshes=meshes)
    problem = _problem(problem, plan)
    if procedures := require_procedures(procedures):
        seed = plan.options.get("seed")
        problem = with_functions(problem, procedures, seed if isinstance(seed, int) else 0)
    order, findings = check_structure(plan)
    findings += begins_elsewhere(plan, start)
    if not order:
        return Report(tuple(findings), knowledge_only=knowledge_only)
    branches = sum(1 for name in order if plan.nodes[name].branches)
    known = check_knowledge(problem, plan, order)
    findings += known.findings
    geometry = problem.scene is not None and not knowledge_only
    notes = [*told_of_past(plan, start), *([] if problem.scene is None or geometry else [_left_out(plan)])]
    figures: dict[str, Any] = {}
    files = dict(problem.files)
    if geometry:
        from kabo.verify.geometry import check_geometry  # pinocchio, coal and scipy: only for plans with motions

        files, more, figures, told = check_geometry(problem, plan, order, scene, changes, paranoid, meshes)
        findings, notes = [*findings, *more], [*notes, *told]
    elif problem.scene is None and (plan.start is not None or any(n.motion for n in plan.nodes.values())):
        findings.append(Finding(None, "the plan has motions, but the problem has no scene"))
    findings = [*check_files(plan, problem.name, problem.path.parent, files), *findings]
    counts = branches, plan_statistics(plan).plan_leaves, known.states, known.worlds, known.why_replay
    return Report(tuple(findings), tuple(notes), knowledge_only, *counts, **figures)


def _problem(given: "Problem | Scene | SceneDescription", plan: Plan) -> Problem:
    if isinstance(given, Problem):
        return given
    scene: object = getattr(given, "description", given)
    if scene is None and given is not None:
        refuse("problem", "the scene was not loaded from a file: give what `kabo.load_scene` returns")
    if not isinstance(scene, SceneDescription):
        require_given("problem", given, Problem)
    assert isinstance(scene, SceneDescription)
    return scene_alone(scene, plan)


verify = verify_plan  # the name in `kabo`


def _left_out(plan: Plan) -> str:
    return WITHOUT_GEOMETRY if plan.start is None else "only the knowledge was verified, no motion"
