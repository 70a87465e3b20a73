"""Plans tasks for callers in Python: what `kabo task plan` does, with a report that notebooks show [T 3.9]."""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kabo.displays import counted, display
from kabo.errors import Diagnostic, InputError
from kabo.given import read_file, refuse, require_given, require_output
from kabo.language.formulas import Place
from kabo.tasks.core import Solution, Task
from kabo.tasks.files.building import TaskFile, load_task_file, require_arguments
from kabo.tasks.files.describing import describe_report
from kabo.tasks.files.report_form import Report, read_report, report_bytes
from kabo.tasks.files.reports import report
from kabo.tasks.files.running import (
    KnownSolutions,
    PlanningOptions,
    TaskRun,
    check_things,
    needs_scene,
    plan_built,
    plan_file,
)
from kabo.whole_files import write_atomically

if TYPE_CHECKING:
    from kabo.scene import Scene  # loads meshes, which tasks without robots do not need


@dataclass(frozen=True)
class TaskReport:
    """What planning runs of a task found.

    Attributes:
        content: the report as plain data, in the form `kabo-task/2` (docs/reference/tasks.md).
        runs: the runs, each with its task.
        scene: the scene in which the task was planned; None for a task without robots.
    """

    content: Report
    runs: tuple[TaskRun, ...] = field(default=(), compare=False)
    scene: "Scene | None" = field(default=None, compare=False)

    @property
    def solutions(self) -> list[Solution]:
        """The solutions of all runs, each run's in order of discovery."""
        return [solution for run in self.runs for solution in run.task.solutions]

    def print(self) -> None:
        """Writes the tree of stages with their counts on standard output, as `kabo task plan` does."""
        sys.stdout.write(f"{describe_report(self.content)}\n")

    def save(self, path: str | Path) -> None:
        """Writes the report's file, completely or not at all; `kabo task show` and `kabo view` read it.

        Raises:
            InputError: `path` is no file in a folder that exists.
            OSError: the file cannot be written.
        """
        write_atomically(require_output("path", path), report_bytes(self.content))

    def __repr__(self) -> str:
        return f"<TaskReport {self.content['task']}: {self._found()}>"

    def _repr_html_(self) -> str:
        runs = self.content["runs"]
        figures = {
            "found": self._found(),
            "seconds": ", ".join(f"{run['seconds']:.1f}" for run in runs),
            "arguments": ", ".join(f"{name} {value}" for name, value in self.content["arguments"].items()),
            "why": next((run["explanation"]["text"] for run in runs if run["explanation"] is not None), ""),
        }
        return display(f"Task {self.content['task']}", figures, None if self.scene is None else self)

    def _found(self) -> str:
        runs = self.content["runs"]
        costs = [found["cost"] for run in runs for found in run["found"]]
        best = f", the best costs {min(costs):.3g}" if costs else ""
        many = f" in {counted(len(runs), 'run')}" if len(runs) > 1 else ""
        return f"{counted(len(costs), 'solution')}{many}{best}"


def plan_task(
    file: TaskFile | Task | str | Path,
    scene: "Scene | str | Path | None" = None,
    arguments: Mapping[str, Any] | None = None,
    *,
    max_solutions: int | None = None,
    timeout: float | None = None,
    seed: int = 0,
    repeat: int = 1,
    workers: int | None = None,
    from_: "TaskReport | str | Path | None" = None,
    clearance: float = 0.0,
) -> TaskReport:
    """What planning a task finds: solutions, and the failures of each stage.

    Args:
        file: a task file, its path, or the name of a task of the library (`pick`); or a task that was built in Python.
        scene: the scene, or the path of a scene file or of a problem file with a scene; None for tasks without robots.
        arguments: values by the names of the task's declared properties; of a task built in Python, of any property.
        max_solutions: the number of solutions at which a run ends; None: as the file says, else all are searched.
        timeout: the time after which a run ends [s]; None: as the file says, else there is no limit.
        seed: the seed of all random samples; a task built in Python has its own.
        repeat: the number of runs, with the seeds from `seed` on; 1 of a task built in Python.
        workers: the number of processes; solutions do not depend on it.
        from_: what was found before, perhaps in a scene that has changed since: its solutions are tried first, each piece
            proven anew in `scene`; then planning goes on if more are wanted. A report, or its file.
        clearance: the distance that bodies keep from each other, unless their contact is permitted [m]; what the scene
            says is uncertain is kept besides.

    Raises:
        InputError: the file, the scene or the arguments have errors, all of which are listed.
        ArgumentError: an argument is of a wrong kind, or a number that nothing can be planned with; says what is expected.
        InitialisationError: the stages of a task built in Python do not fit together, or do not fit the scene.

    Example:
        >>> example = "examples/pick_and_place"
        >>> kabo.plan_task(f"{example}/task.yaml", f"{example}/scene.yaml", max_solutions=1)
        <TaskReport pick and place: 1 solution, the best costs ...>
    """
    require_given("file", file, TaskFile, Task, str, Path)
    given = require_arguments(arguments)
    asked = PlanningOptions(max_solutions, timeout, seed, repeat, workers, clearance=clearance)
    before = known_solutions(from_)
    if isinstance(file, str | Path):
        file = load_task_file(file)
    known = _scene(file, scene, given)
    if asked.clearance > 0.0 and known is None:
        refuse("clearance", "without a scene nothing keeps a clearance")
    if isinstance(file, Task):
        for name, value in given.items():
            file.properties.set(name, value)
        options = replace(asked, seed=file.seed, repeat=1, known=before)
        runs, name = [plan_built(file, known, options)], ""
    else:
        limit = file.timeout if timeout is None else timeout
        most = file.max_solutions if max_solutions is None else max_solutions
        options = replace(asked, max_solutions=most, timeout=limit, known=before)
        runs, name = plan_file(file, given, known, options), file.description.source.name
    where = str(scene) if isinstance(scene, str | Path) else None
    made = report(
        runs, file=name or None, arguments=given, scene=known, scene_file=where, clearance=asked.clearance
    )
    return TaskReport(made, tuple(runs), known)


def known_solutions(report: "TaskReport | str | Path | None", scene: Path | None = None) -> KnownSolutions | None:
    """The solutions at hand of a report or of its file, with the scene in which they were found; None of None.

    Args:
        report: what was found.
        scene: the scene of a report's file; None: as it names it, from here or from its own folder.

    Raises:
        InputError: it is neither a report nor a file, the file is no report, or its scene is not there; or the report is of
            a task without robots.
    """
    if report is None:
        return None
    if not isinstance(report, TaskReport | str | Path):
        what = f"solutions at hand are those of a report, not of a {type(report).__name__}"
        raise InputError([Diagnostic("from_", 1, 1, what, "give what kabo.plan_task has returned, or its file")])
    if isinstance(report, TaskReport):
        if report.scene is None:
            refuse("from_", "only motions of robots are tried again, and the report has none")
        return KnownSolutions(report.content, report.scene)
    return KnownSolutions(*load_report(Path(report), scene))


def load_report(path: Path, scene: Path | None = None) -> "tuple[Report, Scene]":
    """The report in a file, and the scene in which its task was planned.

    Args:
        path: the report's file.
        scene: a scene file, or a problem with a scene; None: as the report names it, from here or from its own folder.

    Raises:
        InputError: the report cannot be read, it or the scene has errors, or the scene is not there.
    """
    from kabo.scene import load_scene  # as in `_scene`

    report = read_report(read_file("report", path), str(path))
    named = report.get("scene")
    if scene is None and named is not None:
        near = (Path(named), path.parent / named, path.parent / Path(named).name)
        scene = next((each for each in near if each.is_file()), None)
    if scene is None:
        what = "names no scene" if named is None else f"was planned in {named}, which is not there"
        raise InputError([Diagnostic(str(path), 1, 1, f"this report {what}", "name its scene file")])
    return report, load_scene(scene)


def _scene(
    task: TaskFile | Task, scene: "Scene | str | Path | None", arguments: Mapping[str, Any]
) -> "Scene | None":
    if scene is None:
        if needs_scene(task):
            message = f'the task "{task.name}" moves robots and needs a scene'
            place = Place(task.name, 1, 1) if isinstance(task, Task) else task.recipe.place
            raise InputError(
                [Diagnostic(place.file, place.line, place.column, message, "give `scene`", place.length)]
            )
        return None
    from kabo.scene import Scene, load_scene  # loads meshes, which tasks without robots do not need

    require_given("scene", scene, Scene, str, Path)
    scene = scene if isinstance(scene, Scene) else load_scene(scene)
    if isinstance(task, TaskFile):
        check_things(task, arguments, scene)
    return scene
