"""What a hand holds limits its motion by force, friction and mass; what cannot be held at rest is refused."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, Refusal, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.planner.refine.legs import Leg, legs_of
from kabo.planner.refine.timing import duration, timed
from kabo.scene import Scene
from kabo.scene.robots import link_pose
from kabo.scene.transforms import transform
from kabo.tasks.procedures import GeometricProcedures
from kabo.tasks.robots.motion.held_bodies import held_by
from tests.tasks.conftest import DOMAINS, scene_of

PROBLEM = "stacked/n2.yaml"
CALL = GroundCall("restack", ("mobile", "o2", "stack_3"))
WEIGHT = 0.04 * 9.81  # [N]; friction is 0.5
GRAVITY = np.array([0.0, 0.0, -9.81])


def scene_with(force: float | None) -> Scene:
    scene = scene_of(PROBLEM)
    robot = scene.robots["mobile"]
    assert robot.gripper is not None
    return replace(scene, robots={"mobile": replace(robot, gripper=replace(robot.gripper, force=force))})


def procedures(force: float | None) -> GeometricProcedures:
    return GeometricProcedures(GeometryServer(scene_with(force)), (DOMAINS / PROBLEM).parent)


@cache
def legs(force: float | None) -> tuple[Leg, ...]:
    """The timed legs of one motion of a block to another stack."""
    server = procedures(force)
    start, context = Situation.of(server.scene.start), server.server.context()
    answer = server.call(CALL, start)
    assert isinstance(answer, Success)
    found = legs_of(context, start, timed(context, start, answer.motion))
    assert found is not None
    return tuple(found)


def loads(leg: Leg) -> np.ndarray:
    """|acceleration - gravity| of the block in the hand every few milliseconds, by pinocchio and differences."""
    part, motion = leg.part, leg.segment.trajectory
    assert motion is not None
    robot, at = part.scene.robot("mobile"), part.scene.situation.attachment("o2")
    hand, step = part.stretch.path[0, robot.planned :], 1e-4

    def place(time: float) -> np.ndarray:
        link = link_pose(robot, np.concatenate([motion.at(time), hand]), at.parent.partition(".")[2])
        return (link @ transform(at.position, at.quaternion))[:3, 3]

    times = np.arange(motion.times[0] + step, motion.times[-1] - step, 3.1e-3)
    second = [(place(t + step) - 2 * place(t) + place(t - step)) / step**2 for t in times]
    return np.linalg.norm(np.array(second) - GRAVITY, axis=1)


def carrying(force: float | None) -> list[Leg]:
    return [leg for leg in legs(force) if leg.arm and leg.part.scene.holder("o2") is not None]


def test_nothing_slips_and_weaker_hands_move_more_slowly() -> None:
    seconds = {force: duration([leg.segment for leg in legs(force)]) for force in (None, 40.0, 0.9, 0.81)}
    assert seconds[40.0] == seconds[None] < seconds[0.9] < seconds[0.81]
    most = max(float(loads(leg).max()) for leg in carrying(0.81))
    assert 0.9 * 0.5 * 0.81 / 0.04 < most <= 0.5 * 0.81 / 0.04
    assert max(float(loads(leg).max()) for leg in carrying(None)) > 0.5 * 0.9 / 0.04


def test_only_an_arm_that_holds_something_with_a_force_is_limited() -> None:
    assert all(leg.part.held is None for leg in legs(None))
    held = [leg.part.held is not None for leg in legs(0.9)]
    assert held == [leg in carrying(0.9) for leg in legs(0.9)] and any(held)
    bound = held_by(carrying(0.9)[0].part.scene, "mobile")
    assert bound is not None and bound.acceleration == pytest.approx(0.5 * 0.9 / 0.04)


def test_what_is_too_heavy_at_rest_is_refused_by_a_proof() -> None:
    server = procedures(1.99 * WEIGHT)
    answer = server.call(CALL, Situation.of(server.scene.start))
    assert isinstance(answer, Refusal) and answer.proof
    assert ("mobile cannot hold o2, even at rest: 0.04 kg weigh 0.392 N") in answer.comment
