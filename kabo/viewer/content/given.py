"""The view document of a file: of a scene, problem, task, plan, report or explanation."""

import os
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from kabo.errors import Diagnostic, InputError, MeshError
from kabo.language import load_problem, load_scene_description
from kabo.language.problem import Problem
from kabo.language.scene_description import SceneDescription
from kabo.scene import Scene, load_scene
from kabo.task_plans import chosen
from kabo.tasks.files.report_form import read_report
from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.document import Given, View, ViewDocument
from kabo.viewer.content.explanation_view import explanation_view
from kabo.viewer.content.files import GivenFile, given_file, problem_of_plan
from kabo.viewer.content.findings import finding_view, scene_findings
from kabo.viewer.content.meshes import Detail
from kabo.viewer.content.plan.faults import plan_warnings, require_drawable
from kabo.viewer.content.plan.plan_view import plan_view
from kabo.viewer.content.report_view import report_view
from kabo.viewer.content.scene_view import scene_view

if TYPE_CHECKING:
    from kabo.geometry_server import Preparing, SceneEnclosures


@dataclass(frozen=True)
class ViewOptions:
    """What a page needs beside its file, and what it shows.

    `problem` is that of a plan or an explanation, `scene` that of a task or report, `domain` that of a problem in PDDL
    or PKS. With `prepare`, convex parts that stand in no file are made, and `told`.
    """

    problem: Path | None = None
    scene: Path | None = None
    domain: Path | None = None
    detail: Detail = "low"
    prepare: bool = False
    told: "Callable[[Preparing], None] | None" = None
    solution: int | None = None  # of a report: the one that is played; None: the first ones


def document_of_file(path: Path, options: ViewOptions | None = None) -> ViewDocument:
    """The view document of a file of any kind that can be viewed.

    Raises:
        InputError: the file is nothing that can be viewed, or what belongs to it has errors or is missing.
        OSError: a file cannot be opened.
    """
    chosen = options or ViewOptions()
    given = given_file(path)
    if given.kind == "plan":
        return _of_plan(given, chosen)
    if given.kind in ("report", "explanation"):
        return _of_planning(given, chosen)
    return _of_scene(given, chosen)


def _of_scene(given: GivenFile, options: ViewOptions) -> ViewDocument:
    """The document of a scene, of a problem's scene, or of a scene that is given for a task."""
    path, title = given.path, None
    if given.kind == "task":
        if options.scene is None:
            raise InputError(
                [Diagnostic(str(path), 1, 1, "a task has no scene of its own", "name one: --scene FILE")]
            )
        path = options.scene
    if given.kind == "problem":
        problem = load_problem(path, options.domain)
        description, title = problem.scene, problem.name
        if description is None:
            hint = "plans of it can be viewed: kabo view PLAN"
            raise InputError([Diagnostic(str(path), 1, 1, "this problem has no scene to show", hint)])
    else:
        description = load_scene_description(path, whole=False)
    made = document_of_scene(given.kind, dict.fromkeys((given.path, path)), description, options)
    return made if title is None else replace(made, title=title)


def document_of_scene(
    kind: Given, files: Iterable[Path], description: SceneDescription, options: ViewOptions
) -> ViewDocument:
    """The view document of a scene that `files` of some kind describe, with what `kabo check` finds in it.

    Raises:
        InputError: a mesh or a URDF does not load.
    """
    scene, arrays = load_scene(description), Arrays()
    enclosures, missing = enclosures_of(scene, options)
    found = scene_findings(scene, description, files, prepared=not missing)
    shown = {
        **scene_view(scene, arrays, detail=options.detail, enclosures=enclosures),
        "unprepared": list(missing),
    }
    findings = [finding_view(each, scene) for each in found]
    return ViewDocument(description.name, kind, shown, findings, arrays=arrays)


def enclosures_of(scene: Scene, options: ViewOptions) -> "tuple[SceneEnclosures, tuple[str, ...]]":
    """The convex parts of a scene as far as they are there, and the things that have none; they are made if wanted."""
    from kabo.geometry import Budget
    from kabo.geometry_server import SceneEnclosures, prepare, read_prepared

    enclosures = SceneEnclosures(scene, Budget.share(scene.epsilon).geometry)
    if options.prepare:
        with suppress(MeshError):  # which is among the findings
            prepare(enclosures, told=options.told)
    return enclosures, read_prepared(enclosures)


def _scene_view(scene: Scene | None, arrays: Arrays, options: ViewOptions) -> View | None:
    if scene is None:
        return None
    return scene_view(scene, arrays, detail=options.detail, enclosures=enclosures_of(scene, options)[0])


def _of_plan(given: GivenFile, options: ViewOptions) -> ViewDocument:
    from kabo.plan import load_plan

    plan = load_plan(given.path)
    problem = problem_of_plan(plan, given.path, options.problem, options.domain)
    scene, file = _scene_of(problem), str(given.path)
    require_drawable(plan, None, file)
    arrays = Arrays()
    shown = _scene_view(scene, arrays, options)
    made = plan_view(plan, problem, scene, arrays, sweeps=True, file=file)
    return ViewDocument(
        problem.name, "plan", shown, plan_warnings(plan, problem, scene, file), plan=made, arrays=arrays
    )


def _of_planning(given: GivenFile, options: ViewOptions) -> ViewDocument:
    """The document of a task's report, or of an explanation, with its scene where that is found."""
    named = options.scene or options.problem or _beside(given)
    scene = None if named is None else load_scene(load_scene_description(named))
    arrays = Arrays()
    shown = _scene_view(scene, arrays, options)
    found = [] if scene is not None else _no_scene(given)
    try:
        if given.kind == "report":
            report = read_report(given.path.read_bytes(), str(given.path))
            if options.solution is not None:
                chosen(report, options.solution, str(given.path))
            made = report_view(report, scene, options.solution)
            return ViewDocument(report["task"], "report", shown, found, report=made, arrays=arrays)
        explained = explanation_view(given.content, scene)
    except (KeyError, ValueError, TypeError, AttributeError) as error:
        message = f"this {given.kind} is not of {named or 'kabo'}: {error} is not there, or wrong"
        raise InputError([Diagnostic(str(given.path), 1, 1, message, "name its scene: --scene FILE")]) from None
    title = "explanation" if named is None else named.stem
    return ViewDocument(title, "explanation", shown, found, explanation=explained, arrays=arrays)


def _beside(given: GivenFile) -> Path | None:
    """The scene of a report, or the problem of an explanation: by the path in it, from here or from its own folder."""
    name = given.content.get("scene" if given.kind == "report" else "problem")
    if not isinstance(name, str) or not name:
        return None
    near = (Path(name), given.path.parent / name, given.path.parent / Path(name).name)
    return next((path for path in near if os.path.isfile(path)), None)  # noqa: PTH113 - False for any text


def _no_scene(given: GivenFile) -> list[View]:
    """A warning if a report or an explanation names a scene that is not there."""
    kind, option = ("scene", "--scene") if given.kind == "report" else ("problem", "--problem")
    name = given.content.get(kind)
    if not isinstance(name, str) or not name:
        return []
    message = f"the {kind} {name} was not found: no motion and no sample is shown"
    hint = f"kabo view {given.path} {option} FILE"
    place = {"file": str(given.path), "line": 1, "column": 1, "place": None}
    return [{"severity": "warning", "message": message, "hint": hint, **place}]


def _scene_of(problem: Problem) -> Scene | None:
    return None if problem.scene is None else load_scene(problem.scene)
