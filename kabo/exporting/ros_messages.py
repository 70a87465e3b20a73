"""Messages of ROS 2 from the trajectories of a plan: trajectory_msgs/JointTrajectory, moveit_msgs/RobotTrajectory.

Without a rate the points are the ends of the polynomials' pieces. The controllers of ros2_control join points that
have positions, velocities and accelerations by polynomials of degree five, of which there is only one: so what is
followed is the plan's own trajectory. All numbers of a message are those of the plan; times are whole nanoseconds.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from kabo.exporting.cdr import CdrWriter
from kabo.exporting.texts import comparable, number, one_line
from kabo.exporting.way import Choice, Run, TimedNode, refusal, runs_of
from kabo.plan.description import call

NANOSECONDS = 10**9  # in a second
MAX_SECONDS = 2**31 - 1  # of builtin_interfaces/Duration
ROS_TYPES = {"trajectory": "trajectory_msgs/msg/JointTrajectory", "moveit": "moveit_msgs/msg/RobotTrajectory"}


@dataclass(frozen=True)
class TrajectoryPoint:
    """A trajectory_msgs/JointTrajectoryPoint; `nanoseconds` count from the start of the message."""

    positions: tuple[float, ...]
    velocities: tuple[float, ...]
    accelerations: tuple[float, ...]
    nanoseconds: int


@dataclass(frozen=True)
class RosTrajectory:
    """A message of ROS, and which part of the plan it is.

    Attributes:
        kind: `trajectory` is trajectory_msgs/JointTrajectory, `moveit` is moveit_msgs/RobotTrajectory.
        joints: names of joints, as in the robot's URDF.
        points: of all joints, at increasing times from 0 on.
        nodes: the nodes of the plan whose motion it is.
        robot: the robot that moves.
        begin: when it begins, on the clock of the branch [s].
        note: what a person should know of it, in a line.
    """

    kind: Literal["trajectory", "moveit"]
    joints: tuple[str, ...]
    points: tuple[TrajectoryPoint, ...]
    nodes: tuple[str, ...]
    robot: str
    begin: float
    note: str

    @property
    def ros_type(self) -> str:
        """The type of the message."""
        return ROS_TYPES[self.kind]

    def body(self) -> dict[str, Any]:
        """The message as a dictionary, as `rosidl_runtime_py.set_message_fields` takes it."""
        motion = {
            "header": _header(),
            "joint_names": list(self.joints),
            "points": [_point(each) for each in self.points],
        }
        if self.kind == "trajectory":
            return motion
        none: dict[str, Any] = {"header": _header(), "joint_names": [], "points": []}
        return {"joint_trajectory": motion, "multi_dof_joint_trajectory": none}

    def to_yaml(self) -> str:
        """The message as one YAML document, as `ros2 topic pub` reads it, below its note as a comment."""
        return f"# {one_line(self.note)}\n" + "".join(f"{line}\n" for line in _yaml(self.body(), 0))

    def to_cdr(self) -> bytes:
        """The message as DDS sends it, with the four bytes of its encapsulation."""
        writer = CdrWriter()
        _write_header(writer)
        writer.texts(self.joints)
        writer.uint32(len(self.points))
        for point in self.points:
            for values in (point.positions, point.velocities, point.accelerations, ()):
                writer.float64s(values)
            seconds, rest = divmod(point.nanoseconds, NANOSECONDS)
            writer.int32(seconds)
            writer.uint32(rest)
        if self.kind == "moveit":
            _write_header(writer)
            writer.texts(())
            writer.uint32(0)
        return writer.content()


def ros_messages(
    timed: Sequence[TimedNode],
    choice: Choice,
    kind: Literal["trajectory", "moveit"],
    rate: float | None,
    file: str,
) -> list[RosTrajectory]:
    """A message for each motion from rest to rest, in the order in which they begin.

    Raises:
        InputError: there is nothing to send, or it cannot be written in whole nanoseconds.
    """
    calls = {each.name: call(each.node) for each in timed}
    return [_message(run, kind, rate, calls, file) for run in runs_of(timed, choice, file)]


def _message(
    run: Run, kind: Literal["trajectory", "moveit"], rate: float | None, calls: dict[str, str], file: str
) -> RosTrajectory:
    motion = run.trajectory
    begin = motion.times[0]
    times = list(motion.times) if rate is None else motion.sampled(rate).times.tolist()
    counted = [round((time - begin) * NANOSECONDS) for time in times]
    if any(after <= before for before, after in zip(counted, counted[1:], strict=False)):
        raise refusal(file, f"{run.nodes[0]} has two points in one nanosecond", "choose a lower --rate")
    if counted[-1] > MAX_SECONDS * NANOSECONDS:
        raise refusal(file, f"{run.nodes[0]} takes longer than ROS can say", "export shorter motions")
    values = [(motion.at(times, order) + 0.0).tolist() for order in range(3)]
    points = tuple(
        TrajectoryPoint(tuple(q), tuple(v), tuple(a), time) for q, v, a, time in zip(*values, counted, strict=True)
    )
    return RosTrajectory(kind, motion.joints, points, run.nodes, run.robot, begin, _note(run, calls))


def _note(run: Run, calls: dict[str, str]) -> str:
    what = ", ".join(f"{name} {calls[name]}" for name in run.nodes)
    text = f"{what}: {run.robot}, begins at {number(round(run.trajectory.times[0], 6))} s"
    for body in run.detach:
        text += f", then {body} is let go of"
    for body, link in run.attach:
        text += f", then {body} is held by {link}"
    return text


def _header() -> dict[str, Any]:
    return {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}  # a stamp of 0 means: begin at once


def _write_header(writer: CdrWriter) -> None:
    writer.int32(0)
    writer.uint32(0)
    writer.text("")


def _point(point: TrajectoryPoint) -> dict[str, Any]:
    seconds, rest = divmod(point.nanoseconds, NANOSECONDS)
    return {
        "positions": list(point.positions),
        "velocities": list(point.velocities),
        "accelerations": list(point.accelerations),
        "effort": [],
        "time_from_start": {"sec": seconds, "nanosec": rest},
    }


def _yaml(value: dict[str, Any], depth: int) -> list[str]:
    """The lines of a mapping: points one below the other, what is small in one line."""
    lines: list[str] = []
    for key, inner in value.items():
        space = "  " * depth
        if isinstance(inner, dict) and not _is_small(inner):
            lines += [f"{space}{key}:", *_yaml(inner, depth + 1)]
        elif isinstance(inner, list) and inner and isinstance(inner[0], dict):
            lines.append(f"{space}{key}:")
            for each in inner:
                first, *rest = _yaml(each, depth + 1)
                lines += [f"{space}- {first.lstrip()}", *rest]
        else:
            lines.append(f"{space}{key}: {_flow(inner)}")
    return lines


def _is_small(value: dict[str, Any]) -> bool:
    return all(isinstance(inner, int) for inner in value.values())


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_flow, value)) + "]"
    return number(value) if isinstance(value, float) else json.dumps(value)


def compared_values(text: str) -> list[str]:
    """The values of YAML documents in their order, with their types; not layout and comments.

    Raises:
        ValueError: it is no YAML.
    """
    import yaml

    try:
        return list(_values(yaml, text))
    except yaml.YAMLError as error:
        raise ValueError(f"it is no YAML: {' '.join(str(error).split())}") from None


def _values(yaml: Any, text: str) -> Iterator[str]:
    """Parser events, of which none nests: files that would exhaust a stack or a memory are harmless."""
    resolver = yaml.SafeLoader("")
    for event in yaml.parse(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
        kind = type(event).__name__.removesuffix("Event")
        marks = " ".join(filter(None, (getattr(event, "anchor", None), getattr(event, "tag", None))))
        if isinstance(event, yaml.ScalarEvent):
            own = event.tag or resolver.resolve(yaml.ScalarNode, event.value, event.implicit)
            value = comparable(event.value) if own.endswith(":float") else event.value
            yield f"{own.rpartition(':')[2]} {value} {marks}".rstrip()
        elif not isinstance(event, yaml.StreamStartEvent | yaml.StreamEndEvent | yaml.DocumentEndEvent):
            yield f"{kind} {marks}".rstrip()
