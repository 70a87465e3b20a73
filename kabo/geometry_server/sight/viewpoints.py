"""Viewpoints: configurations that bring an object into the middle of a camera's view, by projection on constraints.

The key of a stream depends only on the sensor and on where the object is, so the same viewpoints are tried in the same
order wherever the robot starts (docs/reference/plans.md#sharing).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.candidates import Stream, from_home
from kabo.geometry_server.configurations import Candidate
from kabo.geometry_server.driving.standing import standing_of
from kabo.geometry_server.frames import WORLD, Frame, carried_frame
from kabo.geometry_server.reachability import least_distance
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.kinematics import FrameFeature, rows_of, stacked
from kabo.language.scene_description import Feature
from kabo.scene import Body, Robot, Sensor
from kabo.streams import stream_key

_AXIS = Feature("line", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
_IMAGE = Feature("plane", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class ViewpointStream:
    """Configurations in which the axis of a sensor goes through the middle of an object, at a distance in its range."""

    stream: Stream
    sensor: Sensor
    middle: FrameFeature  # of the object

    def __iter__(self) -> Iterator[list[Candidate]]:
        number = 0
        while True:
            yield from_home(self.stream.robot, self.stream.batch(number))
            number += 1

    def missing(self) -> float:
        """A lower bound [m] of how far the object is beyond reach and range; 0 or less proves nothing."""
        if self.middle.joint:
            return -np.inf
        robot = self.stream.robot
        return least_distance(robot, sensor_frame(robot, self.sensor).moved(_AXIS), self.middle) - self.sensor.far


def sensor_frame(robot: Robot, sensor: Sensor) -> Frame:
    """The frame of a sensor on its robot's tree."""
    link = robot.links[sensor.link]
    return Frame(link.joint, link.joint_T_link @ sensor.link_T_sensor, {})


def viewpoints(
    surroundings: SceneSurroundings, situation: Situation, robot: Robot, sensor: Sensor, name: str, seed: int
) -> ViewpointStream:
    """The viewpoints of a sensor for an object that has a single pose in the situation, or hangs on the robot."""
    body = surroundings.scene.bodies[name]
    if name in situation.carried(robot.name):
        place = carried_frame(robot, body, situation.held(name))
    else:
        (pose,) = surroundings.poses(situation, name)
        place = Frame(WORLD.joint, pose, body.features)
    point, size = _middle(body)
    middle, camera = place.moved(point), sensor_frame(robot, sensor)
    low, high = _distances(sensor, size)
    parts = [
        rows_of("coincident", middle, camera.moved(_AXIS)),
        rows_of("height", middle, camera.moved(_IMAGE), low, high),
    ]
    numbers = [float(v) for v in np.round(place.joint_T_frame[:3], 9).ravel()]
    key = stream_key(seed, "look", robot.name, sensor.name, name, place.joint, *numbers)
    hand, standing = tuple(situation.configuration(robot.name)[robot.planned :]), standing_of(surroundings, robot)
    return ViewpointStream(Stream(robot, stacked(parts), key, hand, standing), sensor, middle)


def _middle(body: Body) -> tuple[Feature, float]:
    """The middle of a body's box in its own frame, and the radius of the ball around it that holds the body [m]."""
    corners: Array = body.mesh.vertices
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y, z = (float(v) for v in (low + high) / 2.0)
    return Feature("point", (x, y, z)), float(np.linalg.norm(corners - (low + high) / 2.0, axis=1).max())


def _distances(sensor: Sensor, size: float) -> tuple[float, float]:
    """The distances of the middle of a ball at which all of it is seen; without any, the sensor's whole range."""
    low, high = max(sensor.near + size, size / float(np.sin(min(sensor.angles)))), sensor.far - size
    return (low, high) if low < high else (sensor.near, sensor.far)
