"""The report of planning runs as plain data: `kabo-task/2`, for `kabo task show`, `kabo task compare` and other programs.

It contains the structure of the task, the figures of each stage, every solution of the task, and the
solutions and failures of every stage with their comments and scene changes. Where robots move, it contains the motion
of every solution, with the changes of its scene as data, and the sample of every failure, too.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from kabo.plan import learned_json
from kabo.tasks.core import (
    Alternatives,
    Fallbacks,
    Flow,
    Monitor,
    Reference,
    Serial,
    Solution,
    Stage,
    Task,
    Wrapper,
    arrows,
)
from kabo.tasks.files.building import TaskFile, default_of
from kabo.tasks.files.changes import scene_change
from kabo.tasks.files.motions import motion_of, sample_of
from kabo.tasks.files.report_form import (
    MAX_REPORTED,
    FailureReport,
    PhaseReport,
    Report,
    RunReport,
    StageFigures,
    StageReport,
    Told,
    Whole,
    Why,
)
from kabo.tasks.files.running import TaskRun
from kabo.tasks.learned import learned_by, learned_in

if TYPE_CHECKING:
    from kabo.geometry_server import ProcedureContext
    from kabo.scene import Scene  # loads meshes, which tasks without robots do not need


def report(
    runs: Sequence[TaskRun],
    *,
    file: str | None = None,
    arguments: Mapping[str, Any] | None = None,
    scene: "Scene | None" = None,
    scene_file: str | None = None,
    clearance: float = 0.0,
) -> Report:
    """The report of one or more planning runs of the same task, in a scene that was read from `scene_file`.

    Bodies kept `clearance` [m] from each other, beside what is uncertain.
    """
    task = runs[0].task
    made: Report = {
        "format": "kabo-task/2",
        "task": task.name,
        "file": file,
        "arguments": {name: plain(value) for name, value in (arguments or {}).items()},
        "stages": stage_reports(task, task.directions),
        "runs": [_run(run, scene) for run in runs],
    }
    if scene_file is not None:
        made["scene"] = scene_file
    if scene is not None and clearance > 0.0:
        made["clearance"] = clearance
    return made


def named_stages(task: Task) -> Iterator[tuple[str, Stage]]:
    """Every stage with a unique path, the task first; the second of two siblings with the same name is called `name#2`."""
    waiting: list[tuple[str, Stage]] = [("", task)]
    while waiting:
        path, stage = waiting.pop()
        yield path or task.name, stage
        counts: dict[str, int] = {}
        inner = []
        for child in stage.children:
            counts[child.name] = counts.get(child.name, 0) + 1
            name = child.name if counts[child.name] == 1 else f"{child.name}#{counts[child.name]}"
            inner.append((f"{path}/{name}" if path else name, child))
        waiting.extend(reversed(inner))


def structure(file: TaskFile, task: Task, flows: Mapping[Stage, Flow]) -> dict[str, Any]:
    """The content of a task file, independent of runs: declared properties, limits, stages with their flows."""
    inputs = [
        {"name": each.name, "type": each.kind, "required": each.required, "default": plain(default_of(each))}
        for each in file.inputs
    ]
    return {
        "task": task.name,
        "file": file.description.source.name,
        "properties": inputs,
        "max_solutions": file.max_solutions,
        "timeout": file.timeout,
        "stages": stage_reports(task, flows),
    }


def stage_reports(task: Task, flows: Mapping[Stage, Flow]) -> list[StageReport]:
    """The structure of a task: its stages with their properties as they were given, the task first."""
    return [_structure(stage, path, flows) for path, stage in named_stages(task)]


def _structure(stage: Stage, path: str, flows: Mapping[Stage, Flow]) -> StageReport:
    flow = flows.get(stage)
    return {
        "path": path,
        "name": stage.name,
        "type": type(stage).__name__,
        "depth": _depth(stage),
        "arrows": arrows(stage) if flow is None else flow.value,
        "monitors": stage.monitored.path if isinstance(stage, Monitor) else None,
        "properties": {name: plain(value) for name, value in stage.properties.given.items()},
    }


def _depth(stage: Stage) -> int:
    depth = 0
    while stage.parent is not None:
        stage, depth = stage.parent, depth + 1
    return depth


def _run(run: TaskRun, scene: "Scene | None") -> RunReport:
    task = run.task
    stages = list(named_stages(task))
    paths = {id(stage): path for path, stage in stages}
    return {
        "seed": run.seed,
        "seconds": run.seconds,
        "exhausted": task.exhausted,
        "stopped": run.stopped,
        "found": [{"seconds": seconds, "cost": cost} for seconds, cost in run.found],
        "solutions": list(_wholes(run, paths, scene)),
        "stages": {path: _stage(task, stage, scene) for path, stage in stages},
        "explanation": None if task.solutions else _why(task, paths),
    }


def _why(task: Task, paths: Mapping[int, str]) -> Why:
    found = task.explain()
    return {
        "text": found.text,
        "stage": None if found.stage is None else paths[id(found.stage)],
        "failures": counted(found.failures),
        "mismatches": dict(found.mismatches),
        "examples": list(dict.fromkeys(_examples(found.examples))),
    }


def _examples(failures: Sequence[Solution]) -> Iterator[str]:
    """What failures say, with the distance or the permission of a contact that is missing, if that alone refuses them."""
    relaxed: dict[int, ProcedureContext] = {}
    for failure in failures:
        if not failure.comment:
            continue
        missing = None
        given = getattr(getattr(failure.details, "question", None), "scene", None)
        if given is not None and given.context.surroundings.keeps:
            # Loads kernels, as a task that moves robots has done.
            from kabo.tasks.robots.motion.kept_distances import missing_distance, nothing_kept

            known = relaxed.setdefault(id(given.context), nothing_kept(given.context))
            missing = missing_distance(failure.details, known)
        yield missing or _permission(failure) or failure.comment


def _permission(failure: Solution) -> str | None:
    if getattr(failure.details, "question", None) is None:
        return None
    from kabo.tasks.robots.motion.missing_permissions import missing_permission  # as above

    return missing_permission(failure.details)


def _stage(task: Task, stage: Stage, scene: "Scene | None") -> StageFigures:
    figures = task.figures(stage)
    solutions, failures = task.found(stage)
    return {
        "calls": figures.calls,
        "seconds": figures.seconds,
        "successes": figures.successes,
        "failures": counted(figures.failures),
        "mismatches": counted(figures.mismatches),
        "costs": [float(cost) for cost in figures.costs],
        "solutions": [_solution(solution) for solution in solutions[:MAX_REPORTED]],
        "refusals": [_failure(failure, scene) for failure in failures[:MAX_REPORTED]],
    }


def _failure(failure: Solution, scene: "Scene | None") -> FailureReport:
    made: FailureReport = {
        "reason": failure.reason,
        "comment": failure.comment,
        "changes": scene_change(failure),
    }
    sample = None if scene is None else sample_of(failure, scene)
    return made if sample is None else {**made, "sample": sample}


def counted(counts: Mapping[str, int]) -> dict[str, int]:
    """The counts by reason, sorted so that the most frequent comes first."""
    return dict(sorted(counts.items(), key=lambda item: (-item[1], item[0])))


def _solution(solution: Solution) -> Told:
    told: Told = {"comment": solution.comment, "cost": float(solution.cost), "changes": scene_change(solution)}
    learned = learned_by(solution)
    if learned is not None:
        told["learned"] = learned_json((learned,))
    return told


def _phase(part: Solution, path: str) -> PhaseReport:
    made: PhaseReport = {"stage": path, **_solution(part)}
    learned = learned_in(part)
    if learned:
        made["learned"] = learned_json(learned)
    return made


def _wholes(run: TaskRun, paths: Mapping[int, str], scene: "Scene | None") -> Iterator[Whole]:
    """The first solutions of a run; of too many, the cheapest stands in the place of the last one."""
    solutions = list(enumerate(run.task.solutions))
    kept = solutions[:MAX_REPORTED]
    best = min(solutions, key=lambda each: each[1].cost, default=None)
    if best is not None and best[0] >= len(kept):
        kept[-1] = best
    for number, solution in kept:
        parts = [_phase(part, paths[id(part.stage)]) for part in phases(solution)]
        made: Whole = {"comment": solution.comment, "cost": float(solution.cost), "parts": parts}
        known = number < len(run.motions)
        motion = run.motions[number] if known else None if scene is None else motion_of(solution, scene)
        yield made if motion is None else {**made, "motion": motion}


def phases(solution: Solution) -> Iterator[Solution]:
    """The phases of a solution in order of time.

    A serial container counts as its children, a wrapper as one phase.
    """
    inner = solution
    while len(inner.parts) == 1 and isinstance(inner.stage, Wrapper | Alternatives | Fallbacks):
        inner = inner.parts[0]
    if inner.parts and isinstance(inner.stage, Serial):
        for part in inner.parts:
            yield from phases(part)
    else:
        yield solution


def plain(value: Any) -> Any:
    """A value converted to types that JSON can represent; other types become text."""
    if isinstance(value, Reference):
        return str(value)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, float):
        return value if math.isfinite(value) else repr(value)
    if value is None or isinstance(value, str | int | bool):
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    return str(value)
