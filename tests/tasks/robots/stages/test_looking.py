"""The stage `Look`: the camera sees the object where the arm goes, and a refusal says what hides it, or what is missing."""

from collections.abc import Callable
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np
import pytest

from kabo.geometry_server import Refusal, View
from kabo.scene import Sensor
from kabo.tasks.core import InitialisationError, Result, Task
from kabo.tasks.core.model.properties import PropertyResolver
from kabo.tasks.robots import STAGES, TaskScene, check_meaning
from kabo.tasks.robots.stages.looking import Look
from tests.tasks.robots.test_library import solve

OPEN, COVERED, FORCE = (
    "inspection/three_boxes.yaml",
    "inspection/three_boxes_covered.yaml",
    "force_sensing/n2.yaml",
)
First = Callable[..., TaskScene]


def looks(scene: TaskScene, **properties: Any) -> Any:
    stage = STAGES["Look"]("look", **{"robot": "arm", "object": "box_2", **properties})
    assert isinstance(stage, Look)
    return stage.forward(scene, PropertyResolver(stage.properties).values({}), 0)


def with_camera(scene: TaskScene, **changes: Any) -> TaskScene:
    """The scene with another camera on the arm."""
    world = scene.context.scene
    sensor: Sensor = replace(world.robots["arm"].sensors["eye"], **changes)
    robot = replace(world.robots["arm"], sensors={"eye": sensor})
    other = replace(world, robots={**world.robots, "arm": robot}, memory={})
    from kabo.geometry_server import GeometryServer

    return TaskScene.of(GeometryServer(other).context(), other.start)


def test_the_camera_sees_the_object_from_where_the_arm_goes(first_scene: First) -> None:
    scene = first_scene(OPEN)
    for name in ("box_1", "box_2", "box_3"):
        found = next(each for each in looks(scene, object=name) if isinstance(each, Result))
        robot = scene.robot("arm")
        view = View(scene.context.surroundings, scene.situation, robot, robot.sensors["eye"], name)
        assert view.unseen(found.scene.configuration("arm")) is None
        assert found.scene.hit("arm") is None
        assert found.motion[0].end == found.scene.situation.configuration("arm")
        assert found.cost > 0.0


def test_further_answers_are_other_viewpoints(first_scene: First) -> None:
    found = [each for each in islice(looks(first_scene(OPEN)), 40) if isinstance(each, Result)]
    assert len({each.scene.situation.robots["arm"] for each in found}) == len(found) > 3


def test_the_same_scene_gives_the_same_viewpoints_wherever_the_arm_is(first_scene: First) -> None:
    scene = first_scene(OPEN)
    first, second = (
        next(each for each in looks(at) if isinstance(each, Result))
        for at in (scene, scene.at("arm", [0.3, *scene.configuration("arm")[1:]]))
    )
    assert first.scene.situation.robots["arm"] == second.scene.situation.robots["arm"]


def test_what_covers_the_object_is_named_in_the_refusal(first_scene: First) -> None:
    found = list(looks(first_scene(COVERED)))
    assert all(isinstance(each, Refusal) for each in found)
    hidden = [each for each in found if each.reason == "hidden"]
    assert ("arm.palm", "panel") in {pair for each in hidden for pair, _ in each.pairs}
    assert {each.comment for each in hidden} >= {"box_2 is hidden by panel"}
    behind_the_panel = [each for each in hidden if each.pairs[0][0][1] == "panel"]
    context = first_scene(COVERED).context
    assert all(each.question is not None and each.question.passes(context, "panel") for each in behind_the_panel)


def test_a_camera_that_cannot_see_so_far_says_so(first_scene: First) -> None:
    near = with_camera(first_scene(OPEN), near=0.02, far=0.03)
    reasons = {each.reason for each in looks(near, object="box_1") if isinstance(each, Refusal)}
    assert reasons <= {"out_of_view", "collision"}
    far = with_camera(first_scene(OPEN), near=5.0, far=5.5)
    (only,) = looks(far, object="box_1")
    assert only.reason == "out_of_reach"


def test_an_object_beyond_arm_and_range_is_refused_with_a_proof(first_scene: First) -> None:
    scene = first_scene(OPEN)
    held = replace(scene.situation.attachment("box_1"), position=(4.0, 0.0, 0.4))
    stage = STAGES["Look"]("look", robot="arm", object="box_1")
    refused = stage.refute(scene.context, scene.placing("box_1", held).situation)
    assert refused.proof and refused.reason == "out_of_reach" and 1.0 < refused.missing < 4.0
    assert stage.refute(scene.context, scene.situation) is None


def test_a_robot_without_a_camera_goes_to_the_named_configuration_or_stays(first_scene: First) -> None:
    scene = first_scene(FORCE)
    (there,) = looks(scene, object="cup_1", at="weigh")
    weigh = scene.robot("arm").configurations["weigh"]
    assert np.allclose(there.scene.configuration("arm")[: len(weigh)], weigh)
    (here,) = looks(scene, object="cup_1")
    assert here.motion == () and here.scene.situation == scene.situation


def test_the_procedure_sense_ends_where_the_camera_sees(first_scene: First) -> None:
    scene = first_scene(OPEN)
    found = solve(scene, "sense", robot="arm", object="box_3")[0]
    robot = scene.robot("arm")
    view = View(scene.context.surroundings, scene.situation, robot, robot.sensors["eye"], "box_3")
    assert view.unseen(found.end.scene.configuration("arm")) is None


def test_a_camera_that_the_robot_lacks_is_an_error(first_scene: First) -> None:
    look = STAGES["Look"]("look", robot="arm", object="box_1", sensor="ey")
    with pytest.raises(InitialisationError, match="arm has no sensor 'ey'; it has eye"):
        check_meaning(Task("t", STAGES["CurrentState"]("now"), look), first_scene(OPEN).context.scene)
