"""Pouring: a bottle in the hand above a cup."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, Refusal, extra, tool_frame
from kabo.language import load_scene_description
from kabo.language.scene_description import Shape
from kabo.scene import attachment, link_poses, load_scene
from kabo.scene.transforms import inverse
from kabo.tasks.core import Result
from kabo.tasks.robots import Pour, Stretch, TaskScene
from kabo.tasks.robots.motion.targets import frame_for, pose_target
from kabo.tasks.robots.stages.poses import from_rpy
from kabo.tasks.robots.stages.pouring import MAX_DEVIATION, MAX_ROTATION
from tests.tasks.robots.test_stages import answers, values

SCENE = Path(__file__).resolve().parents[4] / "examples" / "bottle_pouring" / "scene.yaml"
RIM, LID = np.array([0.55, 0.30, 0.1]), 0.24
TILT, OFFSET = 1.9, (0.0, 0.02)
LEFT = np.array([0.0, 1.0, 0.0])


@cache
def above() -> TaskScene:
    """The bottle is in the hand, upright, to the right of the cup."""
    scene = load_scene(load_scene_description(SCENE))
    first = TaskScene.of(GeometryServer(scene).context(), scene.start)
    first = first.at("arm", [*first.configuration("arm")[:-1], 0.03])
    bottle, tool = np.eye(4), np.eye(4)
    bottle[:3, 3] = RIM + (0.0, -0.1, 0.06)
    tool[:3, :3] = from_rpy((0.0, np.pi / 2, 0.0))
    tool[:3, 3] = bottle[:3, 3] + (0.0, 0.0, 0.12)
    found = next(iter(pose_target(first, "arm", frame_for(first, "arm", "tool.tcp"), tool).batches()))
    for at in found:
        held = attachment("arm.tool0", inverse(at.pose(tool_frame(first.robot("arm")))) @ bottle)
        there = first.at("arm", at.q).placing("bottle", held)
        if there.hit("arm") is None:
            return there
    raise AssertionError("no configuration reaches the place above the cup")


def pour(scene: TaskScene, **properties: Any) -> Any:
    given = {"towards": np.pi / 2, "tilt": TILT, "offset": OFFSET} | properties
    stage = Pour("pour", robot="arm", object="bottle", container="cup", **given)
    (answer,) = answers(stage.forward(scene, values(stage), 0))
    return answer


def poured() -> tuple[Stretch, Stretch, Stretch]:
    answer = pour(above(), pause=2.5)
    assert isinstance(answer, Result), answer
    return answer.motion


def bottle(q: Any) -> np.ndarray:
    """The pose (4, 4) of the bottle in the hand."""
    scene = above()
    held = scene.situation.attachment("bottle")
    from kabo.scene.transforms import transform

    return link_poses(scene.robot("arm"), tuple(q))["tool0"] @ transform(held.position, held.quaternion)


def between(each: Stretch) -> list[np.ndarray]:
    return [a + (b - a) * s for a, b in zip(each.path, each.path[1:], strict=False) for s in np.linspace(0, 1, 9)]


def test_it_ends_as_it_began_after_a_pause() -> None:
    there, still, back = poured()
    assert back.end == there.start == tuple(above().situation.configuration("arm"))
    assert back.waypoints == there.waypoints[::-1]
    assert still.waypoints == (there.end,)
    assert still.seconds == 2.5


def test_the_lid_is_by_the_rim_and_tilted_when_it_pours() -> None:
    there, _, _ = poured()
    pose = bottle(there.end)
    assert pose[:3, 3] + LID * pose[:3, 2] == pytest.approx(RIM + (0.0, 0.0, 0.02), abs=1e-5)
    assert np.arccos(pose[2, 2]) == pytest.approx(TILT, abs=1e-5)


def test_it_tilts_only_about_the_axis_and_never_farther() -> None:
    there, _, _ = poured()
    for q in between(there):
        up = bottle(q)[:3, 2]
        assert abs(up[0]) <= MAX_ROTATION  # the axis about which it tilts is x
        assert np.arccos(np.clip(up[2], -1, 1)) <= TILT + MAX_ROTATION


def test_the_lid_stays_by_its_path_between_way_points_too() -> None:
    from kabo.tasks.robots.motion.pour_path import PourPath

    start = bottle(poured()[0].start) @ (0, 0, LID, 1)
    path = PourPath((start[1], start[2], 0.0), (RIM[1] + OFFSET[0], RIM[2] + OFFSET[1], TILT))
    curve = path.at(np.linspace(0, 1, 4001) ** 5)[:, :2]
    for q in between(poured()[0]):
        lid = bottle(q) @ (0, 0, LID, 1)
        assert abs(lid[0] - RIM[0]) <= MAX_DEVIATION
        assert np.linalg.norm(curve - lid[1:3], axis=1).min() <= 2 * MAX_DEVIATION


def test_its_shape_matters() -> None:
    assert poured()[0].exact


def test_backward_it_is_the_same() -> None:
    stage = Pour(
        "pour", robot="arm", object="bottle", container="cup", towards=[0, 3, 0], tilt=TILT, offset=OFFSET
    )
    (forward,) = answers(stage.forward(above(), values(stage), 0))
    (backward,) = answers(stage.backward(above(), values(stage), 0))
    assert forward.motion == backward.motion


def test_what_is_not_held_is_not_poured() -> None:
    scene = above()
    answer = pour(scene.placing("bottle", attachment("world", scene.pose("bottle"))))
    assert isinstance(answer, Refusal)
    assert answer.comment == "arm does not hold bottle"


def test_a_lid_beside_the_cup_is_refused() -> None:
    answer = pour(above(), towards=0.0)
    assert isinstance(answer, Refusal)
    assert "beside cup" in answer.comment


def test_what_is_in_the_way_is_named() -> None:
    # Where the bottle's bottom swings to, and the bottle is not now.
    low = bottle(poured()[0].end)[:3, 3]
    wall = extra("wall", "world", Shape("box", size=(0.02, 0.02, 0.02)), tuple(float(v) for v in low))
    answer = pour(above().adding(wall))
    assert isinstance(answer, Refusal)
    assert answer.reason == "collision"
    assert "wall" in answer.comment


def test_a_rim_out_of_reach_is_told_with_how_far_the_path_goes() -> None:
    answer = pour(above(), offset=(1.2, 0.0))
    assert isinstance(answer, Refusal)
    assert answer.reason in ("out_of_reach", "constraint")
    assert "%" in answer.comment


def test_without_a_pause_there_is_none() -> None:
    answer = pour(above(), pause=0.0)
    assert len(answer.motion) == 2


def test_a_feature_that_is_not_there_is_told() -> None:
    with pytest.raises(ValueError, match="no feature 'cap'"):
        pour(above(), lid="cap")


def test_equal_questions_have_equal_answers() -> None:
    assert pour(above()).motion == pour(replace(above())).motion
