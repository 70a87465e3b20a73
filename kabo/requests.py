"""What solve, verify, explain and check mean for files: paths and options in, answers as data out.

The command line and the workers of the service call these functions, so every door gives the same answer. How a request
arrives, and how its answer is shown, is the door's business.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kabo.errors import Diagnostic, InputError
from kabo.language import check_files as findings_in
from kabo.language import is_imported, load_problem
from kabo.language.files import geometry_files
from kabo.options import SolveOptions
from kabo.planner.result import Progress, invalid_to_json, result_to_json

if TYPE_CHECKING:
    from kabo.explain.explain import Explanation
    from kabo.language.problem import Problem
    from kabo.language.scene_description import SceneDescription
    from kabo.scene import Scene
    from kabo.verify import Report


@dataclass(frozen=True)
class Answer:
    """The answer to `solve`: the object (without the plan's path), the plan file's bytes, what was wrong."""

    body: Mapping[str, Any]
    plan: bytes | None = None
    error: InputError | None = None


def solve_file(
    path: Path,
    options: SolveOptions,
    *,
    domain: Path | None = None,
    workers: int = 1,
    within: Path | None = None,
    progress: Callable[[Progress], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    keep: Callable[[Mapping[str, Any], bytes], None] | None = None,
) -> Answer:
    """Solves the problem in a file; bad input is an answer, too (status "invalid").

    Args:
        path: the problem file.
        options: what the caller says; what is absent or None is left to the problem and the scene.
        domain: the problem's domain file, where formats have one that the problem does not name.
        workers: processes that the planner may use; does not change the answer.
        within: if given, no file outside of this folder is opened.
        progress: called now and then.
        cancelled: asked now and then; True ends planning soon, with status "exhausted", or with the plan that was found.
        keep: given the object and the plan file's bytes once a plan is found, before it is refined and certified.
    """
    from kabo.plan import plan_to_json
    from kabo.planner.solve import solve

    try:
        problem = read_problem(path, within, domain)
        found = None if keep is None else lambda result: keep(result_to_json(result), plan_to_json(result.plan))
        result = solve(problem, **options, workers=workers, progress=progress, cancelled=cancelled, on_found=found)
    except InputError as error:
        return Answer(invalid_to_json(error), error=error)
    return Answer(result_to_json(result), None if result.plan is None else plan_to_json(result.plan))


def read_problem(path: Path, within: Path | None = None, domain: Path | None = None) -> "Problem":
    """The problem in a file, with every file that it names inside the folder `within` (if given).

    Raises:
        InputError: all that is wrong in the files; or the files outside of `within`, none of them opened.
    """
    if within is None:
        return load_problem(path, domain)
    problem = load_problem(path, domain, within=within)
    _refuse_outside(problem, within)
    return problem


def _refuse_outside(problem: "Problem", folder: Path) -> None:
    """Checks, before anything geometric is opened, that a problem's meshes and URDFs lie in a folder.

    Raises:
        InputError: the first that does not.
    """
    if problem.scene is None:
        return
    for path in geometry_files(problem.scene):  # yields a URDF before opening it
        if not path.resolve().is_relative_to(folder.resolve()):
            hint = "a server reads only files that were sent along: use paths relative to the scene"
            raise InputError([Diagnostic(str(problem.scene.path), 1, 1, f'"{path}" may not be read', hint)])


def verify_file(
    problem: Path,
    plan: Path,
    *,
    domain: Path | None = None,
    knowledge_only: bool = False,
    paranoid: bool = False,
) -> "Report":
    """Verifies the plan in a file for the problem in a file; `paranoid`: its certificate in exact arithmetic.

    Raises:
        InputError: all that is wrong in the problem's files, or in the form of the plan.
        OSError: the plan file cannot be read.
    """
    from kabo.plan import load_plan
    from kabo.verify import verify_plan

    return verify_plan(
        load_problem(problem, domain), load_plan(plan), knowledge_only=knowledge_only, paranoid=paranoid
    )


def explain_file(
    path: Path,
    *,
    domain: Path | None = None,
    geometry: bool = True,
    cancelled: Callable[[], bool] | None = None,
    **options: Any,
) -> "tuple[Explanation, InputError | None]":
    """Why the problem in a file has no plan, and what is wrong in its files (None: nothing).

    Args:
        path: the problem file.
        domain: the problem's domain file, where formats have one that the problem does not name.
        geometry: whether to look for motions, too.
        cancelled: asked now and then; True ends it soon, with what was found so far.
        options: of `kabo.explain`.
    """
    from kabo.explain.explain import explain, invalid_explanation

    try:
        return explain(load_problem(path, domain), geometry=geometry, cancelled=cancelled, **options), None
    except InputError as error:
        return invalid_explanation(error), error


def check_files(paths: Iterable[Path]) -> list[Diagnostic]:
    """All findings in files of any kind; scenes without errors are loaded with their meshes and URDFs."""
    named = list(paths)
    found = list(findings_in(named))
    faulty = {finding.file for finding in found if finding.severity == "error"}
    for path in named:
        if str(path) not in faulty and not is_imported(path):
            found += _geometry_findings(path)
            found += _stage_findings(path)
    return sorted(set(found), key=lambda finding: (finding.file, finding.line, finding.column, finding.message))


def _stage_findings(path: Path) -> tuple[Diagnostic, ...]:
    """What is wrong in the task files that a domain or problem may call, or in a task file itself: stages, values."""
    from kabo.language import own_task_files

    called = own_task_files(path)
    if not called:
        return ()
    from kabo.language.findings import Findings
    from kabo.tasks.files import find_task_file

    findings = Findings()
    for name in called:
        find_task_file(Path(name), name, findings)
    return tuple(findings.diagnostics)


def _geometry_findings(path: Path) -> tuple[Diagnostic, ...]:
    from kabo.language import load_scene_description

    try:
        description = load_scene_description(path)
    except InputError:  # a domain, a task, a problem without a scene, or errors that have been found already
        return ()
    from kabo.scene import load_scene

    try:
        scene = load_scene(description)
    except InputError as error:
        return error.diagnostics
    return (*_unit_warnings(scene, description), *_turned_warnings(description))


def _turned_warnings(description: "SceneDescription") -> Iterator[Diagnostic]:
    """Mesh files with components that are inside out, which are turned whenever they are loaded."""
    from kabo.meshes import FORMATS, load_mesh, outwards

    for path in dict.fromkeys(geometry_files(description)):
        if path.suffix.lower().removeprefix(".") in FORMATS:
            done = outwards(load_mesh(path))[1]
            if done is not None:
                fix = "export it with its normals outwards; kabo plans and verifies with the turned mesh"
                yield Diagnostic(str(path), 1, 1, done, fix, severity="warning")


def _unit_warnings(scene: "Scene", description: "SceneDescription") -> tuple[Diagnostic, ...]:
    """Bodies and robots whose meshes are so large that they may be given in millimetres."""
    from kabo.meshes import units_warning

    found = [
        units_warning(body.mesh, description.bodies[name].shape.place)
        for name, body in scene.bodies.items()
        if body.mesh.path is not None
    ]
    found += [
        units_warning(
            link.mesh,
            description.robots[name].place,
            named=f'link "{link_name}" of robot "{name}"',
            fix='then scale it in the URDF: <mesh scale="0.001 0.001 0.001" …/>',
        )
        for name, robot in scene.robots.items()
        for link_name, link in robot.links.items()
        if link.mesh is not None
    ]
    return tuple(warning for warning in found if warning is not None)
