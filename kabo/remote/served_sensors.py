"""Sensors of a robot server: what it measures for a client, and the `Sensor` of a client that asks it.

The truth stays with the server. A look is a request with the question and with what is to be read; a server that only
measures replies with a number or with yes or no, and one that knows how wrong its sensors are may reply with an answer.
"""

from collections.abc import Mapping
from typing import Protocol

from kabo.arrays import Array
from kabo.execution import BoundSensors, SimulatedSensors
from kabo.execution.bound_sensors import Reading, answer_of
from kabo.execution.log import Log
from kabo.language import Measurement, SensorBinding, SensorsDescription
from kabo.remote.zenoh_robot import ZenohRobot


class ServedSensors(Protocol):
    """What a robot server measures."""

    def look(self, asked: str, measurement: Measurement, outcomes: tuple[str, ...] | None) -> Reading:
        """One look: a number, yes or no, or one of the outcomes; None: nothing can be measured now."""

    def poses(self) -> Mapping[str, Array]:
        """The poses (4, 4) in the world of the bodies that are seen now."""


class ServedSimulation:
    """Simulated sensors as a server offers them: with their noise, their wrong answers, and the truth that they read."""

    def __init__(self, sensors: SimulatedSensors) -> None:
        self.sensors = sensors

    def look(self, asked: str, measurement: Measurement, outcomes: tuple[str, ...] | None) -> Reading:
        """What the sensor that answers this question finds; None if there is none for it here."""
        binding = self.sensors.sensors.bindings.get(asked)
        if binding is None or binding.measurement != measurement:
            return None
        if outcomes is not None and (binding.wrong > 0.0 or measurement.kind == "told"):
            return self.sensors.answer(binding, outcomes)
        return self.sensors.look(binding)

    def poses(self) -> Mapping[str, Array]:
        """What the camera sees."""
        return self.sensors.poses()


class RemoteSensors(BoundSensors):
    """A `Sensor` whose looks a robot server makes; bindings, and how often is looked, are of the client's file.

    Args:
        sensors: the bindings.
        robot: whose server is asked.
        log: where each decision is written.
    """

    def __init__(self, sensors: SensorsDescription, robot: ZenohRobot, log: Log | None = None) -> None:
        super().__init__(sensors, robot, log)
        self.robot = robot

    def answer(self, binding: SensorBinding, outcomes: tuple[str, ...]) -> str | None:
        """The answer of one look: the server's own, or that of what it reads."""
        reading = self.robot.look(binding.asked, binding.measurement, outcomes)
        found = reading if isinstance(reading, str) else answer_of(binding, reading)
        return found if found in outcomes else None

    def look(self, binding: SensorBinding) -> Reading:
        """What the server reads."""
        return self.robot.look(binding.asked, binding.measurement, None)
