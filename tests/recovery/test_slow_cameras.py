"""Cameras that see less often than is looked: what they see counts, and is in the log, whenever it was seen."""

import pytest

import kabo
from kabo.execution import (
    Answer,
    ExecutionSettings,
    Interruption,
    KinematicInstruments,
    KinematicRobot,
    SimulatedSensors,
    execute,
    true_start,
)
from kabo.language import CameraDescription, SensorsDescription, TruthDescription
from kabo.plan import Plan
from kabo.recovery import Replanner
from kabo.scene import Scene
from tests.recovery.test_surprises import stacked as stacked  # noqa: PLC0414 - a fixture


@pytest.mark.parametrize("rate", [0.5, 10.0, 30.0])
def test_after_a_surprise_what_a_slow_camera_sees_is_not_said_to_be_unseen(
    stacked: tuple[kabo.Problem, Scene, Plan], rate: float
) -> None:
    problem, scene, plan = stacked
    truth = TruthDescription(displaced={"o2": ((0.03, 0.0, 0.0), 0.0)})
    robot = KinematicRobot(scene, true_start(scene, scene.start, truth, 0))
    camera = CameraDescription(scene.movable, position=1e-5, rate=rate)
    sensor = SimulatedSensors(SensorsDescription("camera", {}, camera), KinematicInstruments(robot, truth), truth)
    recovery = Replanner(problem, scene, memo=kabo.Memo.of_plan(problem, plan))
    run = execute(plan, scene, robot, sensor, recovery=recovery, settings=ExecutionSettings(log_rate=20.0))
    assert run.reached_goal, run.reason
    states = list(run.log.of("state"))
    assert {name for each in states for name in each["bodies"]} == set(scene.movable)
    seen = sum(bool(each["bodies"]) for each in states)
    assert seen >= 0.9 * min(1.0, rate / 20.0) * len(states), "each picture is in the log"


def test_bodies_that_a_camera_does_not_see_are_taken_to_be_at_their_places(
    stacked: tuple[kabo.Problem, Scene, Plan],
) -> None:
    _, scene, plan = stacked
    robot = KinematicRobot(scene)
    camera = CameraDescription(("o2",))
    sensor = SimulatedSensors(SensorsDescription("camera", {}, camera), KinematicInstruments(robot))
    run = execute(plan, scene, robot, sensor)
    assert run.reached_goal, run.reason


def test_while_nobody_looks_no_body_gets_lost(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    """Robots' clocks go on while an answer is made, or while a sensor measures."""
    problem, scene, plan = stacked
    truth = TruthDescription(displaced={"o2": ((0.03, 0.0, 0.0), 0.0)})
    robot = KinematicRobot(scene, true_start(scene, scene.start, truth, 0))

    class Slow(Replanner):
        def answer(self, interruption: Interruption) -> Answer:
            robot.wait(4.96)
            return super().answer(interruption)

    camera = CameraDescription(scene.movable, dropout=0.3, rate=10.0)
    sensor = SimulatedSensors(SensorsDescription("camera", {}, camera), KinematicInstruments(robot, truth), truth)
    recovery = Slow(problem, scene, memo=kabo.Memo.of_plan(problem, plan))
    run = execute(plan, scene, robot, sensor, recovery=recovery)
    assert run.reached_goal, run.reason


def test_what_a_slow_and_noisy_camera_cannot_tell_by_a_hundred_looks_is_a_surprise(
    stacked: tuple[kabo.Problem, Scene, Plan],
) -> None:
    """Robots wait for as many pictures as of a fast camera: they set out before they could tell."""
    _, scene, plan = stacked
    robot = KinematicRobot(scene)
    camera = CameraDescription(scene.movable, position=0.02, rate=2.0)
    sensor = SimulatedSensors(SensorsDescription("camera", {}, camera), KinematicInstruments(robot))
    run = execute(plan, scene, robot, sensor)
    assert run.surprise is not None and robot._follower.motion is None
    looked = next(run.log.of("looked"))
    assert max(looked["bodies"].values()) >= 99


def test_between_two_pictures_what_was_seen_last_errs_as_much_as_it_did_then(
    stacked: tuple[kabo.Problem, Scene, Plan],
) -> None:
    """One look says nothing with such noise, and none of the looks between two pictures says more."""
    _, scene, plan = stacked
    robot = KinematicRobot(scene)
    camera = CameraDescription(scene.movable, position=0.01)
    sensor = SimulatedSensors(SensorsDescription("camera", {}, camera), KinematicInstruments(robot))
    run = execute(plan, scene, robot, sensor)
    assert run.reached_goal, run.reason
