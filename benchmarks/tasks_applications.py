"""The applications of the thesis as the benchmarks plan them: their files, scenes, and a run with its times."""

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from kabo.language import load_scene_description
from kabo.language.recorded_paths import installed_folder
from kabo.scene import Scene, load_scene
from kabo.tasks import Task, load_task_file
from kabo.tasks.files.first_scenes import first_scene

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


@dataclass(frozen=True)
class Application:
    """A task file with a scene."""

    name: str
    task: Path
    scene: Scene

    def start(self, seed: int, **arguments: Any) -> tuple[Task, Any]:
        """A new task and its first scene, about which nothing is known yet."""
        return load_task_file(self.task).task(arguments, seed=seed), first_scene(self.scene, seed, lambda: False)


def applications(name: str, robots: list[str], public: str, generated: str = "scene.yaml") -> list[Application]:
    """An example on the generated robot and on the public one, as far as these are asked for and there.

    Args:
        name: the example's folder.
        robots: `generated`, `public`.
        public, generated: the files of the scenes with the public robot and with the generated one.
    """
    chosen = []
    for kind, file in (("generated", generated), ("public", public)):
        if kind not in robots:
            continue
        if kind == "public" and installed_folder("example-robot-data") is None:
            print("The public robots come with the extra `robots`: pip install 'kabo[robots]'")
            continue
        path = EXAMPLES / name / file
        chosen.append(
            Application(path.stem, EXAMPLES / name / "task.yaml", load_scene(load_scene_description(path)))
        )
    return chosen


class Clock:
    """Seconds since it was made, by the wall and of the processor."""

    def __init__(self) -> None:
        self.wall, self.processor = perf_counter(), process_time()

    def passed(self) -> tuple[float, float]:
        """Both, until now."""
        return perf_counter() - self.wall, process_time() - self.processor
