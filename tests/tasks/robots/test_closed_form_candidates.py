"""Robots with `inverse_kinematics: analytic`: more candidates from a sample, all of one pose at once, a reason for none."""

from dataclasses import replace

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, candidate, grasp_stream, tool_frame
from kabo.scene import Scene
from kabo.tasks.core import Result, Solution, State
from kabo.tasks.robots import TaskScene
from kabo.tasks.robots.targets import pose_target
from tests.tasks.robots.conftest import first
from tests.tasks.robots.test_stages import make, values

BARTENDER = "bartender/four_bottles.yaml"


@pytest.fixture(scope="module")
def scene() -> Scene:
    """The bartender's scene, with both arms in closed form."""
    given = first(BARTENDER).context.scene
    robots = {name: replace(robot, inverse_kinematics="analytic") for name, robot in given.robots.items()}
    return replace(given, robots=robots, memory={})


@pytest.fixture(scope="module")
def start(scene: Scene) -> TaskScene:
    return TaskScene.of(GeometryServer(scene, seed=0).context(0), scene.start)


def streams(start: TaskScene, scene: Scene):  # type: ignore[no-untyped-def]
    """The same grasps of the same bottle, projected and in closed form."""
    robot, body = scene.robots["right"], scene.bodies["bottle_4"]
    hand = tuple(start.configuration("right")[robot.planned :])
    family = next(iter(body.grasps.values()))
    pose = start.pose("bottle_4")
    plain = replace(robot, inverse_kinematics="projection")
    return [grasp_stream(each, body, family, pose, hand, 0).stream for each in (plain, robot)]


def test_a_sample_of_a_grasp_gives_all_branches_with_the_hand_at_its_place(start: TaskScene, scene: Scene) -> None:
    projected, closed = streams(start, scene)
    tool = tool_frame(scene.robots["right"])
    poses = [at.pose(tool) for at in projected.samples(0, 8)]
    found = closed.samples(0, 8)
    assert len(found) > 2 * len(poses)
    for at in found:
        assert min(np.abs(at.pose(tool) - pose).max() for pose in poses) < 1e-7
    for at in projected.samples(0, 8):
        turned = [np.abs((at.q - other.q + np.pi) % (2 * np.pi) - np.pi).max() for other in found]
        assert min(turned) < 1e-6, "the sample itself, whole turns aside"
    again = closed.samples(0, 8)
    assert [at.q.tobytes() for at in again] == [at.q.tobytes() for at in found]


def pose_of(start: TaskScene, shift: float) -> np.ndarray:
    """Where the right tool stands, so much farther out."""
    robot = start.robot("right")
    pose = candidate(robot, start.configuration("right")).pose(tool_frame(robot))
    pose[0, 3] += shift
    return pose


def test_one_pose_has_one_batch_with_all_configurations_the_nearest_first(start: TaskScene) -> None:
    tool = tool_frame(start.robot("right"))
    target = pose_target(start, "right", tool, pose_of(start, 0.0))
    (batch,) = target.batches()
    away = [np.abs(at.q - start.configuration("right")).sum() for at in batch]
    assert len(batch) >= 4 and away[0] < 1e-6 and away == sorted(away, key=lambda v: round(v, 6))
    assert target.unreached() is None


def test_a_pose_out_of_reach_is_told_in_metres(start: TaskScene) -> None:
    target = pose_target(start, "right", tool_frame(start.robot("right")), pose_of(start, 2.0))
    stage = make("ComputeIK", robot="right", ignore_collisions=True)
    wrapped = Solution(stage, State(start, {}, 1), State(start, {}, 2), 0.0)
    (answer,) = stage.transform(wrapped, values(stage, target=target), 0)
    assert not isinstance(answer, Result)
    assert answer.details.missing == pytest.approx(1.3, abs=0.5)
    assert answer.comment == f"the pose is {answer.details.missing:.3f} m out of reach for right"
