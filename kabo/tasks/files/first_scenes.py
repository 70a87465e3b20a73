"""The scene in which the task of a file begins when it has robot stages, and what these stages ask of it."""

from collections.abc import Callable

from kabo.geometry_server import GeometryServer
from kabo.scene import Scene
from kabo.tasks.core import Task
from kabo.tasks.robots import TaskScene, check_meaning, check_names


def first_scene(scene: Scene, seed: int, stop: Callable[[], bool]) -> TaskScene:
    """The first state of a scene file, as robot stages see it."""
    server = GeometryServer(scene, seed=seed, stop=stop)
    return TaskScene.of(server.context(), scene.start)


def check_against_scene(task: Task, first: TaskScene) -> None:
    """Refuses a task whose stages name what the scene lacks, or ask for what means nothing in it.

    Raises:
        InitialisationError: with everything that is wrong.
    """
    scene = first.context.scene
    check_names(task, scene)
    check_meaning(task, scene, first.situation)
