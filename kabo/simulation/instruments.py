"""What is measured in physics: the force at a wrist, contacts, poses; without errors, which sensors add."""

from collections.abc import Mapping

from kabo.arrays import Array
from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.execution.bound_sensors import Reading
from kabo.language import Measurement, SensorsDescription
from kabo.simulation.simulated_robot import SimulatedRobot


class PhysicsInstruments:
    """Instruments of the robots of a scene in physics.

    Args:
        robot: the robots.
        sensors: what is measured, which is checked; None: whatever is asked.

    Raises:
        InputError: a contact is of a link that no robot has.
    """

    def __init__(self, robot: SimulatedRobot, sensors: SensorsDescription | None = None) -> None:
        self.robot = robot
        self.seconds = SensorsDescription("", {}).weight_seconds if sensors is None else sensors.weight_seconds
        if sensors is not None:
            _require_links(robot, sensors)

    @property
    def time(self) -> float:
        """Of physics [s]."""
        return self.robot.physics.time

    def read(self, measurement: Measurement) -> Reading:
        """A mass by the force at the wrist that holds it [kg], None if none does; whether two things touch."""
        if measurement.kind == "weight":
            return self._weight(measurement.things[0])
        if measurement.kind == "contact":
            return self._touch(*measurement.things)
        return None

    def why(self, measurement: Measurement) -> str | None:
        """Why there is no reading: only what a hand holds is weighed."""
        body = measurement.things[0]
        return (
            f"no hand holds {body}" if measurement.kind == "weight" and self.robot.holder(body) is None else None
        )

    def _weight(self, body: str) -> float | None:
        """What the wrist feels on average at rest [K 3.3.3], less other bodies in this hand as the scene has them."""
        robot, physics = self.robot, self.robot.physics
        hand = robot.holder(body)
        if hand is None:
            return None
        count = max(1, round(self.seconds / robot.settings.timestep))
        total = 0.0
        for _ in range(count):
            robot.wait(robot.settings.timestep)
            total += physics.carried(hand)
        others = sum(physics.expected_mass(each) for each in robot.held_by(hand) if each != body)
        return total / count - others

    def _touch(self, first: str, second: str) -> bool:
        def fits(name: str, thing: str) -> bool:
            return thing == name or thing.startswith(f"{name}.")

        pairs = [contact.things for contact in self.robot.physics.contacts()]
        return any(
            (fits(first, one) and fits(second, two)) or (fits(first, two) and fits(second, one))
            for one, two in pairs
        )

    def poses(self) -> Mapping[str, Array]:
        """Where all movable bodies are."""
        return self.robot.poses()


def _require_links(robot: SimulatedRobot, sensors: SensorsDescription) -> None:
    for binding in sensors.bindings.values():
        for thing in binding.measurement.things:
            name, dot, link = thing.partition(".")
            links = robot.scene.robots[name].links if dot else {}
            if dot and link not in links:
                place = binding.place
                text = f'{name} has no link "{link}"'
                line, column = (1, 1) if place is None else (place.line, place.column)
                raise InputError([Diagnostic(sensors.file, line, column, text, did_you_mean(link, links))])
