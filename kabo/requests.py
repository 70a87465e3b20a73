"""Solve, verify, explain and check for files: functions from paths and options to answers as data.

The command line and the workers of the service call these functions and so give the same answers. They differ only in how
a request arrives and how its answer is shown.
"""

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from kabo.errors import Diagnostic, InputError, naming
from kabo.given import require_path
from kabo.language import check_files as findings_in
from kabo.language import (
    is_exploration,
    is_imported,
    kind_of_file,
    load_problem,
    load_scene_description,
    own_task_files,
)
from kabo.language.files import geometry_files
from kabo.language.findings import Findings
from kabo.language.problem import Problem
from kabo.options import SolveOptions
from kabo.phases import phase
from kabo.plan import load_plan, load_state, plan_to_json
from kabo.planner.result import Progress, invalid_to_json, result_to_json

if TYPE_CHECKING:  # for the same reason
    from kabo.explain.explain import Explanation
    from kabo.geometry_server import Preparing
    from kabo.scene import Scene
    from kabo.tasks.procedures import GeometricProcedures
    from kabo.verify import Report

_LOG = logging.getLogger("kabo.requests")
MODEL = ".jsonl"  # how models of explorations end


@dataclass(frozen=True)
class SolveAnswer:
    """The answer to `solve`: the object that `--json` prints (without a path), the plan file, the input error."""

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
    on_found: Callable[[Mapping[str, Any], bytes], None] | None = None,
    on_refused: Callable[[Mapping[str, Any]], None] | None = None,
    on_procedures: "Callable[[GeometricProcedures], None] | None" = None,
    start: Path | None = None,
    former: Path | None = None,
) -> SolveAnswer:
    """Solves the problem in a file; for bad input the answer has the status "invalid".

    Args:
        path: the problem file.
        options: the caller's options; absent options and None are taken from the problem and the scene.
        domain: the problem's domain file, for formats in which the problem does not name it.
        workers: the number of processes that the planner may use; it does not change the answer.
        within: if given, no file outside of this folder is opened.
        progress: called periodically with the current progress.
        cancelled: called periodically; if it returns True, planning ends soon, with the plan found so far or with
            the status "exhausted".
        on_found: called with the body of the answer and the plan file once a plan is found, before it is refined and
            certified.
        on_refused: called from time to time with the body of the answer that there would be if planning ended now.
        on_procedures: called with the server of geometric procedures before any call is made, as by `solve`.
        start: the file of the state in which the plan begins; None: where the problem does.
        former: a plan file whose rest is tried first.
    """
    from kabo.planner.memo import Memo
    from kabo.planner.solve import solve  # nobody who only checks or verifies pays for it

    try:
        with phase("reading the problem", log=_LOG):
            problem = read_problem(path, within, domain)
        found = None if on_found is None else lambda each: on_found(result_to_json(each), plan_to_json(each.plan))
        with naming(state=start, plan=former):
            result = solve(
                problem,
                **options,
                start=None if start is None else load_state(start),
                memo=None if former is None else Memo.of_plan(problem, load_plan(former)),
                workers=workers,
                progress=progress,
                cancelled=cancelled,
                on_found=found,
                on_refused=None if on_refused is None else lambda each: on_refused(result_to_json(each)),
                on_procedures=on_procedures,
            )
    except InputError as error:
        return SolveAnswer(invalid_to_json(error), error=error)
    return SolveAnswer(result_to_json(result), None if result.plan is None else plan_to_json(result.plan))


def read_problem(path: Path, within: Path | None = None, domain: Path | None = None) -> Problem:
    """The problem in a file. If `within` is given, no file outside of that folder is opened.

    Raises:
        InputError: the files have errors, all of which are listed, or they name files outside of `within`.
    """
    if within is None:
        return load_problem(path, domain)
    problem = load_problem(path, domain, within=within)
    _refuse_outside(problem, within)
    return problem


def _refuse_outside(problem: Problem, folder: Path) -> None:
    """Checks that a problem's meshes and URDFs lie in a folder, before any of them is opened.

    Raises:
        InputError: names the first one outside.
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
    start: Path | None = None,
    scene: "Scene | None" = None,
) -> "Report":
    """Verifies the plan in a file for the problem in a file; if `paranoid`, its certificate in exact arithmetic.

    `start` is the file of the state in which the plan is to begin, if it does not begin where the problem does;
    `scene` is the problem's, for whoever goes on with it: its files are not read again.

    For a scene file the plan is one of a task, as `kabo task export` writes it: its motion is judged, not its purpose.

    Raises:
        InputError: the problem's files, or the form of the plan, have errors; all of them are listed.
        OSError: the plan file cannot be read.
    """
    from kabo.verify import verify_plan  # nobody who only checks or solves pays for it

    with phase("reading the problem", log=_LOG):
        alone = domain is None and not is_imported(problem) and kind_of_file(problem) == "scene"
        read = load_scene_description(problem) if alone else load_problem(problem, domain)
    with phase("reading the plan", log=_LOG):
        judged = load_plan(plan)
    begins = None if start is None else load_state(start)
    with naming(plan=plan, state=start):
        return verify_plan(
            read, judged, knowledge_only=knowledge_only, paranoid=paranoid, start=begins, scene=scene
        )


def verify_task_report(
    scene: Path, report: Path, solution: int | None = None, *, paranoid: bool = False
) -> "Iterator[tuple[int, Report]]":
    """Verifies the solutions in a task's report, or one of them, in a scene: the number of each, and what was found.

    Raises:
        InputError: the report, the scene or a motion has errors, or there is no such solution.
        OSError: the report cannot be read.
    """
    from kabo.task_plans import plans_of_report, require_consistent  # as above
    from kabo.verify import verify_plan

    for number, plan, found, motion in plans_of_report(report, scene, solution, certificate=paranoid):
        judged = verify_plan(found, plan, paranoid=paranoid, changes=motion["changes"])
        if judged.ok:  # what is verified are the segments; programs may carry out the changes
            require_consistent(motion, number)
        yield number, judged


def explain_file(
    path: Path,
    *,
    domain: Path | None = None,
    geometry: bool = True,
    timeout: float | None = None,
    cancelled: Callable[[], bool] | None = None,
    progress: Callable[[Progress], None] | None = None,
    known: "Callable[[Explanation], None]" = lambda _: None,
    **options: Any,
) -> "tuple[Explanation, InputError | None]":
    """Explains why the problem in a file has no plan; returns the explanation and the input error, or None.

    Args:
        path: the problem file.
        domain: the problem's domain file, where formats have one that the problem does not name.
        geometry: whether to look for motions, too.
        timeout: the time limit, including the reading of files [s]; None for no limit.
        cancelled: called periodically; if it returns True, the explanation ends soon with the results so far.
        progress: called periodically with the progress of solving the problem.
        known: called with the explanation as far as it is known, whenever more is known.
        options: further options of `kabo.explain`.
    """
    from kabo.explain.explain import explain, invalid_explanation  # as the planner

    began = perf_counter()
    try:
        with phase("reading the problem", log=_LOG):
            problem = load_problem(path, domain)
        left = None if timeout is None else max(0.0, timeout - (perf_counter() - began))
        return explain(
            problem,
            geometry=geometry,
            timeout=left,
            cancelled=cancelled,
            progress=progress,
            known=known,
            **options,
        ), None
    except InputError as error:
        return invalid_explanation(error), error


def check(*files: str | Path) -> list[Diagnostic]:
    """What is wrong in files of any kind, as `kabo check` says it: errors and warnings, sorted by place.

    A scene without errors is loaded with its meshes and URDFs, which takes longer when a robot is new.

    Args:
        files: domains, problems, scenes, tasks, explorations or models.

    Raises:
        ArgumentError: one is no path.

    Example:
        >>> kabo.check("domains/grid/n3.yaml")
        []
    """
    return check_files([require_path("file", file) for file in files])


def check_files(paths: Iterable[Path], preparing: "Callable[[Preparing], None] | None" = None) -> list[Diagnostic]:
    """All findings in files of any kind. Scenes without errors are loaded with their meshes and URDFs.

    Of an exploration that plans a task, the beginning of a trial is planned. Models are known by their ending, `.jsonl`.
    `preparing` is told while the geometry of scenes is prepared.
    """
    given = list(paths)
    named = [path for path in given if path.suffix.lower() != MODEL]
    found = list(findings_in(named))
    for path in given:
        if path.suffix.lower() == MODEL:
            found += _model_findings(path)
    faulty = {finding.file for finding in found if finding.severity == "error"}
    with phase("checking", len(named) if len(named) > 1 else None, "files", log=_LOG) as step:
        for path in named:
            if str(path) not in faulty and not is_imported(path):
                found += _geometry_findings(path, preparing)
                found += _stage_findings(path)
                found += _trial_findings(path)
            step()
    return sorted(set(found), key=lambda finding: (finding.file, finding.line, finding.column, finding.message))


def _model_findings(path: Path) -> tuple[Diagnostic, ...]:
    """What is wrong with the model of an exploration."""
    from kabo.exploration import load_exploration  # most files are none

    try:
        load_exploration(path)
    except InputError as error:
        return error.diagnostics
    return ()


def _stage_findings(path: Path) -> tuple[Diagnostic, ...]:
    """The findings in stages and values of a task file, or of the task files that a domain or problem may call."""
    called = own_task_files(path)
    if not called:
        return ()
    from kabo.tasks.files import find_task_file  # most problems call no task file

    findings = Findings()
    for name in called:
        find_task_file(Path(name), name, findings)
    return tuple(findings.diagnostics)


def _trial_findings(path: Path) -> tuple[Diagnostic, ...]:
    """The findings in the task, the scene and the values that the trials of an exploration file plan with."""
    if not is_exploration(path):
        return ()
    from kabo.trials import load_exploration_file, trial_findings  # few files are explorations

    return trial_findings(load_exploration_file(path))


def _geometry_findings(path: Path, preparing: "Callable[[Preparing], None] | None") -> tuple[Diagnostic, ...]:
    """The findings in meshes, URDFs and SRDFs of a scene, or of a problem's scene, and in where its things stand."""
    try:
        description = load_scene_description(path, whole=False)
    except InputError:  # a domain, a task, a problem without a scene, or errors that have been found already
        return ()
    from kabo.scene.findings import findings_in_scene  # files without a scene are checked without mesh libraries

    found = findings_in_scene(description)
    if any(finding.severity == "error" for finding in found):
        return found
    from kabo.geometry_server import robot_findings, start_findings  # as above

    found = (*found, *robot_findings(description))
    if any(finding.severity == "error" for finding in found):
        return found
    return (*found, *start_findings(description, preparing=preparing))
