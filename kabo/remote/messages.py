"""The messages between an executor and a robot server as data: msgspec decodes and checks them, and refuses unknown keys.

Lengths are in m, angles in rad, times in s, masses in kg, forces in N; poses are 16 numbers, row by row. What
changes a message changes the name of the protocol.
"""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Annotated

import msgspec
import numpy as np

from kabo.arrays import Array
from kabo.execution import Motion, RobotState, Stretch
from kabo.language.sensors_description import MeasurementKind
from kabo.motion import Trajectory
from kabo.service import Unreadable

MAX_MOTION_BYTES = 4 << 20
MAX_STRETCHES, MAX_SECONDS = 1000, 1e5  # of one motion
POSE = 16  # numbers
PROTOCOL = "kabo-robot/1"

ClientName = Annotated[str, msgspec.Meta(pattern="^[A-Za-z0-9_-]{1,64}$")]  # it is part of a key


class TakeMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What a client sends to `take` a robot server, with the protocol that it speaks."""

    client: ClientName
    protocol: str = PROTOCOL


class DriverMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What a client sends to `stop` the robots of a server, and to `leave` it."""

    client: ClientName


class HandMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What a client sends to `grip` bodies with the hand of a robot, and to `release` them."""

    client: ClientName
    robot: str
    bodies: list[str]


class PaceMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What a client sends to change the `pace`, the rate of the motion's clock: 1 is that of the plan."""

    client: ClientName
    rate: Annotated[float, msgspec.Meta(gt=0.0, le=1.0)]


class LookMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What a client sends to `look` with a sensor, once.

    `asked` is the question as the plan spells it; `kind` says what is to be read: `weight` of a body in a hand, `contact`
    of two things (bodies, robots or `robot.link`), or `told`, what is no measurement. `outcomes` are the possible
    answers; null: a number is wanted.
    """

    client: ClientName
    asked: str
    kind: MeasurementKind
    things: list[str] = []
    outcomes: list[str] | None = None


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

    client: ClientName
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


class PacedMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The reply to `pace`: whether the clock goes to this rate, within all limits."""

    paced: bool
    state: StateMessage


class LookedMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The reply to `look`: a number, yes or no, or one of the outcomes; null: that cannot be measured now."""

    reading: float | bool | str | None
    state: StateMessage


class TakenMessage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The reply to `take`: whom the client drives now, and after how long without a sign of life both sides stop."""

    limit_s: float
    robots: dict[str, list[str]]
    bodies: list[str]
    state: StateMessage
    protocol: str = PROTOCOL


class _Spoken(msgspec.Struct, frozen=True):
    protocol: str = PROTOCOL


def spoken(raw: bytes) -> str:
    """The protocol that a message names, whatever else it says.

    Raises:
        msgspec.MsgspecError: it is no message.
    """
    return msgspec.json.decode(raw, type=_Spoken).protocol


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


def fits(message: StateMessage, robots: Mapping[str, Sequence[str]]) -> bool:
    """Whether a state says of all joints of these robots where they are and how fast, in finite numbers."""
    return all(
        len(values.get(name, ())) == len(joints) and all(map(isfinite, values[name]))
        for values in (message.positions, message.velocities)
        for name, joints in robots.items()
    )


def poses_from(message: StateMessage) -> dict[str, Array]:
    """The poses (4, 4) of the bodies that are seen; what is no pose of finite numbers is not seen."""
    return {
        name: np.array(pose).reshape(4, 4)
        for name, pose in message.bodies.items()
        if len(pose) == POSE and all(map(isfinite, pose))
    }
