"""Plans the task of a file, once or with several seeds; a report can be made of these planning runs [T 3.9]."""

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import TYPE_CHECKING, Any

from kabo.errors import CutOff, InputError, did_you_mean
from kabo.given import require_number
from kabo.language.findings import Findings
from kabo.language.scene_description import SceneDescription
from kabo.options import require_clearance, require_seed, require_workers
from kabo.phases import phase
from kabo.tasks.core import InitialisationError, Solution, Stage, Task
from kabo.tasks.files.building import TaskFile
from kabo.tasks.files.motions import motion_of
from kabo.tasks.files.report_form import MAX_REPORTED, MotionReport, Report

if TYPE_CHECKING:
    from kabo.geometry_server import Preparing
    from kabo.scene import Scene  # loads meshes, which tasks without robots do not need

_LOG = logging.getLogger("kabo.tasks")
Stop = Callable[[], bool]
_STAGES = ("kabo.tasks.robots.", "kabo.tasks.learned.")  # whose errors are about what a file says


@dataclass(frozen=True)
class TaskRun:
    """One planning run: the task with its results, and the time and cost of each solution when it was found."""

    task: Task
    seed: int
    seconds: float
    found: tuple[tuple[float, float], ...] = ()  # (seconds, cost)
    stopped: bool = False  # by a time limit or by the caller
    left_out: tuple[str, ...] = ()  # why solutions at hand do not hold any more
    motions: tuple[MotionReport | None, ...] = ()  # of the first solutions, as a report tells them


@dataclass(frozen=True)
class KnownSolutions:
    """Solutions at hand: the report that has them, and the scene in which they were found."""

    report: Report
    scene: "Scene"


@dataclass(frozen=True)
class PlanningOptions:
    """Planning options: `repeat` runs with seeds from `seed` on, each until `max_solutions` or `timeout` [s] is reached.

    Raises:
        ArgumentError: one is no such number.
    """

    max_solutions: int | None = None
    timeout: float | None = None
    seed: int = 0
    repeat: int = 1
    workers: int | None = None
    known: "KnownSolutions | None" = None  # solutions at hand, which are tried first
    clearance: float = 0.0  # [m]: what bodies keep from each other, beside what the scene says is uncertain
    stop: Stop = field(default=lambda: False, compare=False)
    preparing: "Callable[[Preparing], None] | None" = field(
        default=None, compare=False
    )  # told of prepared geometry

    def __post_init__(self) -> None:
        if self.max_solutions is not None:
            require_number("max_solutions", self.max_solutions, 1, whole=True)
        if self.timeout is not None:
            require_number("timeout", self.timeout, 0.0, endless=True, unit="s")
        if self.workers is not None:
            require_workers(self.workers)
        require_number("repeat", self.repeat, 1, whole=True)
        require_seed(self.seed)
        require_clearance(self.clearance)


def plan_file(
    file: TaskFile,
    arguments: Mapping[str, Any],
    scene: "Scene | None" = None,
    settings: PlanningOptions | None = None,
) -> list[TaskRun]:
    """The planning runs of a file's task with given arguments, in a scene if the task has robot stages.

    Raises:
        InputError: the arguments are wrong, or the stages do not fit together; lists the places in the file. Or meshes
            of the scene cannot be enclosed.
        CutOff: the caller stopped the run while the scene was prepared.
    """
    settings = PlanningOptions() if settings is None else settings
    if scene is not None:
        # Loads kernels, as in `_run`.
        from kabo.tasks.files.first_scenes import prepare_geometry

        prepare_geometry(scene, settings.stop, settings.preparing, settings.workers)
    runs: list[TaskRun] = []
    for seed in range(settings.seed, settings.seed + settings.repeat):
        if runs and settings.stop():
            break
        runs.append(_run(file, file.task(arguments, seed=seed), scene, seed, settings))
    return runs


def plan_built(task: Task, scene: "Scene | None", settings: PlanningOptions) -> TaskRun:
    """The planning run of a task that was built in Python, with the seed of the task.

    Raises:
        InitialisationError: the stages do not fit together, or the scene lacks what they name.
        InputError: meshes of the scene cannot be enclosed.
    """
    if scene is not None:
        from kabo.tasks.files.first_scenes import prepare_geometry  # as in `plan_file`

        prepare_geometry(scene, settings.stop, settings.preparing, settings.workers)
    return _run(None, task, scene, task.seed, settings)


def _run(
    file: TaskFile | None, task: Task, scene: "Scene | None", seed: int, settings: PlanningOptions
) -> TaskRun:
    began = perf_counter()

    def late() -> bool:
        return settings.stop() or (settings.timeout is not None and perf_counter() - began >= settings.timeout)

    first: Any = None
    found: list[tuple[float, float]] = []
    motions: list[MotionReport | None] = []
    left_out: list[str] = []
    if scene is not None:
        # Loads the geometry server with its kernels, which tasks without robots do not need.
        from kabo.tasks.files.first_scenes import check_against_scene, first_scene

        first = first_scene(scene, seed, late, settings.clearance)
    try:
        if scene is not None:
            check_against_scene(task, first)
        if settings.known is not None and scene is not None:
            from kabo.tasks.files.replaying import adopted  # as above

            known = settings.known
            left_out += adopted(task, known.report, known.scene, first, settings.max_solutions)
            found += [(perf_counter() - began, each.cost) for each in task.solutions]
            _add_motions(motions, task.solutions, scene, late)
        with phase("planning", settings.max_solutions, "solutions", log=_LOG) as step:
            while settings.max_solutions is None or len(found) < settings.max_solutions:
                try:
                    solutions = task.plan(first, len(found) + 1, stop=late, workers=settings.workers)
                except CutOff:
                    solutions = task.solutions
                new = solutions[len(found) :]
                found += [(perf_counter() - began, each.cost) for each in new]
                if not new:
                    break
                step()
                _add_motions(motions, solutions, scene, late)
    except (InitialisationError, ValueError) as error:
        told = None if file is None else located_at_stage(file, task, error)
        if told is None:
            raise
        raise told from error
    finally:
        task.close()
    seconds = perf_counter() - began
    return TaskRun(task, seed, seconds, tuple(found), late(), tuple(left_out), tuple(motions))


def _add_motions(
    motions: list[MotionReport | None], solutions: Sequence[Solution], scene: "Scene | None", late: Stop
) -> None:
    """Adds the motions of solutions that have none yet, of as many as a report tells, until it is late.

    Timing a hundred motions takes seconds. Done here it counts as planning, which a time limit ends; after planning a
    command would be ended by force before it has written what it found.
    """
    while scene is not None and len(motions) < min(len(solutions), MAX_REPORTED) and not late():
        motions.append(motion_of(solutions[len(motions)], scene))


def located_at_stage(file: TaskFile, task: Task, error: InitialisationError | ValueError) -> InputError | None:
    """A planning error, located in the file at the stage that it concerns; None if it concerns no single stage."""
    if isinstance(error, InitialisationError):
        return file.located(error)
    stage = _failing_stage(error)
    return None if stage is None else file.located(InitialisationError([f"{stage.path!r}: {error}"], task.tree()))


def _failing_stage(error: Exception) -> Stage | None:
    """The stage of kabo whose function raised the error: the innermost one in the traceback."""
    found, here = None, error.__traceback__
    while here is not None:
        stage = here.tb_frame.f_locals.get("self")
        if isinstance(stage, Stage) and type(stage).__module__.startswith(_STAGES):
            found = stage
        here = here.tb_next
    return found


def needs_scene(file: TaskFile | Task) -> bool:
    """Whether a task has robot stages, which need a scene."""
    if isinstance(file, Task):
        return any(base.__name__ == "RobotStage" for stage in file.walk() for base in type(stage).__mro__)
    waiting = [file.recipe]
    while waiting:
        recipe = waiting.pop()
        if any(base.__name__ == "RobotStage" for base in recipe.kind.__mro__):
            return True
        waiting.extend(recipe.children)
    return False


def check_things(file: TaskFile, arguments: Mapping[str, Any], scene: "SceneDescription | Scene") -> None:
    """Checks that the scene has the robots, bodies and regions given as arguments.

    Raises:
        InputError: lists the names that the scene lacks, with similar names that it has.
    """
    things: dict[str, Mapping[str, object]]
    things = {"robot": scene.robots, "body": scene.bodies, "region": scene.regions}
    findings = Findings()
    findings.know(file.description.source)
    for each in file.inputs:
        known, value = things.get(each.kind or ""), arguments.get(each.name)
        if known is not None and value is not None and not (isinstance(value, str) and value in known):
            hint = did_you_mean(str(value), known) or f"there are {', '.join(known) or 'none'}"
            findings.add(
                each.place,
                f'"{each.name}" is {value if value != "" else "empty"}, which is no {each.kind} of the scene',
                hint,
            )
    if findings.errors:
        raise InputError(findings.diagnostics)
