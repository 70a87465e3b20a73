"""Checks every motion of a plan in the problem's scene."""

import logging
from collections.abc import Iterator, Sequence
from typing import Any

from kabo.language import Problem, recorded_files
from kabo.phases import phase
from kabo.plan import Plan
from kabo.scene import KeptScenes, Scene, memory_of
from kabo.verify.certificate.check import check_certificate
from kabo.verify.motion.added import AddedBodies, Changes, NoBodyError, configurations, require_known
from kabo.verify.motion.calls import Calls
from kabo.verify.motion.collision import Tally
from kabo.verify.motion.components import Components
from kabo.verify.motion.contacts.granted import unstated
from kabo.verify.motion.motions import check_motion
from kabo.verify.motion.overlaps import Motion, all_meetings, check_overlaps, sharing_time
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.situation import check_start
from kabo.verify.motion.sweep import Proof
from kabo.verify.motion.trajectories.figures import TrajectoryFigures
from kabo.verify.report import Finding
from kabo.verify.scene_alone import SceneAlone

_LOG = logging.getLogger("kabo.verify")
_SCENES = KeptScenes()  # its own: the planner's may be changed by mistakes


def check_geometry(
    problem: Problem,
    plan: Plan,
    order: Sequence[str],
    scene: Scene | None,
    changes: Changes,
    paranoid: bool,
    meshes: bool,
) -> tuple[dict[str, str], list[Finding], dict[str, Any], list[str]]:
    """Checks all motions of a plan, and the plan's certificate (with `paranoid` in exact arithmetic).

    `changes` are those of a task's solution whose motion the plan is: bodies that they add are kept away from, too.
    Without `meshes` bodies are looked at by their meshes only where no certificate has to prove them apart.
    `scene` is the problem's, if it is loaded already.

    Returns:
        the hashes of all files that were read, the findings, the figures for the report, and notes for the report.

    Raises:
        InputError: the scene's meshes or URDFs do not load.
    """
    assert problem.scene is not None
    if plan.start is None:
        text = "the plan has no motions (made with --geometry none?), but there is a scene: use --knowledge-only"
        return dict(problem.files), [Finding(None, text)], {}, []
    scene = scene or _SCENES.scene(problem.scene)[0]
    files = dict(problem.files) | recorded_files(scene.files.items(), problem.path.parent)
    world = SceneModel(scene, {name: body.model for name, body in problem.scene.bodies.items()})
    calls, components = Calls(problem), Components(plan, scene, order)
    certified = not meshes and plan.certificate is not None and plan.certificate.near is not None
    tally = Tally(known=memory_of(scene, Proof), certified=certified)
    anywhere = isinstance(problem, SceneAlone) or plan.done is not None
    findings = [*check_start(components, anywhere=anywhere), *_check_statements(plan, scene)]
    try:
        added = AddedBodies.of(changes, plan.nodes[plan.root].motion) if changes else None
        if added is not None:
            require_known(added, world)
            added.begins_at = configurations(components, plan.root)
    except NoBodyError as error:
        findings.append(Finding(plan.root, str(error)))
    if findings:
        return files, findings, {}, []
    motions, together = 0, sharing_time(plan)
    walked: dict[str, Motion] = {}
    with phase("checking motions", len(order), "nodes", log=_LOG) as step:
        for name in order:
            node = plan.nodes[name]
            if node.action is not None:
                kept = walked if name in together else None
                findings += check_motion(name, node, calls, world, components, tally, kept, added)
                motions += bool(node.motion)
            step()
    early = list(check_overlaps(plan, order, walked, world))
    findings += early
    meetings = [] if early else all_meetings(plan, order, walked)
    wrong, certificate = check_certificate(plan, world, order, tally.stretches, meetings, paranoid=paranoid)
    figures = {"motions": motions, "pairs": tally.pairs, "distances": tally.distances, "least": tally.least}
    proven = {"certificate": certificate, "certificate_gaps": plan.certificate_gaps}
    told = {**figures, **proven, "trajectories": tally.trajectories.report()}
    findings += _untimed(plan, tally.trajectories)
    notes = [*_epsilon(problem, plan), *tally.trajectories.notes(), *calls.notes()]
    if added is not None and added.bodies:
        names = ", ".join(added.names)
        notes.append(
            f"what stages added is not touched either, by the meshes alone, which no certificate proves: {names}"
        )
    return files, [*findings, *wrong], told, notes


def _check_statements(plan: Plan, scene: Scene) -> Iterator[Finding]:
    """A finding if the plan states no grants for its contacts, as plans of older versions of kabo."""
    segments = [segment for node in plan.nodes.values() for segment in node.motion]
    if not any(s.grants for s in segments) and any(unstated(s, scene, frozenset()) for s in segments):
        text = "the plan does not say what grants its contacts (`grants`): it is of an older kabo; make it anew"
        yield Finding(None, text)


def _untimed(plan: Plan, figures: TrajectoryFigures) -> Iterator[Finding]:
    """The findings about segments without a trajectory in a plan in which others have one."""
    if not figures.followed:
        return
    for name, node in plan.nodes.items():
        for i, segment in enumerate(node.motion):
            if segment.trajectory is None:
                yield Finding(
                    name, f"segment {i} has no trajectory, others of the plan have one", segment.times[0]
                )


def _epsilon(problem: Problem, plan: Plan) -> Iterator[str]:
    """A note if the plan was made with another epsilon than its files now say."""
    assert problem.scene is not None
    given = problem.options.get("epsilon")
    made, told = plan.options.get("epsilon"), problem.scene.epsilon if given is None else given
    if isinstance(made, float | int) and made != told:
        yield f"the plan was made with an epsilon of {made:g} m, the files say {told:g} m"
