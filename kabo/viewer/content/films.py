"""Films: motions from one state to another, in the form that the player of the page takes, and states of samples.

A film has segments, as plans have them. What a hand takes or lets go keeps its pose in the world; its pose in the
frame of its new parent follows from kinematics and is computed here.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.scene import Attachment, Configuration, GeometricState, Robot, Scene, attachment, world_T
from kabo.scene.transforms import inverse
from kabo.tasks.files.report_form import MotionReport, SegmentReport, StateReport

State = dict[str, Any]


def flat_state(state: StateReport, scene: Scene) -> State:
    """A state of a report or an explanation in the form of the view document: joint values directly by robot.

    Raises:
        KeyError: the scene lacks a robot, joint, object or parent of the state.
    """
    robots = {
        name: _joints(robot["joints"], scene.robots[name]) for name, robot in state.get("robots", {}).items()
    }
    objects = {name: dict(pose) for name, pose in state.get("objects", {}).items()}
    for name, pose in objects.items():
        if name not in scene.movable:
            raise KeyError(name)
        world_T(scene, scene.start, str(pose["parent"]))
    return {"robots": robots, "objects": objects}


def _joints(values: Mapping[str, float], robot: Robot) -> dict[str, float]:
    for joint in values:
        if joint not in robot.joint_names:
            raise KeyError(f"{robot.name}.{joint}")
    return dict(values)


def film_view(film: MotionReport, scene: Scene) -> State:
    """A film: `start` and `after` as what is elsewhere than at the start of the scene, `segments`, `handovers`.

    Raises:
        KeyError: the scene lacks a robot, joint or object of the film.
        ValueError: a segment has not as many times as way points.
    """
    for segment in film["segments"]:
        rows = {len(row) for row in segment["waypoints"]} | {len(segment["joints"])}
        _joints(dict.fromkeys(segment["joints"], 0.0), scene.robots[segment["robot"]])
        if len(rows) > 1 or not 0 < len(segment["times"]) == len(segment["waypoints"]):
            raise ValueError(f"a segment of {segment['robot']} has not a value for each joint and time")
    return {
        "start": flat_state(film["start"], scene),
        "after": flat_state(film["after"], scene),
        "duration": max((segment["times"][-1] for segment in film["segments"]), default=0.0),
        "segments": list(film["segments"]),
        "handovers": _handovers(film, scene),
    }


def _handovers(film: MotionReport, scene: Scene) -> list[State]:
    """Where objects hang that are taken or let go: `time` [s], `object`, `parent`, and the pose in its frame."""
    made = []
    start = _whole(film["start"], scene)
    hung = dict(start.objects)
    for segment in sorted(film["segments"], key=lambda each: each["times"][-1]):
        time = segment["times"][-1]
        changes = [(each["object"], each["to"]) for each in segment["attach"]]
        for name, parent in [*changes, *((name, "world") for name in segment["detach"])]:
            state = GeometricState(_robots_at(film["segments"], start, scene, time), hung)
            hung[name] = attachment(parent, inverse(world_T(scene, state, parent)) @ world_T(scene, state, name))
            pose = {"position": list(hung[name].position), "quaternion": list(hung[name].quaternion)}
            made.append({"time": time, "object": name, "parent": parent, **pose})
    return made


def _whole(change: StateReport, scene: Scene) -> GeometricState:
    """The start of a scene with some components elsewhere."""
    robots, objects = dict(scene.start.robots), dict(scene.start.objects)
    for name, robot in change.get("robots", {}).items():
        robots[name] = tuple(robot["joints"][joint] for joint in scene.robots[name].joint_names)
    for name, pose in change.get("objects", {}).items():
        objects[name] = Attachment(pose["parent"], pose["position"], pose["quaternion"])
    return GeometricState(robots, objects)


def _robots_at(
    segments: Sequence[SegmentReport], start: GeometricState, scene: Scene, time: float
) -> dict[str, Configuration]:
    """The configurations of all robots at a time of a film [s]."""
    values = {name: dict(zip(scene.robots[name].joint_names, q, strict=True)) for name, q in start.robots.items()}
    for segment in sorted(segments, key=lambda each: each["times"][0]):
        if segment["times"][0] <= time:
            way: Array = np.array(segment["waypoints"])
            now = [float(np.interp(time, segment["times"], column)) for column in way.T]
            values[segment["robot"]].update(zip(segment["joints"], now, strict=True))
    return {name: tuple(joints.values()) for name, joints in values.items()}
