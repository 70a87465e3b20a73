"""Sensors: cameras on links of robots [docs/how-to/sensing.md]."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.errors import did_you_mean
from kabo.language.scene_description import RobotDescription, SensorDescription
from kabo.scene.transforms import transform
from kabo.scene.urdf_file import refusal


@dataclass(frozen=True)
class Sensor:
    """A camera of a robot: it looks from the origin of its own frame along z, with x to the right.

    `angles` are the halves of its field of view [rad]: one of a cone, or the horizontal and the vertical one of a
    pyramid. What it sees is wholly between `near` and `far` [m] from its origin. `exempt` are the links of the robot
    that may be in the way of its view: the one that carries it, and those that the scene allows.
    """

    name: str
    link: str
    link_T_sensor: Array  # (4, 4)
    angles: tuple[float, ...]
    near: float
    far: float
    exempt: frozenset[str]


def sensors_of(description: RobotDescription, links: Mapping[str, object]) -> dict[str, Sensor]:
    """The sensors of a robot by name.

    Raises:
        InputError: a sensor names a link that the robot does not have.
    """
    return {name: _sensor(each, links, description.name) for name, each in description.sensors.items()}


def _sensor(described: SensorDescription, links: Mapping[str, object], robot: str) -> Sensor:
    for link in (described.frame, *described.allowed):
        if link not in links:
            text = f'unknown link "{link}" of robot "{robot}", in its sensor "{described.name}"'
            raise refusal(described.place, text, did_you_mean(link, links))
    return Sensor(
        described.name,
        described.frame,
        transform(described.position, described.quaternion),
        tuple(angle / 2.0 for angle in described.field_of_view),
        *described.range,
        frozenset((described.frame, *described.allowed)),
    )


def beyond_angle(sensor: Sensor, points: Array) -> Array:
    """How far each point (N, 3), in the frame of the sensor, is outside of its field of view [rad]; negative inside."""
    x, y, z = points.T
    if len(sensor.angles) == 1:
        return np.asarray(np.arctan2(np.hypot(x, y), z) - sensor.angles[0])
    across = np.arctan2(np.abs(x), z) - sensor.angles[0]
    return np.asarray(np.maximum(across, np.arctan2(np.abs(y), z) - sensor.angles[1]))
