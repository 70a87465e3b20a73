"""Robots and sensors of a user's own that say what cannot be, or fail: the run ends with the reason, and robots stop."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pytest

from kabo.arrays import Array
from kabo.execution import KinematicRobot, KnownTruth, RobotFailed, RobotState, execute
from kabo.execution.checked import CheckedRobot
from kabo.plan import Plan
from kabo.scene import Scene

LATER = 0.3  # [s]
NAN = float("nan")


class Misbehaving(KinematicRobot):
    """A robot whose states are `spoilt` after a while, or that fails there."""

    def __init__(self, scene: Scene, spoil: Callable[[RobotState], RobotState]) -> None:
        super().__init__(scene)
        self.spoil = spoil

    @property
    def stops(self) -> bool:
        return self._follower.stopping

    def state(self) -> RobotState:
        found = super().state()
        return self.spoil(found) if self.time > LATER else found


def no_number(state: RobotState) -> RobotState:
    return replace(state, positions={name: (NAN, *values[1:]) for name, values in state.positions.items()})


def too_few(state: RobotState) -> RobotState:
    return replace(state, positions={name: values[1:] for name, values in state.positions.items()})


def lost(state: RobotState) -> RobotState:
    raise RobotFailed("the bus is down")


def broken(state: RobotState) -> RobotState:
    raise OSError("the bus is down")


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (no_number, "the value of arm_joint_1 of mobile is no number"),
        (too_few, "5 of the 6 joints of mobile"),
        (lambda state: replace(state, positions={}), "does not say where mobile is"),
        (lambda state: replace(state, time=NAN), "its clock says nan"),
        (lambda state: replace(state, velocities={"mobile": (NAN,) * 6}), "the velocity of arm_joint_1 of mobile"),
        (lambda state: replace(state, time=LATER), "its clock has been at 0.300 s while it was waited for 1"),
        (lambda state: replace(state, motion_time=LATER), "no farther on its motion than 0.300 s for 30 s"),
        (lost, "the bus is down"),
    ],
)
def test_a_state_that_cannot_be_ends_the_run_and_stops_the_robots(
    stacked_plan: Plan, stacked_scene: Scene, spoil: Callable[[RobotState], RobotState], reason: str
) -> None:
    robot = Misbehaving(stacked_scene, spoil)
    if "no farther" in reason:  # it stands, and is on its path
        robot.wait = _waiting(robot)  # type: ignore[method-assign]
    run = execute(stacked_plan, stacked_scene, robot, KnownTruth(poses=robot.poses))
    assert not run.reached_goal and reason in run.reason
    assert robot.stops and run.surprise is None


def _waiting(robot: Misbehaving) -> Callable[[float], None]:
    """Time goes on, and from some time on the motion does not."""

    def wait(seconds: float) -> None:
        if robot.time <= LATER:
            KinematicRobot.wait(robot, seconds)
        else:
            robot.time += seconds

    return wait


def test_a_robot_that_has_rested_for_long_is_not_lost_when_it_begins(stacked_scene: Scene) -> None:
    robot = KinematicRobot(stacked_scene)
    state, seen = robot.state(), CheckedRobot(robot, stacked_scene)
    for time, moving in ((0.0, False), (100.0, True), (129.0, True)):
        robot.state = lambda time=time, moving=moving: replace(state, time=time, moving=moving)  # type: ignore[misc]
        assert seen.state().moving == moving
    robot.state = lambda: replace(state, time=131.0, moving=True)  # type: ignore[method-assign]
    with pytest.raises(RobotFailed, match="no farther on its motion than 0.000 s for 30 s"):
        seen.state()


def test_what_a_robot_raises_leaves_the_executor_when_the_robots_stop(
    stacked_plan: Plan, stacked_scene: Scene
) -> None:
    robot = Misbehaving(stacked_scene, broken)
    with pytest.raises(OSError, match="the bus is down"):
        execute(stacked_plan, stacked_scene, robot, KnownTruth(poses=robot.poses))
    assert robot.stops


def spoilt_poses(robot: KinematicRobot, spoil: Callable[[Array], object]) -> Callable[[], Mapping[str, Array]]:
    def poses() -> Mapping[str, Array]:
        found = robot.poses()
        return found if robot.time <= LATER else {name: spoil(pose) for name, pose in found.items()}  # type: ignore[misc]

    return poses


def failing(pose: Array) -> object:
    raise RuntimeError("the camera is unplugged")


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda pose: pose[:3], "has the form (3, 4), not (4, 4)"),
        (lambda pose: pose.T, "is no pose"),
        (
            lambda pose: pose @ np.diag([1.0, -1.0, 1.0, 1.0]),
            "is no pose: its axes are stretched, sheared or mirrored",
        ),
        (lambda pose: np.full((4, 4), NAN), "has not been seen for 1.0 s"),
    ],
)
def test_poses_that_are_none_end_the_run(
    stacked_plan: Plan, stacked_scene: Scene, spoil: Callable[[Array], object], reason: str
) -> None:
    robot = KinematicRobot(stacked_scene)
    run = execute(stacked_plan, stacked_scene, robot, KnownTruth(poses=spoilt_poses(robot, spoil)))
    assert not run.reached_goal and reason in run.reason and robot._follower.stopping


def test_a_sensor_that_raises_stops_the_robots(stacked_plan: Plan, stacked_scene: Scene) -> None:
    robot = KinematicRobot(stacked_scene)
    with pytest.raises(RuntimeError, match="unplugged"):
        execute(stacked_plan, stacked_scene, robot, KnownTruth(poses=spoilt_poses(robot, failing)))
    assert robot._follower.stopping


def test_lists_and_bodies_of_nobody_do_no_harm(stacked_plan: Plan, stacked_scene: Scene) -> None:
    robot = KinematicRobot(stacked_scene)

    def poses() -> Mapping[str, Array]:
        seen = {name: pose.tolist() for name, pose in robot.poses().items()}
        return {**seen, "marker_17": "lost"}  # type: ignore[dict-item]

    assert execute(stacked_plan, stacked_scene, robot, KnownTruth(poses=poses)).reached_goal


class Deaf(KinematicRobot):
    """It does not stop."""

    def stop(self) -> None:
        pass

    def state(self) -> RobotState:
        return replace(super().state(), moving=True, motion_time=self.time)


def test_nobody_plans_anew_for_robots_that_do_not_stop(stacked_plan: Plan, stacked_scene: Scene) -> None:
    robot = Deaf(stacked_scene)
    run = execute(stacked_plan, stacked_scene, robot, KnownTruth(poses=robot.poses), stop=lambda: robot.time > 1.0)
    assert run.reason == "it was asked to stop; robots still move 30 s after they were asked to stop"
    assert run.surprise is None
