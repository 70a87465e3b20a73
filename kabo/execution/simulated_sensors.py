"""Simulated sensors: instruments that read the truth, with noise, wrong answers, and bodies that a camera overlooks.

Every number is drawn from a stream of its own by seed, thing and count, so a run is the same whenever it is repeated.
"""

from collections.abc import Mapping
from math import ceil

import numpy as np

from kabo.arrays import Array
from kabo.execution.bound_sensors import BoundSensors, Instruments, Reading
from kabo.execution.kinematic import KinematicRobot
from kabo.execution.log import Log
from kabo.execution.looks import rotation
from kabo.language import CameraDescription, Measurement, SensorBinding, SensorsDescription, TruthDescription
from kabo.scene import Scene, attachment, world_T
from kabo.scene.state import Attachment, GeometricState
from kabo.streams import stream_key, uniforms

SAME_TIME = 1e-9  # [s]


class SimulatedSensors(BoundSensors):
    """A `Sensor` in a world that is simulated, whose truth the plan does not know.

    Args:
        sensors: what answers what, and how well.
        instruments: what reads the world without errors.
        truth: answers that no instrument reads; what it does not give is drawn by the seed.
        seed: of all errors.
        log: where each decision is written.
    """

    def __init__(
        self,
        sensors: SensorsDescription,
        instruments: Instruments,
        truth: TruthDescription | None = None,
        seed: int = 0,
        log: Log | None = None,
    ) -> None:
        super().__init__(sensors, instruments, log)
        self.truth, self.seed = truth or TruthDescription(), seed
        self._pictures = 0
        self._next_picture = 0.0  # [s]
        self._picture: tuple[float, Mapping[str, Array]] = (-1.0, {})  # the last one, and when it was taken [s]

    def look(self, binding: SensorBinding) -> Reading:
        """What is read for a binding, once, with the noise of a weight."""
        if binding.measurement.kind == "told":
            self._looks += 1
            return self._told(binding)
        found = super().look(binding)
        if binding.measurement.kind == "weight" and isinstance(found, float):
            found += self.sensors.weight_noise * float(self._normal("weight", binding.asked, self._looks, 1)[0])
        return found

    def _told(self, binding: SensorBinding) -> Reading:
        given = self.truth.answers.get(binding.asked)
        if given is not None:
            return given if binding.outcomes is not None else float(given)
        if binding.outcomes is None:
            return None
        drawn = float(self._uniform("truth", binding.asked, 0, 1)[0])
        return binding.outcomes[int(drawn * len(binding.outcomes))]

    def answer(self, binding: SensorBinding, outcomes: tuple[str, ...]) -> str | None:
        """The answer of one look, or another one, as often as the sensor is wrong."""
        found = super().answer(binding, outcomes)
        others = [each for each in outcomes if each != found]
        if found is None or not others or binding.wrong == 0.0:
            return found
        errs, which = self._uniform("wrong", binding.asked, self._looks, 2)
        return others[int(which * len(others))] if errs < binding.wrong else found

    def poses(self) -> Mapping[str, Array]:
        """What the camera sees: nothing between two of its pictures."""
        camera = self.sensors.camera
        if camera is None:
            return self.instruments.poses()
        now = self.instruments.time
        if now < self._next_picture - SAME_TIME:
            return self._picture[1] if now <= self._picture[0] + SAME_TIME else {}
        self._next_picture = ceil(now * camera.rate + SAME_TIME) / camera.rate
        self._pictures += 1
        true = self.instruments.poses()
        seen = {name: self._seen(camera, name, true[name]) for name in camera.bodies if name in true}
        self._picture = now, {name: pose for name, pose in seen.items() if pose is not None}
        return self._picture[1]

    def _seen(self, camera: CameraDescription, body: str, pose: Array) -> Array | None:
        """The pose of a body in the picture of now; None if it is overlooked."""
        if float(self._uniform("dropout", body, self._pictures, 1)[0]) < camera.dropout:
            return None
        drawn = self._normal("camera", body, self._pictures, 6)
        found = pose.copy()
        found[:3, 3] += camera.position * drawn[:3]
        found[:3, :3] = rotation(camera.angle * drawn[3:]) @ pose[:3, :3]
        return found

    def _uniform(self, kind: str, name: str, number: int, count: int) -> Array:
        drawn: Array = uniforms(stream_key("sensors", self.seed, kind, name), number, 1, count)[0]
        return drawn

    def _normal(self, kind: str, name: str, number: int, count: int) -> Array:
        return normals(self._uniform(kind, name, number, 2 * count))


def normals(drawn: Array) -> Array:
    """Half as many numbers of the normal distribution as were drawn in [0, 1) [Box, Muller 1958]."""
    first, second = drawn[0::2], drawn[1::2]
    return np.asarray(np.sqrt(-2.0 * np.log1p(-first)) * np.cos(2.0 * np.pi * second))


def true_start(scene: Scene, start: GeometricState, truth: TruthDescription, seed: int) -> GeometricState:
    """Where bodies truly are at first: off where the plan has them, along x and y of the world and about its z.

    Bodies that hang from another one or from a robot stay where they are.
    """
    changes: dict[str, tuple[float, ...] | Attachment] = {}
    fixed = {name for name, body in scene.bodies.items() if not body.movable}
    for name in scene.movable:
        if start.objects[name].parent != "world" and start.objects[name].parent not in fixed:
            continue
        drawn = normals(uniforms(stream_key("offset", seed, name), 0, 1, 6)[0])
        shift, turn = np.array([*(truth.position * drawn[:2]), 0.0]), truth.turn * float(drawn[2])
        given = truth.displaced.get(name)
        if given is not None:
            shift, turn = shift + np.array(given[0]), turn + given[1]
        if not shift.any() and turn == 0.0:
            continue
        pose = world_T(scene, start, name).copy()
        pose[:3, 3] += shift
        pose[:3, :3] = rotation(np.array([0.0, 0.0, turn])) @ pose[:3, :3]
        changes[name] = attachment("world", pose)
    return start.replace(changes)


class KinematicInstruments:
    """Instruments of a robot without forces: what a hand holds has its true mass; what touches is not known.

    Args:
        robot: the robot.
        truth: the masses; what it does not give is as the scene says.
    """

    def __init__(self, robot: KinematicRobot, truth: TruthDescription | None = None) -> None:
        self.robot, self.truth = robot, truth or TruthDescription()

    @property
    def time(self) -> float:
        """Of the robot [s]."""
        return self.robot.time

    def read(self, measurement: Measurement) -> Reading:
        """The mass of a body that a hand holds [kg]; None for all else."""
        if measurement.kind != "weight":
            return None
        body, scene = measurement.things[0], self.robot.scene
        robot = self.robot.world.objects[body].parent.partition(".")[0]
        if robot not in scene.robots:
            return None
        given = self.truth.masses.get(body, scene.bodies[body].mass)
        return None if given is None else float(given)

    def why(self, measurement: Measurement) -> str | None:
        """Why there is no reading: nothing without forces feels a contact, and only what a hand holds is weighed."""
        if measurement.kind != "weight":
            return "robots without forces feel no contact"
        body = measurement.things[0]
        held = self.robot.world.objects[body].parent.partition(".")[0] in self.robot.scene.robots
        return f"neither scene nor truth give the mass of {body}" if held else f"no hand holds {body}"

    def poses(self) -> Mapping[str, Array]:
        """Where all bodies are."""
        return self.robot.poses()


class NoInstruments:
    """Instruments of a plan without motions: all that is asked is told by the truth."""

    time = 0.0

    def read(self, measurement: Measurement) -> Reading:
        """Nothing is measured."""
        return None

    def poses(self) -> Mapping[str, Array]:
        """Nothing is seen."""
        return {}
