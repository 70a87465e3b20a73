"""Runs as geometric states over time: what animations and film strips of a log show, frame by frame.

Only what was measured is shown: robots at their encoders' values, bodies where they were seen.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.errors import Diagnostic, InputError
from kabo.execution import Robot
from kabo.plan import Node
from kabo.plan.description import call
from kabo.scene import GeometricState, Scene, attachment
from kabo.scene.transforms import quaternion, transform

Record = Mapping[str, Any]
EARLY = 1e-6  # [s] by which a state may come before its frame is due
TOLD_S = 2.0  # for how long an event is told under the frames
FRAME_S, MOST_FRAMES = 0.1, 120  # [s] between two frames; how many, where no rate is asked for
HANDS = {"gripping": "grips", "releasing": "lets go of"}
EVENTS = (*HANDS, "sensing", "silent", "stopping", "answer", "stopped", "goal")  # that are told


@dataclass(frozen=True)
class RunFrame:
    """A moment of a run: the time on the robots' clock [s], the state, what is done, and what has just happened.

    `about` are the names of the arguments of what is done; `key` is whether something begins or ends here.
    """

    time: float
    state: GeometricState
    doing: str
    told: str
    about: frozenset[str]
    key: bool = False


class Witness:
    """A listener of a run's log that notes where everything *is* at each record `state`, whatever sensors say.

    Args:
        robot: which knows, as a simulation does; its `poses()` are those of all movable bodies.
    """

    def __init__(self, robot: Any) -> None:
        self.robot = robot
        self.records: list[Record] = []

    def __call__(self, record: Record) -> None:
        """Notes a record, with what is true in place of what was measured."""
        if record["event"] != "state":
            self.records.append(record)
            return
        robot: Robot = self.robot
        bodies = {
            name: {"position": pose[:3, 3].tolist(), "quaternion": list(quaternion(pose))}
            for name, pose in self.robot.poses().items()
        }
        robots = {name: list(map(float, values)) for name, values in robot.state().positions.items()}
        self.records.append({**record, "robots": robots, "bodies": bodies})


def frames_of_run(records: Sequence[Record], scene: Scene, step: float, file: str) -> list[RunFrame]:
    """The frames of a run: one every `step` seconds, or as often as the log has states, and one at its end.

    Args:
        records: of the log. scene: of its problem. step: [s]. file: the name of the log, for messages.

    Raises:
        InputError: the log has no states, or is of another scene.
    """
    frames, due = list(_all_frames(records, scene, file)), -np.inf
    if not frames:
        hint = "write it with kabo execute -o FILE, and with --log-rate"
        raise InputError([Diagnostic(file, 1, 1, "this log never says where anything is", hint)])
    found: list[RunFrame] = []
    for frame in frames[:-1]:
        if frame.time >= due - EARLY:
            due = (due if found else frame.time) + step
            found.append(frame)
    return [*found, frames[-1]]


def key_frames_of_run(records: Sequence[Record], scene: Scene, file: str) -> list[RunFrame]:
    """The frames at which a motion has ended or a surprise has come, the first and the last.

    Raises:
        InputError: as of `frames_of_run`.
    """
    frames = frames_of_run(records, scene, 0.0, file)
    return [f for k, f in enumerate(frames) if f.key or k in (0, len(frames) - 1)]


def step_of_run(records: Sequence[Record], rate: float | None) -> tuple[float, float]:
    """Seconds of the run between two frames, and for how long each is shown: the same if it is shown in real time.

    Args:
        records: of the log. rate: frames a second of the run [Hz]; None: a usual one, or lower if that is too many.
    """
    if rate is not None:
        return 1.0 / rate, 1.0 / rate
    times = [record["time"] for record in records if record["event"] == "state"]
    seconds = times[-1] - times[0] if times else 0.0
    return max(FRAME_S, seconds / MOST_FRAMES), FRAME_S


def _all_frames(records: Sequence[Record], scene: Scene, file: str) -> Iterator[RunFrame]:
    """A frame for each state in the log; one is a key frame if it is the last before something else begins."""
    state, doing, about = scene.start, "start", frozenset[str]()
    told, told_at = "", -np.inf
    last: RunFrame | None = None
    for record in records:
        event, time = record["event"], float(record["time"])
        if event == "state":
            if last is not None:
                yield last
            state = _state(record, state, scene, file)
            last = RunFrame(time, state, doing, told if time - told_at <= TOLD_S else "", about)
            continue
        if event == "node":
            node = Node("action", action=record.get("action"), arguments=record.get("arguments", {}))
            doing = f"{record['node']} {call(node) if node.action else record.get('kind', '')}"
            about = frozenset(map(str, node.arguments.values()))
        if event in EVENTS:
            told, told_at = _told(record), time
        if last is not None and event in ("node", *EVENTS):
            last = _replaced(last, told if event in EVENTS else last.told)
    if last is not None:
        yield _replaced(last, last.told)


def _replaced(frame: RunFrame, told: str) -> RunFrame:
    return RunFrame(frame.time, frame.state, frame.doing, told, frame.about, key=True)


def _told(record: Record) -> str:
    """What an event says under a frame."""
    event = record["event"]
    if event == "sensing":
        asked, found = record.get("formula", record.get("term")), record.get("outcome", record.get("value"))
        return f"{asked}: {found}"
    if event in HANDS:
        return f"{record.get('robot')} {HANDS[event]} {', '.join(record.get('bodies', ()))}"
    if event == "answer":
        return f"{record.get('kind')}: {record.get('reason')}"
    if event == "goal":
        return "the goal is reached"
    return ": ".join(str(word) for word in (event, record.get("reason")) if word)


def _state(record: Record, before: GeometricState, scene: Scene, file: str) -> GeometricState:
    """Where everything is by a record; what it does not say is as before.

    Raises:
        InputError: it is of another scene.
    """
    changes: dict[str, Any] = {}
    try:
        for name, values in record["robots"].items():
            if len(values) != len(scene.robots[name].joint_names):
                raise KeyError(name)
            changes[name] = tuple(map(float, values))
        for name, pose in record["bodies"].items():
            if name not in scene.movable:
                raise KeyError(name)
            changes[name] = attachment("world", _pose(pose))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        text = f"this log is of another scene than {scene.name}: it has no such {error}"
        raise InputError([Diagnostic(file, 1, 1, text, "name the problem of the run: --problem FILE")]) from None
    return before.replace(changes)


def _pose(pose: Record) -> Array:
    x, y, z = map(float, pose["position"])
    a, b, c, d = map(float, pose["quaternion"])
    return transform((x, y, z), (a, b, c, d))
