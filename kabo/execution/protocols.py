"""What the executor asks of a robot and of a sensor: a user implements these few methods for hardware."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from kabo.arrays import Array
from kabo.errors import KaboError
from kabo.execution.motions import Motion


class RobotFailed(KaboError):
    """A robot that cannot be driven any more: it was lost, or it refuses; a run ends with this reason (exit code 7)."""

    exit_code = 7


@dataclass(frozen=True)
class RobotState:
    """What is measured of all robots of a cell at one time.

    Attributes:
        time: on the robots' clock [s].
        motion_time: how far the motion that is followed has come, on its own clock [s].
        moving: whether a motion is being followed; false when it has ended, or has been stopped.
        positions: values of all joints by robot, in the order of `Robot.joint_names` [rad or m].
        velocities: theirs [rad/s or m/s].
        pressing: robots whose hand presses, with its force [N].
        still: robots whose hand does not move.
    """

    time: float
    motion_time: float
    moving: bool
    positions: Mapping[str, tuple[float, ...]]
    velocities: Mapping[str, tuple[float, ...]]
    pressing: Mapping[str, float] = field(default_factory=dict)
    still: frozenset[str] = frozenset()


class Robot(Protocol):
    """All robots of a scene, which share a clock; no method waits but `wait`.

    Each may raise `RobotFailed`, which ends a run with its reason. Whatever else is raised, robots are asked to stop before
    it leaves the executor.
    """

    def follow(self, motion: Motion) -> None:
        """Begins to follow the trajectories of a motion, all on one clock."""

    def stop(self) -> None:
        """Slows down along the path, within all limits, until all robots stand; hands hold what they hold."""

    def grip(self, robot: str, bodies: tuple[str, ...]) -> None:
        """A hand presses with its force, to hold bodies that are between its fingers."""

    def release(self, robot: str, bodies: tuple[str, ...]) -> None:
        """A hand presses no more; its fingers follow trajectories again."""

    def state(self) -> RobotState:
        """What is measured now."""

    def wait(self, seconds: float) -> None:
        """Lets time pass."""


@runtime_checkable
class PacedRobot(Robot, Protocol):
    """Robots whose clock can be slowed down while they move; others are stopped where they would have to be slower."""

    def pace(self, rate: float) -> bool:
        """Goes to another rate of the motion's clock, above 0 and at most 1, within all limits; whether it does."""


class Sensor(Protocol):
    """Answers what only the world knows."""

    def resolve(self, formula: str, outcomes: tuple[str, ...]) -> str | None:
        """The outcome of a formula that a node branches on, one of `outcomes`; None: nothing was measured."""

    def value(self, term: str) -> object | None:
        """The value of a term that a node delivers; None: nothing was measured."""

    def poses(self) -> Mapping[str, Array]:
        """The poses (4, 4) in the world of the movable bodies that are seen now, by name."""


@runtime_checkable
class TellingSensor(Sensor, Protocol):
    """A sensor that can say why it said nothing; of others the reason of a stop has what was asked, and no more."""

    def why(self, asked: str) -> str | None:
        """Why what was asked last was not measured, as the end of a sentence; None: it does not know."""


def not_measured(sensor: Sensor, asked: str) -> str:
    """The sentence that something was not measured, with the reason if the sensor tells one."""
    why = sensor.why(asked) if isinstance(sensor, TellingSensor) else None
    return f"{asked} was not measured" + ("" if why is None else f": {why}")


def picture_period(sensor: Sensor) -> float:
    """The time between two pictures of a sensor's camera, by its attribute `rate` [Hz]; without one it always sees [s]."""
    rate = getattr(sensor, "rate", None)
    return 0.0 if rate is None else 1.0 / float(rate)
