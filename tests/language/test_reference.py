"""The pages of docs/reference/ about files name every key, constraint and procedure that the code reads."""

from pathlib import Path

import pytest

from kabo.language.constraint_kinds import CONSTRAINT_KINDS
from kabo.language.yaml import domain_file, exploration_file, problem_file, procedures
from kabo.language.yaml.scenes import bodies, drives, poses, robots, scene_file, sensors

REFERENCE = Path(__file__).parents[2] / "docs" / "reference"
PAGE = "".join(
    (REFERENCE / f"{page}.md").read_text() for page in ("files", "scenes", "explorations", "procedures")
)
KEYS = {
    *domain_file.DOMAIN_KEYS, *domain_file.ACTION_KEYS, *domain_file.FUNCTION_KEYS, *problem_file.PROBLEM_KEYS,
    *problem_file.OPTION_KEYS, *problem_file.BUDGET_KEYS, *scene_file.SCENE_KEYS, *scene_file.MATE_KEYS,
    *robots.ROBOT_KEYS, *robots.GRIPPER_KEYS, *robots.TOOL_KEYS, *bodies.BODY_KEYS, *bodies.REGION_KEYS,
    *bodies.GRASP_KEYS, *bodies.PLACEMENT_KEYS, *bodies.STROKE_KEYS, *poses.POSE_KEYS, *CONSTRAINT_KINDS,
    *procedures.library_names(), *drives.DRIVE_KEYS, drives.MOVES,
    *sensors.SENSOR_KEYS, *sensors.VIEW_KEYS, *exploration_file.EXPLORATION_KEYS, *exploration_file.TRIAL_KEYS,
    *exploration_file.PARAMETER_KEYS, *exploration_file.OUTCOME_KEYS, *exploration_file.VALIDITY_KEYS,
}  # fmt: skip


@pytest.mark.parametrize("word", sorted(KEYS))
def test_the_reference_names_every_key(word: str) -> None:
    assert f"`{word}`" in PAGE or f"`{word}(" in PAGE
