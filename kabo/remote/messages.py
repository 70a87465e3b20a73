"""The messages between an executor and a robot server as data: msgspec decodes and checks them, and refuses unknown keys.

Lengths are in m, angles in rad, times in s, forces in N; poses are 16 numbers, row by row.
"""

from collections.abc import Mapping

import msgspec
import numpy as np

from kabo.arrays import Array
from kabo.execution import Motion, RobotState, Stretch
from kabo.motion import Trajectory
from kabo.service import Unreadable

MAX_MOTION_BYTES = 4 << 20
MAX_STRETCHES, MAX_SECONDS = 1000, 1e5  # of one motion
POSE = 16  # numbers


class DriverMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What a client sends to `take` a robot server, to `stop` its robots, and to `leave` it."""

    client: str


class HandMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What a client sends to `grip` bodies with the hand of a robot, and to `release` them."""

    client: str
    robot: str
    bodies: list[str]


class StretchMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A trajectory of some joints on the clock of the motion: piece k is a polynomial in the time since `times[k]`.

    `coefficients` are, for each piece and each joint, at most six numbers in increasing powers. `node` and `segment` say
    where it stands in the plan.
    """

    robot: str
    joints: list[str]
    times: list[float]
    coefficients: list[list[list[float]]]
    node: str = ""
    segment: int = 0


class MotionMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What a client sends to `follow`: a whole motion, before it begins."""

    client: str
    begin: float
    end: float
    stretches: list[StretchMessage]
    nodes: list[str] = []


class StateMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What is measured: published again and again, and the reply to whatever a client asks.

    `count` increases with each; `positions` and `velocities` are by robot, in the order of `TakenMessage.robots`; `bodies`
    are poses of the bodies that are seen; `driver` is the client that drives, and `halted` why the last one no longer
    does, if it was lost.
    """

    count: int
    time: float
    motion_time: float
    moving: bool
    positions: dict[str, list[float]]
    velocities: dict[str, list[float]]
    pressing: dict[str, float] = {}
    still: list[str] = []
    bodies: dict[str, list[float]] = {}
    driver: str | None = None
    halted: str | None = None


class TakenMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The reply to `take`: whom the client drives now, and after how long without a sign of life both sides stop."""

    limit_s: float
    robots: dict[str, list[str]]
    bodies: list[str]
    state: StateMessage


def motion_message(client: str, motion: Motion) -> MotionMessage:
    """A motion as it is sent; what hands do meanwhile is asked for when it is time."""
    stretches = [
        StretchMessage(
            each.robot,
            list(each.trajectory.joints),
            list(each.trajectory.times),
            [[list(own) for own in piece] for piece in each.trajectory.coefficients],
            each.node,
            each.segment,
        )
        for each in motion.stretches
    ]
    return MotionMessage(client, motion.begin, motion.end, stretches, list(motion.nodes))


def motion_from(message: MotionMessage) -> Motion:
    """The motion of a message; way points, which nobody follows, are the ends of its pieces.

    Raises:
        Unreadable: it has too many stretches, or one is no motion: times, shapes, numbers that are not finite.
    """
    if len(message.stretches) > MAX_STRETCHES:
        raise Unreadable(f"`$.stretches` holds up to {MAX_STRETCHES} trajectories")
    stretches = []
    for number, each in enumerate(message.stretches):
        pieces = tuple(tuple(tuple(own) for own in piece) for piece in each.coefficients)
        if not all(own for piece in pieces for own in piece):
            raise Unreadable(f"`$.stretches[{number}]`: a polynomial has one coefficient or more")
        trajectory = Trajectory(tuple(each.joints), (), tuple(each.times), pieces)
        try:
            trajectory.padded  # noqa: B018 - it checks the form
        except ValueError as error:
            raise Unreadable(f"`$.stretches[{number}]`: {error}") from None
        stretches.append(Stretch(each.node, each.segment, each.robot, trajectory))
    stretches.sort(key=lambda each: each.begin)
    return Motion(tuple(stretches), (), tuple(message.nodes), message.begin, message.end)


def state_message(
    state: RobotState, poses: Mapping[str, Array], count: int, driver: str | None, halted: str | None
) -> StateMessage:
    """What is measured as it is sent."""
    return StateMessage(
        count,
        state.time,
        state.motion_time,
        state.moving,
        {name: list(map(float, values)) for name, values in state.positions.items()},
        {name: list(map(float, values)) for name, values in state.velocities.items()},
        dict(state.pressing),
        sorted(state.still),
        {name: pose.ravel().tolist() for name, pose in poses.items()},
        driver,
        halted,
    )


def state_from(message: StateMessage) -> RobotState:
    """What is measured, from its message."""
    return RobotState(
        message.time,
        message.motion_time,
        message.moving,
        {name: tuple(values) for name, values in message.positions.items()},
        {name: tuple(values) for name, values in message.velocities.items()},
        dict(message.pressing),
        frozenset(message.still),
    )


def poses_from(message: StateMessage) -> dict[str, Array]:
    """The poses (4, 4) of the bodies that are seen."""
    return {name: np.array(pose).reshape(4, 4) for name, pose in message.bodies.items() if len(pose) == POSE}
