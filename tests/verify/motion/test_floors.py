"""The verifier's own proof that a base stays on its floor, against dense sampling, and plans that leave it."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.language import load_scene_description
from kabo.plan import Segment
from kabo.scene import load_scene
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.floors import Floor, check_floor, floor_of, outside
from tests.support.carts import cart

HALLS = (
    "box: [3, 2, 0.1]",
    "cylinder: {radius: 1.4, height: 2}",
    "sphere: {radius: 1.5}",
    "box: [2.5, 2.5, 1], pose: {rpy: [0, 0, 0.6]}",
)
numbers = st.floats(-1.0, 1.0)
poses = st.tuples(numbers, numbers, st.floats(-6.0, 6.0))


@pytest.fixture(scope="module", params=HALLS)
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Arm, Floor]:
    """The cart as the verifier sees it, and its floor."""
    folder: Path = tmp_path_factory.mktemp("cart")
    cart(folder, "position: [0.1, -0.1, 0], moves: {within: hall}", hall=request.param)
    scene = load_scene(load_scene_description(folder / "scene.yaml"))
    arm = Arm(scene.robots["cart"])
    floor = floor_of(arm, scene.regions)
    assert floor is not None
    return arm, floor


def test_its_outline_and_its_edges_are_those_of_the_scene(made: tuple[Arm, Floor]) -> None:
    arm, floor = made
    drive = arm.robot.drive
    assert drive is not None
    for pose in ((0.0, 0.0, 0.0), (0.9, 0.5, 2.0), (-1.4, 0.2, -0.7)):
        world = arm.joint_poses((*pose, 0.0, 0.0))[floor.joint]
        found = outside(floor, np.array([world, world]), np.zeros(1))[0]
        assert found == pytest.approx(float(drive.outside(np.array([pose]))[0]), abs=1e-6)


@settings(max_examples=60)
@given(start=poses, goal=poses)
def test_the_farthest_place_of_a_way_is_found(made: tuple[Arm, Floor], start, goal) -> None:
    arm, floor = made
    ends = np.array([start, goal])
    rows = np.array([arm.joint_poses((*q, 0.0, 0.0))[floor.joint] for q in ends])
    told = outside(floor, rows, np.diff(ends[:, 2]))[0]
    drive = arm.robot.drive
    assert drive is not None
    shares = np.linspace(0.0, 1.0, 500)[:, None]
    worst = float(drive.outside((1.0 - shares) * ends[0] + shares * ends[1]).max())
    event("inside" if told <= 0 else "outside")
    assert worst <= told + 1e-6
    assert told <= worst + 5e-3


def test_a_segment_that_leaves_the_floor_is_told_and_one_of_the_gripper_is_not_asked(
    made: tuple[Arm, Floor],
) -> None:
    arm, floor = made
    joints, start = arm.robot.planned_joints, np.zeros(5)
    for far, count in ((0.2, 0), (2.0, 1)):
        waypoints = ((0.0,) * 5, (far, 0.0, 0.0, 0.0, 0.0))
        segment = Segment("cart", joints, waypoints, (0.0, 1.0), "move")
        found = list(check_floor("n0", segment, arm, floor, start))
        assert len(found) == count
        assert all("the base of cart leaves its floor hall by" in str(each) for each in found)
