"""A collision that is a contact is told with the AllowContact that is missing; other collisions are told as they are."""

from pathlib import Path

import pytest

import kabo

EXAMPLE = Path(__file__).resolve().parents[4] / "examples" / "pick_and_place"
TEXT = (EXAMPLE / "task.yaml").read_text()
HAND, SURFACE = (
    next(line for line in TEXT.splitlines(keepends=True) if f"name: allow contact of {what}" in line)
    for what in ("hand and object", "object and surface")
)
DOWN = (
    TEXT.split("  - {name: move to place")[0].replace("distance: [0.01, 0.1]", "distance: [0.1, 0.1]")
    + """
  - {name: down, stage: MoveRelative, direction: {vector: [0, 0, -LENGTH]}}
"""
)


def examples(folder, text):
    path = folder / "task.yaml"
    path.write_text(text)
    run = kabo.plan_task(path, EXAMPLE / "scene.yaml", max_solutions=1, timeout=60).content["runs"][0]
    assert run["explanation"] is not None
    return run["explanation"]["stage"], run["explanation"]["examples"]


@pytest.mark.parametrize(
    ("left_out", "stage", "told"),
    [
        (SURFACE, "pick/attach", "object – table: object rests on table there; if it may, AllowContact of both"),
        (HAND, "pick/close hand", "object: if the hand is to take it, AllowContact of arm and object"),
    ],
)
def test_a_contact_that_no_stage_permits_is_told_with_the_remedy(tmp_path, left_out, stage, told):
    blamed, said = examples(tmp_path, TEXT.replace(left_out, "", 1))
    assert blamed == stage
    assert all(told in each and each.endswith("is missing before this stage") for each in said), said


def test_what_is_put_down_without_permission_is_told_where_the_way_ends(tmp_path):
    blamed, said = examples(tmp_path, DOWN.replace("LENGTH", "0.1"))
    assert blamed == "down"
    assert any("object rests on table there; if it may, AllowContact of both" in each for each in said), said


def test_a_collision_that_is_no_contact_is_told_by_its_pair_alone(tmp_path):
    blamed, said = examples(tmp_path, DOWN.replace("LENGTH", "0.15"))
    assert blamed == "down" and "object – table" in said and not any("AllowContact" in each for each in said), said


@pytest.mark.parametrize("goal", ["{point: [0.5, -0.25, -0.1]}", "{point: [0.6, -0.3, 0.05]}, straight: true"])
def test_a_goal_that_is_blocked_for_the_hand_alone_is_told_by_its_pair(tmp_path, goal):
    start = TEXT.split("  - {name: open hand")[0]
    blamed, said = examples(tmp_path, start + f"  - {{name: go, stage: MoveTo, goal: {goal}}}\n")
    assert blamed == "go" and said and not any("AllowContact" in each for each in said), said
