"""The scene in which the task of a file begins if it has robot stages, and the check of the task against it."""

from collections.abc import Callable

from kabo.geometry_server import GeometryServer
from kabo.scene import Scene
from kabo.tasks.core import Task
from kabo.tasks.robots import TaskScene, check_meaning, check_names


def first_scene(scene: Scene, seed: int, stop: Callable[[], bool]) -> TaskScene:
    """The initial state of a scene, as robot stages see it."""
    server = GeometryServer(scene, seed=seed, stop=stop)
    return TaskScene.of(server.context(), scene.start)


def check_against_scene(task: Task, first: TaskScene) -> None:
    """Checks that the scene has what the stages of a task name, and that their property values make sense in it.

    Raises:
        InitialisationError: lists everything that is wrong.
    """
    scene = first.context.scene
    check_names(task, scene)
    check_meaning(task, scene, first.situation)
