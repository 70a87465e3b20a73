"""Every motion of a plan in its scene."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from kabo.language import Problem
from kabo.plan import Plan
from kabo.scene import load_scene
from kabo.verify.calls import Calls
from kabo.verify.certificate import check_certificate
from kabo.verify.collision import Tally
from kabo.verify.components import Components
from kabo.verify.motions import check_motion
from kabo.verify.overlaps import Motion, all_meetings, check_overlaps, sharing_time
from kabo.verify.report import Finding
from kabo.verify.situation import check_start
from kabo.verify.world import World


def check_geometry(
    problem: Problem, plan: Plan, order: Sequence[str], *, paranoid: bool = False
) -> tuple[dict[str, str], list[Finding], dict[str, Any], list[str]]:
    """All files that were read with their hashes, what is wrong with the motions, the report's figures, and notes.

    With `paranoid` the certificate is checked in exact arithmetic.

    Raises:
        InputError: the scene's meshes or URDFs do not load.
    """
    assert problem.scene is not None
    if plan.start is None:
        text = "the plan has no motions (made with --geometry none?), but there is a scene: use --knowledge-only"
        return dict(problem.files), [Finding(None, text)], {}, []
    scene = load_scene(problem.scene)
    files = dict(problem.files) | relative(scene.files.items(), problem.path.parent)
    world = World(scene, {name: body.model for name, body in problem.scene.bodies.items()})
    calls, components, tally = Calls(problem), Components(plan, scene, order), Tally()
    findings = list(check_start(components))
    if findings:
        return files, findings, {}, []
    motions, together = 0, sharing_time(plan)
    walked: dict[str, Motion] = {}
    for name in order:
        node = plan.nodes[name]
        if node.action is not None:
            kept = walked if name in together else None
            findings += check_motion(name, node, calls, world, components, tally, kept)
            motions += bool(node.motion)
    early = list(check_overlaps(plan, order, walked, world))
    findings += early
    meetings = [] if early else all_meetings(plan, order, walked)
    wrong, certificate = check_certificate(plan, world, order, tally.courses, meetings, paranoid=paranoid)
    figures = {"motions": motions, "pairs": tally.pairs, "distances": tally.distances, "least": tally.least}
    return files, [*findings, *wrong], {**figures, "certificate": certificate}, calls.notes()


def relative(files: Iterable[tuple[Path, str]], folder: Path) -> dict[str, str]:
    """Files by their path relative to a folder, with forward slashes, as plans record them."""
    start = folder.resolve()
    return {Path(os.path.relpath(Path(path).resolve(), start)).as_posix(): digest for path, digest in files}
