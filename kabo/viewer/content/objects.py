"""The view document of an object of kabo in memory: a scene, problem, plan, report, explanation or mesh."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias, get_args

import numpy as np

from kabo.explain.explain import Explanation, explanation_to_json
from kabo.geometry import BoundingMesh, Decomposition
from kabo.given import refuse, require_given
from kabo.language.problem import Problem
from kabo.language.scene_description import Shape
from kabo.meshes import Mesh, hull_of
from kabo.plan import Plan
from kabo.planner.result import Result
from kabo.scene import Body, GeometricState, Scene, attachment, load_scene
from kabo.tasks import TaskReport
from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.document import View, ViewDocument
from kabo.viewer.content.explanation_view import explanation_view
from kabo.viewer.content.given import ViewOptions, document_of_scene, enclosures_of
from kabo.viewer.content.plan.plan_view import plan_view
from kabo.viewer.content.report_view import report_view
from kabo.viewer.content.scene_view import scene_view

Viewable: TypeAlias = (
    Scene | Problem | Plan | Result | TaskReport | Explanation | BoundingMesh | Decomposition | Mesh
)


def document_of(thing: Viewable, problem: Problem | None = None, *, whole: bool = True) -> ViewDocument:
    """The view document of an object.

    Args:
        thing: what is to be seen.
        problem: the problem of a plan, of which the plan knows the name only; results and explanations know theirs.
        whole: whether to add what takes seconds: what `kabo check` finds in a scene, and the margins of motions.

    Raises:
        InputError: the meshes or URDFs of the scene do not load.
        ArgumentError: there is nothing to show, or it is nothing that can be shown.
    """
    require_given("thing", thing, *get_args(Viewable))
    if isinstance(thing, Result):
        if thing.plan is None:
            refuse("thing", "there is no plan to show; kabo.explain(problem) says why")
        return _of_plan(thing.plan, problem or thing.problem, whole)
    if isinstance(thing, Plan):
        return _of_plan(thing, problem, whole)
    if isinstance(thing, TaskReport):
        shown, arrays = _scene_view(thing.scene)
        report = report_view(thing.content, thing.scene)
        return ViewDocument(thing.content["task"], "report", shown, report=report, arrays=arrays)
    if isinstance(thing, Explanation):
        return _of_explanation(thing, problem or thing.problem)
    if isinstance(thing, Problem):
        return _of_problem(thing, whole)
    if isinstance(thing, Scene):
        shown, arrays = _scene_view(thing)
        return ViewDocument(thing.name, "scene", shown, arrays=arrays)
    alone, arrays = _alone(thing), Arrays()
    return ViewDocument(alone.name, "scene", scene_view(alone, arrays), arrays=arrays)


def _of_problem(problem: Problem, whole: bool) -> ViewDocument:
    if problem.scene is None:
        refuse("thing", f"the problem {problem.name} has no scene to show; plans of it can be seen")
    if whole:
        made = document_of_scene("problem", [problem.path], problem.scene, ViewOptions())
        return replace(made, title=problem.name)
    shown, arrays = _scene_view(load_scene(problem.scene))
    return ViewDocument(problem.name, "problem", shown, arrays=arrays)


def _of_plan(plan: Plan, problem: Problem | None, whole: bool) -> ViewDocument:
    scene = None if problem is None else _scene_of(problem)
    shown, arrays = _scene_view(scene)
    made = plan_view(plan, problem, scene, arrays, margins=whole, sweeps=whole)
    return ViewDocument(plan.problem, "plan", shown, plan=made, arrays=arrays)


def _of_explanation(explanation: Explanation, problem: Problem | None) -> ViewDocument:
    scene = None if problem is None else _scene_of(problem)
    shown, arrays = _scene_view(scene)
    made = explanation_view(explanation_to_json(explanation), scene)
    title = "explanation" if problem is None else problem.path.stem
    return ViewDocument(title, "explanation", shown, explanation=made, arrays=arrays)


def _scene_of(problem: Problem) -> Scene | None:
    return None if problem.scene is None else load_scene(problem.scene)


def _scene_view(scene: Scene | None) -> tuple[View | None, Arrays]:
    """A scene in the view document, with the convex parts that are there already; and its arrays."""
    arrays = Arrays()
    if scene is None:
        return None, arrays
    return scene_view(scene, arrays, enclosures=enclosures_of(scene, ViewOptions())[0]), arrays


def _alone(thing: BoundingMesh | Decomposition | Mesh) -> Scene:
    """A scene that holds nothing but one mesh, or the parts of a decomposition."""
    none = np.zeros((0, 3), dtype=np.int64)
    named: Sequence[tuple[str, Mesh]]
    if isinstance(thing, Decomposition):
        name = "decomposition"
        named = [(f"part {k}", hull_of(Mesh(corners, none))) for k, corners in enumerate(thing.parts)]
    elif isinstance(thing, BoundingMesh):
        name = f"{thing.side} bounding mesh"
        named = [(name, Mesh(thing.vertices, thing.faces))]
    else:
        name = "mesh" if thing.path is None else thing.path.stem
        named = [(name, thing)]
    # As movable bodies, parts have different colours.
    bodies = {each: Body(each, mesh, Shape("mesh", Path(each)), True, {}, {}, {}) for each, mesh in named}
    here = {each: attachment("world", np.eye(4)) for each in bodies}
    epsilon = 0.0 if isinstance(thing, Mesh) else thing.epsilon
    return Scene(name, epsilon, {}, bodies, {}, {}, frozenset(), {}, GeometricState({}, here), {})
