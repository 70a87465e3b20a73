"""The scene in which the task of a file begins if it has robot stages, and the check of the task against it."""

from collections.abc import Callable

from kabo.errors import CutOff
from kabo.geometry_server import GeometryServer, Preparing, prepare_scene
from kabo.scene import Scene
from kabo.tasks.core import Task
from kabo.tasks.robots import TaskScene, check_meaning, check_names, refuted_stages


def prepare_geometry(
    scene: Scene, stop: Callable[[], bool], told: Callable[[Preparing], None] | None, processes: int | None = None
) -> None:
    """Makes the convex parts of all links and bodies of a scene, so that stages find them; `told` as in `prepare`.

    Raises:
        InputError: meshes cannot be enclosed.
        CutOff: `stop` returned True.
    """

    def look() -> None:
        if stop():
            raise CutOff

    prepare_scene(scene, processes=processes, look=look, told=told)


def first_scene(scene: Scene, seed: int, stop: Callable[[], bool], clearance: float = 0.0) -> TaskScene:
    """The initial state of a scene, as robot stages see it; bodies keep `clearance` [m], beside what is uncertain."""
    server = GeometryServer(scene, seed=seed, stop=stop, clearance=clearance)
    return TaskScene.of(server.context(), scene.start)


def check_against_scene(task: Task, first: TaskScene) -> None:
    """Checks that the scene has what the stages of a task name, and that their property values make sense in it.

    Stages that are proven to fail in this scene, whatever is sampled, are not planned.

    Raises:
        InitialisationError: lists everything that is wrong.
    """
    scene = first.context.scene
    check_names(task, scene)
    check_meaning(task, scene, first.situation)
    task.refuted = refuted_stages(task, first.context, first.situation)
