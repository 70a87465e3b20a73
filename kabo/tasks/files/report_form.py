"""The format of reports, `kabo-task/2`: the keys of each object, and the check of a file against them.

Files of the format `kabo-task/1` are read, too: their solutions have no changes of the scene, and no trajectories.
"""

import json
import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal, TypedDict

import msgspec

from kabo.errors import Diagnostic, InputError
from kabo.options import LARGEST_CLEARANCE

FORMAT, OLD_FORMAT = "kabo-task/2", "kabo-task/1"
MAX_REPORTED = 100  # solutions, and failures, of one stage in a report; all are counted
_OTHER_FILES = {"kabo-plan": "it is a plan", "kabo-state": "it is the state of a run"}
MAX_COUNT, MAX_DEPTH = 2**53, 1000  # the largest count, the largest depth of a stage, that a report may have
# The names in the published schema of objects whose classes are called otherwise here.
_SCHEMA_NAMES = {
    "AttachReport": "Attach",
    "FailureReport": "Refusal",
    "ChangeReport": "SceneChange",
    "MotionReport": "Motion",
    "JointsReport": "Joints",
    "LearnedReport": "Learned",
    "PhaseReport": "Part",
    "PoseReport": "Pose",
    "SampleReport": "Sample",
    "SegmentReport": "Segment",
    "SolutionTime": "Found",
    "StageFigures": "Figures",
    "StateReport": "State",
    "TrajectoryReport": "Trajectory",
}
MAX_PATH_CHARACTERS = 60  # characters of a path in a message


class LearnedReport(TypedDict):
    """Learned parameters: the model as the task names it, the case, the validity, and the outcomes that are expected."""

    model: str
    case: dict[str, str]
    parameters: dict[str, float]
    validity: float
    expected: dict[str, float]


class _Learning(TypedDict, total=False):
    learned: LearnedReport | list[LearnedReport]  # only where parameters were learned; a list if there are several


class Told(_Learning):
    """A solution of one stage: what it says, what it costs, what it changes in the scene, a line each."""

    comment: str
    cost: float
    changes: list[str]


class _Between(TypedDict, total=False):
    between: tuple[str, str]  # what came too close: `robot.link` or bodies


class JointsReport(TypedDict):
    """Where a robot is."""

    joints: dict[str, float]


class PoseReport(TypedDict):
    """Where an object is, in the frame of its parent: `world`, `robot.link` or an object; quaternion (x, y, z, w)."""

    parent: str
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]


class StateReport(TypedDict, total=False):
    """What is elsewhere than at the start of the scene, as in plan files."""

    robots: dict[str, JointsReport]
    objects: dict[str, PoseReport]


class SampleReport(_Between):
    """The geometric state in which a failure was found: the robot is at the configuration that was refused."""

    state: StateReport


class AttachReport(TypedDict):
    """An object that is attached to a link when a segment ends."""

    object: str
    to: str


class TrajectoryReport(TypedDict):
    """How the way points are passed, as in plan files: polynomials of the time since the beginning of each piece."""

    times: list[float]
    coefficients: list[list[list[float]]]
    deviation: float


class _Proven(TypedDict, total=False):
    trajectory: TrajectoryReport
    allowed_contacts: list[tuple[str, str]]
    constraint: str | None


class SegmentReport(_Proven):
    """One stretch of motion, as in plan files; times from the beginning of the motion [s]."""

    robot: str
    joints: list[str]
    waypoints: list[list[float]]
    times: list[float]
    stage: str | None
    attach: list[AttachReport]
    detach: list[str]


# What a change of each kind says at least.
_NEEDED = {
    "attach": ("object", "to"),
    "join": ("object", "to"),
    "detach": ("object",),
    "permit": ("pairs",),
    "forbid": ("pairs",),
    "add": ("body",),
    "pad": ("body",),
    "remove": ("object",),
    "unpad": ("object",),
}
Change = Literal["attach", "detach", "join", "permit", "forbid", "add", "remove", "pad", "unpad"]


class AddedBody(TypedDict):
    """A body that only planning knows: its shape in the pose in its parent's frame, sizes as in scenes' meshes."""

    name: str
    parent: str
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    shape: dict[
        str, list[float]
    ]  # box: x, y, z; cylinder and capsule: radius, radius, height; sphere: radius thrice


class _About(TypedDict, total=False):
    object: str  # attach, detach, join: what changes hands; remove: the added body; unpad: what was padded
    to: str  # attach: `robot.link`; join: the body
    of: str  # detach: the robot that lets it go
    pairs: list[tuple[str, str]]  # permit, forbid: `robot.link` or bodies
    body: AddedBody  # add; pad, where `parent` is what is padded


class ChangeReport(_About):
    """A change of the scene by a stage, which takes effect at the end of a segment; null: before the first one."""

    change: Change
    stage: str
    segment: int | None
    time: float


class MotionReport(TypedDict):
    """The motion of a whole solution, from one state to another, and what changes in the scene meanwhile."""

    start: StateReport
    segments: list[SegmentReport]
    changes: list[ChangeReport]
    after: StateReport


class _Sampled(TypedDict, total=False):
    sample: SampleReport  # only in scenes of robots


class FailureReport(_Sampled):
    """A failure of one stage; failures with the same reason are counted together."""

    reason: str
    comment: str
    changes: list[str]


class PhaseReport(_Learning):
    """One phase of a whole solution, in order of time."""

    stage: str
    comment: str
    cost: float
    changes: list[str]


class _Moving(TypedDict, total=False):
    motion: MotionReport  # where robots move


class Whole(_Moving):
    """A solution of the task."""

    comment: str
    cost: float
    parts: list[PhaseReport]


class StageFigures(TypedDict):
    """What a stage did in one run: all is counted, some is told."""

    calls: int
    seconds: float
    successes: int
    failures: dict[str, int]
    mismatches: dict[str, int]
    costs: list[float]
    solutions: list[Told]
    refusals: list[FailureReport]


class Why(TypedDict):
    """Why there is no solution: the first stage without successes, and what it was refused for."""

    text: str
    stage: str | None
    failures: dict[str, int]
    mismatches: dict[str, int]
    examples: list[str]


class SolutionTime(TypedDict):
    """When a whole solution came, and at what cost."""

    seconds: float
    cost: float


class RunReport(TypedDict):
    """One planning run; `stages` by path."""

    seed: int
    seconds: float
    exhausted: bool
    stopped: bool
    found: list[SolutionTime]
    solutions: list[Whole]
    stages: dict[str, StageFigures]
    explanation: Why | None


class StageReport(TypedDict):
    """A stage of the task, in order of time, containers before what they hold."""

    path: str
    name: str
    type: str
    depth: int
    arrows: str
    monitors: str | None
    properties: dict[str, Any]


class _InScene(TypedDict, total=False):
    scene: str  # the file, by the path that was given; only where robots move
    # [m]: what bodies keep from each other, beside what is uncertain; only where it was asked for
    clearance: Annotated[float, msgspec.Meta(ge=0.0, le=LARGEST_CLEARANCE)]


class Report(_InScene):
    """Runs of one task."""

    format: Literal["kabo-task/2"]
    task: str
    file: str | None
    arguments: dict[str, Any]
    stages: list[StageReport]
    runs: list[RunReport]


def report_bytes(report: Report) -> bytes:
    """The report as the bytes of a file: keys in their order, a line feed at the end."""
    return msgspec.json.format(msgspec.json.encode(report), indent=1) + b"\n"


def read_report(content: bytes, file: str) -> Report:
    """The report in the bytes of `file`.

    Raises:
        InputError: it is no report; says what is wrong, and where.
    """
    hint = "kabo task plan FILE -o REPORT.json writes one"
    given: Any = None  # if a number is larger than any reader knows
    try:
        given = msgspec.json.decode(content)
        found = msgspec.convert(_upgraded(given), type=Report)
    except msgspec.ValidationError as error:
        message, _, path = str(error).partition(" - at ")
        where = path.strip("`").removeprefix("$.")
        said = f"{where}: {message}" if where and where != "$" else message
        named = given.get("format") if isinstance(given, dict) else None
        said = _OTHER_FILES.get(str(named).partition("/")[0], said)
        raise InputError([Diagnostic(file, 1, 1, f"this is no report of planning: {said}", hint)]) from None
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        line, column, why = _place(content)
        raise InputError([Diagnostic(file, line, column, f"this is no JSON: {why or error}", hint)]) from None
    for where, count, most in _counts(found):
        if not 0 <= count <= most:
            message = f"this is no report of planning: {where} is not from 0 to {most}"
            raise InputError([Diagnostic(file, 1, 1, message, hint)])
    for where, fault in (*_unlearned(found), *_incomplete(found)):
        raise InputError([Diagnostic(file, 1, 1, f"this is no report of planning: {where} {fault}", hint)])
    paths = {stage["path"] for stage in found["stages"]}
    for number, run in enumerate(found["runs"]):
        if run["stages"].keys() != paths:
            message = f"this is no report of planning: runs[{number}].stages are not those of the task"
            raise InputError([Diagnostic(file, 1, 1, message, hint)])
    if not found["stages"] or not found["runs"]:
        raise InputError([Diagnostic(file, 1, 1, "this is no report of planning: it has no run", hint)])
    return found


def _place(content: bytes) -> tuple[int, int, str | None]:
    """Line and column where bytes are no JSON, and why, as far as that is known: the quick reader tells no place."""
    try:
        json.loads(content)
    except json.JSONDecodeError as error:
        return error.lineno, error.colno, error.msg
    except (ValueError, RecursionError):
        pass
    return 1, 1, None


def _upgraded(content: Any) -> Any:
    """A report of the format `kabo-task/1` in today's form; anything else as it is."""
    if not isinstance(content, dict) or content.get("format") != OLD_FORMAT:
        return content
    runs = content.get("runs")
    for run in runs if isinstance(runs, list) else ():
        solutions = run.get("solutions") if isinstance(run, dict) else None
        for whole in solutions if isinstance(solutions, list) else ():
            if isinstance(whole, dict) and isinstance(whole.get("film"), dict):
                whole["motion"] = {**whole.pop("film"), "changes": []}
    return {**content, "format": FORMAT}


def _counts(report: Report) -> Iterator[tuple[str, int, int]]:
    """Every integer of a report: where it is, its value, and its upper bound."""
    for stage in report["stages"]:
        yield f'the depth of "{stage["path"][:MAX_PATH_CHARACTERS]}"', stage["depth"], MAX_DEPTH
    for number, run in enumerate(report["runs"]):
        for path, figures in run["stages"].items():
            tables = (figures["failures"], figures["mismatches"])
            for count in (figures["calls"], figures["successes"], *(n for each in tables for n in each.values())):
                yield f'a count of runs[{number}] for "{path[:MAX_PATH_CHARACTERS]}"', count, MAX_COUNT


def _incomplete(report: Report) -> Iterator[tuple[str, str]]:
    """Every change of the scene that lacks what one of its kind says: where it is, and what it lacks."""
    for number, run in enumerate(report["runs"]):
        for k, whole in enumerate(run["solutions"]):
            for i, change in enumerate(whole["motion"]["changes"] if "motion" in whole else ()):
                for key in _NEEDED[change["change"]]:
                    if key not in change:
                        yield f"runs[{number}].solutions[{k}].motion.changes[{i}]", f"lacks `{key}`"


def _unlearned(report: Report) -> Iterator[tuple[str, str]]:
    """Every record of learned parameters that can be none: where it is, and what is wrong."""
    for number, run in enumerate(report["runs"]):
        parts = [part for whole in run["solutions"] for part in whole["parts"]]
        told = [each for figures in run["stages"].values() for each in figures["solutions"]]
        for holder in (*parts, *told):
            records = holder.get("learned", [])
            for record in records if isinstance(records, list) else [records]:
                numbers = (*record["parameters"].values(), *record["expected"].values())
                if not 0.0 < record["validity"] <= 1.0:
                    yield f"learned of runs[{number}]", "has a validity that is no probability above 0"
                if not all(map(math.isfinite, numbers)):
                    yield f"learned of runs[{number}]", "has a number that is not finite"


def schema() -> dict[str, Any]:
    """The JSON Schema of a report."""
    text = msgspec.json.encode(msgspec.json.schema(Report)).decode()
    for ours, name in _SCHEMA_NAMES.items():
        text = text.replace(f'"{ours}"', f'"{name}"').replace(f'/{ours}"', f'/{name}"')
    content = msgspec.json.decode(text)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": FORMAT, **content}
