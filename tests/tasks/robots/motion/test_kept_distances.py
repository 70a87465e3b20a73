"""What is said where bodies would come nearer to each other than they are to be kept."""

from pathlib import Path

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, Refusal
from kabo.scene import load_scene
from kabo.tasks.robots import TaskScene
from kabo.tasks.robots.motion.kept_distances import least_distance, told_distance
from kabo.tasks.robots.motion.questions import MotionQuestion, along
from kabo.tasks.robots.motion.targets import frame_for, pose_target
from tests.support.small_robots import write_arm

PAIR = ("o1", "o2")


def test_a_distance_that_is_missing_is_told_with_what_is_to_be_kept():
    assert told_distance(PAIR, 0.0012, 0.003, 0.01) == "o1 and o2 are 1.2 mm apart, but 3 mm are to be kept"


@pytest.mark.parametrize("apart", [0.0403, 0.04001, 0.03999])
def test_a_distance_that_is_there_and_not_proven_is_no_contradiction(apart: float):
    """Not `40.3 mm apart, but 40 mm are to be kept`."""
    told = told_distance(PAIR, apart, 0.04, 0.01).partition(" (")[0]
    assert told.endswith(" apart, too near for a proof with this epsilon that 40 mm are kept")


def test_no_epsilon_is_proposed_that_no_command_takes():
    """The two are told as 40.1 and 40 mm, and what is left between them is 20 nm."""
    told = told_distance(PAIR, 0.04005001, 0.04004999, 0.01)
    assert "40.1 mm" in told and "40 mm" in told and "try" not in told


@pytest.mark.parametrize(("apart", "finer"), [(0.0494, "0.0094"), (0.3, "0.01"), (0.0403, "0.0003")])
def test_the_epsilon_that_is_proposed_fits_into_what_is_left(apart: float, finer: str):
    assert told_distance(PAIR, apart, 0.04, 0.02).endswith(f" (try --epsilon {finer})")


def test_the_distance_of_a_hand_is_not_that_of_where_the_robot_stands(tmp_path: Path):
    """A hand at a pose that no arm was found for was told to be as far away as it stood, `too near` at 351 mm."""
    write_arm(tmp_path)
    cup = "objects:\n  cup: {box: [0.1, 0.1, 0.1], pose: {position: [3, 0, 0.5]}}\n"
    (tmp_path / "scene.yaml").write_text("scene: s\nepsilon: 0.01\nrobots:\n  arm: {urdf: small.urdf}\n" + cup)
    made = load_scene(tmp_path / "scene.yaml")
    scene = TaskScene.of(GeometryServer(made).context(), made.start)
    surroundings, pose = scene.context.surroundings, np.eye(4)
    pose[:3, 3] = 2.9, 0.0, 0.5  # out of reach, beside the cup
    target = pose_target(scene, "arm", frame_for(scene, "arm", "arm.left"), pose)
    asked = MotionQuestion(scene, "arm", target=target)
    assert least_distance(Refusal.collision(("arm.left", "cup"), question=asked), surroundings) is None
    standing = along(scene, "arm", scene.situation.configuration("arm"))
    there = least_distance(Refusal.collision(("arm.left", "cup"), question=standing), surroundings)
    assert there is not None and there > 2.0
