"""Films: motions from one state to another, in the form that the player of the page takes, and states of samples.

A film has segments, as plans have them. What a hand takes or lets go keeps its pose in the world; its pose in the
frame of its new parent follows from kinematics and is computed here.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from kabo.plan import Segment
from kabo.scene import Attachment, Configuration, GeometricState, Robot, Scene, with_hand_action, world_T
from kabo.tasks.files.report_form import MotionReport, SegmentReport, StateReport
from kabo.viewer.content.trajectories import shown_trajectory, trajectory_of_report

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
        ValueError: a segment has not as many times as way points, or a trajectory that does not fit it.
    """
    moves = [_move(segment, scene) for segment in film["segments"]]
    return {
        "start": flat_state(film["start"], scene),
        "after": flat_state(film["after"], scene),
        "duration": max((move.times[-1] for move in moves), default=0.0),
        "segments": [_shown(*each) for each in zip(film["segments"], moves, strict=True)],
        "handovers": _handovers(film, moves, scene),
    }


def _move(given: SegmentReport, scene: Scene) -> Segment:
    """Where the joints of a segment are in time, as in plans."""
    rows = {len(row) for row in given["waypoints"]} | {len(given["joints"])}
    _joints(dict.fromkeys(given["joints"], 0.0), scene.robots[given["robot"]])
    if len(rows) > 1 or not 0 < len(given["times"]) == len(given["waypoints"]):
        raise ValueError(f"a segment of {given['robot']} has not a value for each joint and time")
    joints, waypoints = tuple(given["joints"]), tuple(map(tuple, given["waypoints"]))
    own = trajectory_of_report(joints, waypoints, given["times"], given.get("trajectory"))
    return Segment(given["robot"], joints, waypoints, tuple(given["times"]), "", trajectory=own)


def _shown(given: SegmentReport, move: Segment) -> State:
    own = move.trajectory
    return dict(given) if own is None else {**given, "trajectory": shown_trajectory(own)}


def _handovers(film: MotionReport, moves: Sequence[Segment], scene: Scene) -> list[State]:
    """Where objects hang that are taken or let go: `time` [s], `object`, `parent`, and the pose in its frame."""
    made = []
    start = _whole(film["start"], scene)
    hung = dict(start.objects)
    for segment in sorted(film["segments"], key=lambda each: each["times"][-1]):
        time = segment["times"][-1]
        state = GeometricState(_robots_at(moves, start, scene, time), hung)
        taken = [(each["object"], each["to"]) for each in segment["attach"]]
        after = with_hand_action(scene, state, segment["robot"], detach=segment["detach"], attach=taken)
        for name in dict.fromkeys((*segment["detach"], *(name for name, _ in taken))):
            own = after.objects[name]
            if own is not hung[name]:
                pose = {"position": list(own.position), "quaternion": list(own.quaternion)}
                made.append({"time": time, "object": name, "parent": own.parent, **pose})
        hung = dict(after.objects)
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
    moves: Sequence[Segment], start: GeometricState, scene: Scene, time: float
) -> dict[str, Configuration]:
    """The configurations of all robots at a time of a film [s]."""
    values = {name: dict(zip(scene.robots[name].joint_names, q, strict=True)) for name, q in start.robots.items()}
    for move in sorted(moves, key=lambda each: each.times[0]):
        if move.times[0] <= time:
            values[move.robot].update(zip(move.joints, move.at(time).tolist(), strict=True))
    return {name: tuple(joints.values()) for name, joints in values.items()}
