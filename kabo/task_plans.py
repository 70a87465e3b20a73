"""Plans made of what tasks have found: one node with the motion of a solution, so that it is verified, drawn and executed.

A task knows no actions and no goals. Its plan is one action, named after the task, then the goal: the verifier judges its
motion in the scene, not what it is for.
"""

import json
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.given import refuse, require_flag, require_given, require_number
from kabo.language.recorded_paths import recorded_files
from kabo.language.scene_description import SceneDescription
from kabo.options import Options
from kabo.plan import Plan, plan_from_json
from kabo.plan.writing import FORMAT
from kabo.tasks.files.consistent_changes import contradiction
from kabo.tasks.files.motions import state_in
from kabo.tasks.files.needed_contacts import with_needed_contacts
from kabo.tasks.files.planned import TaskReport, load_report
from kabo.tasks.files.report_form import FORMAT as REPORT_FORMAT
from kabo.tasks.files.report_form import OLD_FORMAT, MotionReport, Report, StateReport
from kabo.whole_files import file_hash

if TYPE_CHECKING:
    from kabo.scene import Scene  # loads meshes

NODE, GOAL = "n0", "n1"
State = dict[str, dict[str, Any]]


def task_plan(report: "TaskReport", solution: int | None = None, *, certificate: bool = True) -> Plan:
    """The plan of one node that executes a solution of a task; `kabo.verify(report.scene, plan)` judges it.

    Args:
        report: what `kabo.plan_task` found.
        solution: the number of the solution, from 1, in the order of all runs; None: the cheapest one.
        certificate: whether the plan gets a certificate, the proofs that its motion is free of collision.

    Raises:
        InputError: there is no such solution, or it moves nothing; or the task was planned without a scene, or in one that
            was not loaded from a file.

    Example:
        >>> example = "examples/pick_and_place"
        >>> report = kabo.plan_task(f"{example}/task.yaml", f"{example}/scene.yaml", max_solutions=1)
        >>> kabo.verify(report.scene, kabo.task_plan(report)).ok
        True
    """
    require_given("report", report, TaskReport)
    require_flag("certificate", certificate)
    if solution is not None:
        solution = require_number("solution", solution, 1, whole=True)
    if report.scene is None:
        refuse("report", "the task was planned without a scene: nothing moves")
    number = chosen(report.content, solution, report.content["task"])
    return plan_of_solution(report.content, number, report.scene, certificate=certificate)


def chosen(report: Report, solution: int | None, file: str) -> int:
    """The number of a solution, from 1: the given one, or the cheapest that moves something.

    Raises:
        InputError: there is no such solution, or it moves nothing; says which there are.
    """
    found = solutions_of(report)
    moving = [number for number, whole in enumerate(found, 1) if "motion" in whole]
    if not moving:
        what = "its solutions move nothing" if found else "the report has no solution"
        hint = "plan the task in a scene: kabo task plan --scene FILE -o"
        if not found and "scene" in report:
            hint = "kabo task show REPORT says which stage never succeeded"
        raise InputError([Diagnostic(file, 1, 1, what, hint)])
    if solution is None:
        return min(moving, key=lambda number: found[number - 1]["cost"])
    if solution not in moving:
        what = f"there is no solution {solution} that moves something"
        raise InputError([Diagnostic(file, 1, 1, what, f"the report has {_spans(moving)}")])
    return solution


def solutions_of(report: Report) -> list[Any]:
    """The solutions of all runs of a report, those of the first run first."""
    return [whole for run in report["runs"] for whole in run["solutions"]]


def plan_of_solution(
    report: Report,
    number: int,
    scene: "Scene",
    *,
    certificate: bool,
    epsilon: float | None = None,
    consistent: bool = True,
) -> Plan:
    """The plan of one solution of a report, in the scene in which the task was planned.

    Args:
        report: the report.
        number: that of the solution, from 1, as `chosen` gives it.
        scene: the scene, loaded from a file.
        certificate: whether the plan gets a certificate.
        epsilon: the accuracy of the proofs [m]; None: that of the scene, with which tasks are planned.
        consistent: whether its changes must agree with its segments; False: the caller asks `require_consistent`.

    Raises:
        InputError: the motion is none, with its place in the plan; or it names what the scene does not have.
        ArgumentError: the scene was not loaded from a file.
    """
    # Loads kernels, as the scene's tasks have done.
    from kabo.planner.certify.granting import granted

    description = scene.description
    if description is None:
        refuse("scene", "the scene was not loaded from a file: give what `kabo.load_scene` returns")
    epsilon = scene.epsilon if epsilon is None else epsilon
    motion: MotionReport = solutions_of(report)[number - 1]["motion"]
    _require_known(motion, scene, f"solution {number}")
    if consistent:
        require_consistent(motion, number)
    before, after = (_whole(state, scene) for state in (motion["start"], motion["after"]))
    content = {
        "format": FORMAT,
        "problem": {"name": report["task"], "files": _files(scene, description)},
        "options": _options(report, number, epsilon),
        "root": NODE,
        "nodes": {NODE: _node(report["task"], motion, before, after, scene), GOAL: {"kind": "goal"}},
        "start": before,
    }
    plan = plan_from_json(json.dumps(content), file=f"solution {number}")
    try:
        plan = granted(plan, scene)
        return _certified(plan, scene, epsilon, report.get("clearance", 0.0)) if certificate else plan
    except (KeyError, ValueError, IndexError) as error:  # joints, links or objects of another scene
        what = f"this motion is none of the scene {scene.name}: {error}"
        raise InputError([Diagnostic(f"solution {number}", 1, 1, what, "name the scene of the report")]) from None


def require_consistent(motion: MotionReport, number: int) -> None:
    """Checks that the changes of a solution's motion say what its segments do.

    Raises:
        InputError: they say something else.
    """
    if (why := contradiction(motion)) is not None:
        raise InputError([Diagnostic(f"solution {number}", 1, 1, why, "plan the task again")])


def only_planned(report: Report, number: int) -> str | None:
    """What planning kept away from and no plan knows, so that nobody verifies it, as a sentence; None if nothing.

    Bodies and padding that stages add are of planning alone: they are neither in the scene nor in plans.
    """
    changes = solutions_of(report)[number - 1].get("motion", {}).get("changes", [])
    names = dict.fromkeys(each["body"]["name"] for each in changes if each["change"] in ("add", "pad"))
    if not names:
        return None
    return f"planning also kept away from what the scene does not have: {', '.join(names)}; no plan tells or proves it"


def _certified(plan: Plan, scene: "Scene", epsilon: float, clearance: float) -> Plan:
    from kabo.geometry_server import GeometryServer
    from kabo.planner.certify.certifying import certified

    return certified(plan, GeometryServer(scene, epsilon, clearance=clearance).surroundings)[0]


def _node(task: str, motion: MotionReport, before: State, after: State, scene: "Scene") -> dict[str, Any]:
    segments = [
        {"allowed_contacts": [], "constraint": None, "procedure": task, **segment}
        for segment in with_needed_contacts(motion, before["objects"], scene)
    ]
    made: dict[str, Any] = {"kind": "action", "action": task, "arguments": {}, "next": GOAL, "motion": segments}
    changed = {
        kind: {name: value for name, value in values.items() if value != before[kind][name]}
        for kind, values in after.items()
    }
    changed = {kind: values for kind, values in changed.items() if values}
    return made | ({"after": changed} if changed else {})


def _whole(state: StateReport, scene: "Scene") -> State:
    """A state of a report as the whole state of a plan: what is not in it is as at the start of the scene."""
    from kabo.geometry_server import whole_state

    found = state_in(state, scene)
    whole = whole_state(scene, {**found.robots, **found.objects})
    robots = {name: {"joints": dict(joints)} for name, joints in whole.robots.items()}
    objects = {name: _pose(pose.parent, pose.position, pose.quaternion) for name, pose in whole.objects.items()}
    return {"robots": robots, "objects": objects}


def _pose(parent: str, position: Sequence[float], quaternion: Sequence[float]) -> dict[str, Any]:
    return {"parent": parent, "position": list(position), "quaternion": list(quaternion)}


def _require_known(motion: MotionReport, scene: "Scene", file: str) -> None:
    """Checks that the scene has what a motion names.

    Raises:
        InputError: it lacks a robot or an object.
    """
    states = (motion["start"], motion["after"])
    robots = [
        *(name for state in states for name in state.get("robots", {})),
        *(s["robot"] for s in motion["segments"]),
    ]
    objects = [name for state in states for name in state.get("objects", {})]
    for names, known in ((robots, scene.robots), (objects, scene.movable)):
        for name in names:
            if name not in known:
                hint = did_you_mean(name, known) or f"it has {', '.join(known) or 'none'}"
                raise InputError([Diagnostic(file, 1, 1, f"it moves {name}, which the scene does not have", hint)])


def _files(scene: "Scene", description: SceneDescription) -> dict[str, str]:
    """The hashes of the scene's files, by their names in a plan."""
    own = file_hash(description.path)
    return {description.path.name: own, **recorded_files(scene.files.items(), description.path.parent)}


def _options(report: Report, number: int, epsilon: float) -> dict[str, Any]:
    """The options of a plan: the seed of the solution's run, what bodies kept, those on which no task depends."""
    seeds = [run["seed"] for run in report["runs"] for _ in run["solutions"]]
    return Options(seed=seeds[number - 1], epsilon=epsilon, clearance=report.get("clearance", 0.0)).written()


def _spans(numbers: Sequence[int]) -> str:
    """Numbers as text: `1 to 4` where none is left out."""
    whole = list(range(numbers[0], numbers[-1] + 1))
    if len(numbers) > 1 and list(numbers) == whole:
        return f"the solutions {numbers[0]} to {numbers[-1]}"
    return f"the solution{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))}"


# ----------------------------------------------------------------------------------------------------------- files
def is_report(path: Path) -> bool:
    """Whether a file is the report of a task: it may be faulty, and even end too early, but is no plan."""
    try:
        text = path.read_bytes()
        content = json.loads(text)
    except OSError:
        return False
    except (ValueError, RecursionError):
        begun = re.match(rb'\s*\{\s*"format"\s*:\s*"([^"]*)"', text)
        return begun is not None and begun[1].decode(errors="replace") in (REPORT_FORMAT, OLD_FORMAT)
    return isinstance(content, dict) and content.get("format") in (REPORT_FORMAT, OLD_FORMAT)


def plans_of_report(
    path: Path, scene: Path | None = None, solution: int | None = None, *, certificate: bool = False
) -> "Iterator[tuple[int, Plan, Scene, MotionReport]]":
    """The plans of the solutions in a report: of one, or of all that move something.

    Each with its number, the scene, and its motion, whose changes may say something else than its segments.
    Where the report tells a clearance, plans have certificates in any case: nothing else proves it.

    Raises:
        InputError: the report, the scene or a motion has errors, or there is no such solution.
        OSError: the report cannot be read.
    """
    report, found = load_report(path, scene)
    certificate = certificate or report.get("clearance", 0.0) > 0.0
    first = chosen(report, solution, str(path))
    moving = [number for number, whole in enumerate(solutions_of(report), 1) if "motion" in whole]
    for number in [first] if solution is not None else moving:
        plan = plan_of_solution(report, number, found, certificate=certificate, consistent=False)
        yield number, plan, found, solutions_of(report)[number - 1]["motion"]


def plan_of_report(
    path: Path, scene: Path | None = None, solution: int | None = None, *, certificate: bool = True
) -> "tuple[int, Plan, Scene, str | None]":
    """The plan of one solution in a report, the cheapest if none is given.

    With its number, the scene, and what `only_planned` says.

    Raises:
        InputError: the report, the scene or the motion has errors, or there is no such solution.
        OSError: the report cannot be read.
    """
    report, found = load_report(path, scene)
    number = chosen(report, solution, str(path))
    plan = plan_of_solution(report, number, found, certificate=certificate)
    return number, plan, found, only_planned(report, number)
