"""Robots with `inverse_kinematics: analytic`: more candidates from a sample, all of one pose at once, a reason for none."""

from dataclasses import replace

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, candidate, grasp_stream, tool_frame
from kabo.geometry_server.candidates import closed_form_of
from kabo.geometry_server.frames import WORLD
from kabo.kinematics import rows_of, satisfied
from kabo.scene import Scene
from kabo.tasks.core import Result, Solution, State
from kabo.tasks.robots import TaskScene
from kabo.tasks.robots.motion.targets import pose_target
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
    tool, tree = tool_frame(scene.robots["right"]), scene.robots["right"].tree
    found = closed.samples(0, 8)
    poses = {tuple(np.round(at.pose(tool)[:3].ravel(), 5)) for at in found}
    assert len(poses) <= 8 and len(found) > 2 * len(poses)
    for at in found:
        assert satisfied(projected.rows, at.q, tree, 2e-6)
        assert np.all((tree.lower <= at.q) & (at.q <= tree.upper))
    again = closed.samples(0, 8)
    assert [at.q.tobytes() for at in again] == [at.q.tobytes() for at in found]


def test_a_scene_that_says_nothing_gets_the_closed_form(start: TaskScene, scene: Scene) -> None:
    described = first(BARTENDER).context.scene.robots["right"]
    assert described.inverse_kinematics == "automatic"
    assert closed_form_of(described) is not None
    assert closed_form_of(replace(described, inverse_kinematics="projection")) is None


def test_a_sample_that_is_not_found_pose_first_is_projected(start: TaskScene, scene: Scene) -> None:
    """A tilt within a narrow interval is nothing that a family aims at: few of its poses fulfil it."""
    closed = streams(start, scene)[1]
    tool = tool_frame(scene.robots["right"])
    narrow = rows_of("angle", tool.feature("approach"), WORLD.feature("up"), 1.0, 1.02)
    stream = replace(closed, rows=narrow)
    found = stream.samples(0, 30)
    assert stream._drawn(0, 30, None) is not None
    assert len(stream._drawn(0, 30, None)[1]) < len(found)
    tree = scene.robots["right"].tree
    assert all(satisfied(narrow, at.q, tree, 2e-6) for at in found)


def test_of_each_sample_the_branch_nearest_to_home_is_tried_first(start: TaskScene, scene: Scene) -> None:
    closed = streams(start, scene)[1]
    robot = scene.robots["right"]
    home, tool = np.array(robot.configurations["home"]), tool_frame(robot)
    first_ones, others = closed.batch(0), closed.batch(1)
    assert sorted(at.q.tobytes() for at in (*first_ones, *others)) == sorted(
        at.q.tobytes() for at in closed.samples(0, 64)
    )
    compared = 0
    for at in first_ones[:10]:
        rivals = [o for o in others if np.abs(o.pose(tool) - at.pose(tool)).max() < 1e-7]
        away = np.linalg.norm(at.q[: robot.planned] - home)
        assert all(np.linalg.norm(o.q[: robot.planned] - home) >= away - 1e-6 for o in rivals)
        compared += len(rivals)
    assert compared > 10


def test_few_poses_give_few_candidates() -> None:
    """The five-axis arm takes a block from above in two ways only, however many samples lead there."""
    given = first("stacked/n3.yaml")
    robot = replace(given.robot("mobile"), inverse_kinematics="analytic")
    name = sorted(given.context.scene.movable)[0]
    body, hand = given.context.scene.bodies[name], tuple(given.configuration("mobile")[robot.planned :])
    made = grasp_stream(robot, body, body.grasps["from_above"], given.pose(name), hand, 0)
    assert made is not None and 1 <= len(made.stream.batch(0)) <= 8
    assert len(made.stream.samples(0, 64)) > 50, "most samples lead somewhere within limits"


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
    assert answer.missing == pytest.approx(1.3, abs=0.5)
    assert answer.comment == f"the pose is {answer.missing:.3f} m out of reach for right"
