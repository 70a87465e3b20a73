"""Targets of one pose: what no robot of such lengths reaches is told without a sample, and nothing else is."""

import numpy as np
import pytest

from kabo.geometry_server import candidate
from kabo.tasks.robots import TaskScene
from kabo.tasks.robots.motion.targets import frame_for, pose_target
from tests.planner.gantry import gantry
from tests.tasks.robots.conftest import first

CASES = ["bartender/four_bottles.yaml", "stacked/n2.yaml", "waiter/two_cups.yaml", "gantry"]


@pytest.fixture(scope="module", params=CASES)
def here(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> TaskScene:
    """Arms with tables and strokes, one that drives, and a gantry."""
    if request.param != "gantry":
        return first(request.param)
    path = gantry(tmp_path_factory.mktemp("gantry"), things={"cube": (0.2, 0.0, 0.02)}, goal="K(at(cube, shelf))")
    return first(path)


def test_where_a_frame_can_be_is_never_said_to_be_out_of_reach(here: TaskScene) -> None:
    numbers = np.random.default_rng(7)
    for name, robot in here.context.scene.robots.items():
        links = [f"{name}.{link}" for link, its in robot.links.items() if its.joint > 0]
        low, high = np.maximum(robot.tree.lower, -4.0), np.minimum(robot.tree.upper, 4.0)
        for _ in range(100):
            at = candidate(robot, numbers.uniform(low, high))
            frame = frame_for(here, name, [None, *links][numbers.integers(len(links) + 1)])
            target = pose_target(here, name, frame, at.pose(frame))
            assert target._missing() <= 0.0


def test_what_lies_farther_than_all_lengths_together_gets_no_sample(here: TaskScene) -> None:
    for name in here.context.scene.robots:
        pose = np.eye(4)
        pose[:3, 3] = 30.0, 0.0, 0.5
        target = pose_target(here, name, frame_for(here, name, None), pose)
        assert list(target.batches()) == []
        told = target.unreached()
        assert told is not None and 20.0 < told.missing < 30.0
