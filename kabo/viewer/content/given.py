"""The view document of a file: of a scene, problem, task, plan, report or explanation."""

from dataclasses import dataclass
from pathlib import Path

from kabo.errors import Diagnostic, InputError
from kabo.language import load_problem, load_scene_description
from kabo.language.problem import Problem
from kabo.language.scene_description import SceneDescription
from kabo.scene import Scene, load_scene
from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.document import ViewDocument
from kabo.viewer.content.explanation_view import explanation_view
from kabo.viewer.content.files import GivenFile, given_file, problem_of_plan
from kabo.viewer.content.plan_view import plan_view
from kabo.viewer.content.report_view import report_view
from kabo.viewer.content.scene_view import scene_view


@dataclass(frozen=True)
class ViewOptions:
    """What a page needs beside its file: the problem of a plan or explanation, the scene of a task or report."""

    problem: Path | None = None
    scene: Path | None = None
    domain: Path | None = None


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
    path = given.path
    if given.kind == "task":
        if options.scene is None:
            raise InputError(
                [Diagnostic(str(path), 1, 1, "a task has no scene of its own", "name one: --scene FILE")]
            )
        path = options.scene
    if given.kind == "problem":
        description = load_problem(path, options.domain).scene
        if description is None:
            hint = "plans of it can be viewed: kabo view PLAN"
            raise InputError([Diagnostic(str(path), 1, 1, "this problem has no scene to show", hint)])
    else:
        description = load_scene_description(path)
    return _with_scene(given, description.name, description, Arrays())


def _with_scene(given: GivenFile, title: str, description: SceneDescription, arrays: Arrays) -> ViewDocument:
    scene = load_scene(description)
    return ViewDocument(title, given.kind, scene_view(scene, arrays), arrays=arrays)


def _of_plan(given: GivenFile, options: ViewOptions) -> ViewDocument:
    from kabo.plan import load_plan

    plan = load_plan(given.path)
    problem = load_problem(options.problem or problem_of_plan(plan, given.path), options.domain)
    scene = _scene_of(problem)
    arrays = Arrays()
    shown = None if scene is None else scene_view(scene, arrays)
    return ViewDocument(problem.name, "plan", shown, plan=plan_view(plan, problem, scene, arrays), arrays=arrays)


def _of_planning(given: GivenFile, options: ViewOptions) -> ViewDocument:
    """The document of a task's report, or of an explanation, with the scene if one is named."""
    named = options.scene or options.problem
    scene = None if named is None else load_scene(load_scene_description(named))
    arrays = Arrays()
    shown = None if scene is None else scene_view(scene, arrays)
    if given.kind == "report":
        made = report_view(given.content, scene, arrays)
        return ViewDocument(
            str(given.content.get("task", given.path.stem)), "report", shown, report=made, arrays=arrays
        )
    made = explanation_view(given.content, scene, arrays)
    return ViewDocument(given.path.stem, "explanation", shown, explanation=made, arrays=arrays)


def _scene_of(problem: Problem) -> Scene | None:
    return None if problem.scene is None else load_scene(problem.scene)
