"""The view document of an object of kabo in memory: a scene, problem, plan, report, explanation or mesh."""

from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np

from kabo.explain.explain import Explanation, explanation_to_json
from kabo.geometry import BoundingMesh, Decomposition
from kabo.language.problem import Problem
from kabo.language.scene_description import Shape
from kabo.meshes import Mesh, hull_of
from kabo.plan import Plan
from kabo.planner.result import Result
from kabo.scene import Body, GeometricState, Scene, load_scene
from kabo.tasks import TaskReport
from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.document import ViewDocument
from kabo.viewer.content.explanation_view import explanation_view
from kabo.viewer.content.plan_view import plan_view
from kabo.viewer.content.report_view import report_view
from kabo.viewer.content.scene_view import scene_view

Viewable: TypeAlias = (
    Scene | Problem | Plan | Result | TaskReport | Explanation | BoundingMesh | Decomposition | Mesh
)


def document_of(thing: Viewable, problem: Problem | None = None) -> ViewDocument:
    """The view document of an object.

    Args:
        thing: what is to be seen.
        problem: the problem of a plan, of which the plan knows the name only; results and explanations know theirs.

    Raises:
        InputError: the meshes or URDFs of the scene do not load.
        ValueError: a plan is given without its problem, or there is nothing to show.
    """
    if isinstance(thing, Result):
        if thing.plan is None:
            raise ValueError("there is no plan to show; kabo.explain(problem) says why")
        return _of_plan(thing.plan, problem or thing.problem)
    if isinstance(thing, Plan):
        return _of_plan(thing, problem)
    if isinstance(thing, TaskReport):
        arrays = Arrays()
        shown = None if thing.scene is None else scene_view(thing.scene, arrays)
        report = report_view(thing.content, thing.scene, arrays)
        return ViewDocument(thing.content["task"], "report", shown, report=report, arrays=arrays)
    if isinstance(thing, Explanation):
        return _of_explanation(thing, problem or thing.problem)
    return _of_scene(thing)


def _of_scene(thing: Scene | Problem | BoundingMesh | Decomposition | Mesh) -> ViewDocument:
    arrays = Arrays()
    if isinstance(thing, Problem):
        scene = _scene_of(thing)
        if scene is None:
            raise ValueError(f"the problem {thing.name} has no scene to show; plans of it can be seen")
        return ViewDocument(scene.name, "problem", scene_view(scene, arrays), arrays=arrays)
    scene = thing if isinstance(thing, Scene) else _shelf(thing)
    return ViewDocument(scene.name, "scene", scene_view(scene, arrays), arrays=arrays)


def _of_plan(plan: Plan, problem: Problem | None) -> ViewDocument:
    if problem is None:
        raise ValueError(f"a plan is shown with its problem: kabo.view(plan, problem={plan.problem})")
    arrays, scene = Arrays(), _scene_of(problem)
    shown = None if scene is None else scene_view(scene, arrays)
    return ViewDocument(problem.name, "plan", shown, plan=plan_view(plan, problem, scene, arrays), arrays=arrays)


def _of_explanation(explanation: Explanation, problem: Problem | None) -> ViewDocument:
    arrays, scene = Arrays(), None if problem is None else _scene_of(problem)
    shown = None if scene is None else scene_view(scene, arrays)
    made = explanation_view(explanation_to_json(explanation), scene, arrays)
    title = "explanation" if problem is None else problem.name
    return ViewDocument(title, "explanation", shown, explanation=made, arrays=arrays)


def _scene_of(problem: Problem) -> Scene | None:
    return None if problem.scene is None else load_scene(problem.scene)


def _shelf(thing: BoundingMesh | Decomposition | Mesh) -> Scene:
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
        name = "mesh" if thing.path is None else thing.path.name
        named = [(name, thing)]
    bodies = {each: Body(each, mesh, Shape("mesh", Path(each)), False, {}, {}, {}) for each, mesh in named}
    epsilon = 0.01 if isinstance(thing, Mesh) else thing.epsilon
    poses = {each: np.eye(4) for each in bodies}
    return Scene(name, epsilon, {}, bodies, {}, {}, frozenset(), poses, GeometricState({}, {}), {})
