"""What robots and sensors say, checked where it comes in: a robot or a sensor of a user's own may say what cannot be.

A number that is none would be compared with what is proven, and no comparison with it is true; a clock that stands still
would be waited for without end. Both end a run, with the reason.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import isfinite

import numpy as np

from kabo.arrays import Array
from kabo.execution.kernels.placed import distortion
from kabo.execution.protocols import PacedRobot, Robot, RobotFailed, RobotState, Sensor
from kabo.scene import Scene

STANDS_STILL = 1.0  # [s] that were waited in all, after which a clock that has not moved stands still
NO_FARTHER = 30.0  # [s] for which robots may say that they move, and come no farther on their motion
RIGID = 1e-3  # by which the axes of a pose may be longer or shorter than one, or not at right angles


class CheckedRobot:
    """A robot whose states are checked.

    Args:
        robot: the robot. scene: whose robots it is.
    """

    def __init__(self, robot: Robot, scene: Scene) -> None:
        self.robot = robot
        self.follow, self.stop, self.grip, self.release = robot.follow, robot.stop, robot.grip, robot.release
        self._lost = False
        self._last: RobotState | None = None
        self._joints = {name: own.joint_names for name, own in scene.robots.items()}
        self._time, self._waited = -np.inf, 0.0  # of the clock when it moved last, and what was waited since [s]
        # On the clock of the motion, where it does not rest, and when it came there [s]:
        self._farthest, self._came = -np.inf, 0.0

    def wait(self, seconds: float) -> None:
        """Lets time pass."""
        self._waited += seconds
        self.robot.wait(seconds)

    def state(self) -> RobotState:
        """What is measured now; of a robot that was lost, what was measured last.

        Raises:
            RobotFailed: it cannot be, or nothing goes on.
        """
        if self._lost and self._last is not None:
            return self._last
        try:
            found = self.robot.state()
            for fault in self._faults(found):
                raise RobotFailed(f"the robot is lost: {fault}")
        except RobotFailed:
            self._lost = True
            raise
        self._last = found
        return found

    def _faults(self, state: RobotState) -> Iterator[str]:
        if not (isfinite(state.time) and isfinite(state.motion_time)):
            yield f"its clock says {state.time}, and {state.motion_time} on that of the motion"
        for name, joints in self._joints.items():
            if name not in state.positions:
                yield f"its state does not say where {name} is"
            for what, values in (("value", state.positions[name]), ("velocity", state.velocities.get(name, ()))):
                if len(values) != len(joints) and (what == "value" or len(values) > 0):
                    yield f"its state has {len(values)} of the {len(joints)} joints of {name} ({', '.join(joints)})"
                wrong = [joint for joint, value in zip(joints, values, strict=False) if not isfinite(value)]
                if wrong:
                    yield f"the {what} of {wrong[0]} of {name} is no number"
        yield from self._rests(state)

    def _rests(self, state: RobotState) -> Iterator[str]:
        """That clocks stand still."""
        if state.time > self._time:
            self._time, self._waited = state.time, 0.0
        elif self._waited > STANDS_STILL:
            yield f"its clock has been at {state.time:.3f} s while it was waited for {self._waited:.1f} s"
        if not state.moving:
            self._farthest = -np.inf
        elif state.motion_time != self._farthest:
            self._farthest, self._came = state.motion_time, state.time
        elif state.time - self._came > NO_FARTHER:
            yield f"it moves, and has come no farther on its motion than {state.motion_time:.3f} s for {NO_FARTHER:.0f} s"


class CheckedPacedRobot(CheckedRobot):
    """A robot whose states are checked, and whose clock can be slowed down."""

    def __init__(self, robot: PacedRobot, scene: Scene) -> None:
        super().__init__(robot, scene)
        self.pace = robot.pace


def checked(robot: Robot, scene: Scene) -> Robot:
    """The robot, with states that are checked."""
    return CheckedPacedRobot(robot, scene) if isinstance(robot, PacedRobot) else CheckedRobot(robot, scene)


class CheckedPoses:
    """Where a sensor sees bodies.

    Args:
        sensor: the sensor. bodies: those that the scene moves; whatever else it sees is left out.
    """

    def __init__(self, sensor: Sensor, bodies: Collection[str]) -> None:
        self.sensor, self.bodies, self._lost = sensor, bodies, False
        distortion(np.eye(4)[None])  # the kernel is loaded now, not while robots move

    def __call__(self) -> dict[str, Array]:
        """The poses (4, 4) of bodies that are seen now; what has numbers that are none is not seen.

        Raises:
            RobotFailed: a pose is none: its form is another one, or it stretches or mirrors. Then nothing is seen any more.
        """
        if self._lost:
            return {}
        given = {name: pose for name, pose in self._given().items() if name in self.bodies}
        if _are_poses(poses := [*given.values()]):  # as ever: one look at all of them
            return dict(zip(given, poses, strict=True))
        try:
            found = {name: _pose(name, pose) for name, pose in given.items()}
        except RobotFailed:
            self._lost = True
            raise
        return {name: pose for name, pose in found.items() if np.isfinite(pose).all()}

    def _given(self) -> Mapping[str, Array]:
        return self.sensor.poses() or {}


def _are_poses(given: Sequence[Array]) -> bool:
    """Whether all are poses (4, 4), with numbers."""
    if not all(isinstance(each, np.ndarray) and each.shape == (4, 4) for each in given):
        return False
    poses = np.array(given, np.float64).reshape(-1, 4, 4)
    return not given or bool(distortion(poses) <= RIGID)


def _pose(name: str, given: Array) -> Array:
    """A pose (4, 4), which may have numbers that are none.

    Raises:
        RobotFailed: it is no pose.
    """
    pose = np.asarray(given, dtype=float)
    if pose.shape != (4, 4):
        raise RobotFailed(f"the sensor is lost: the pose of {name} has the form {pose.shape}, not (4, 4)")
    if not np.isfinite(pose).all():
        return pose
    if distortion(np.ascontiguousarray(pose[None])) > RIGID:
        text = (
            f"the sensor is lost: what it says of {name} is no pose: its axes are stretched, sheared or mirrored"
        )
        raise RobotFailed(text)
    return pose
