"""Where two robots meet: candidates fulfil the mate or the grasp for both, and are the same wherever they start."""

from collections.abc import Callable
from itertools import islice

import numpy as np
import pytest

from kabo.geometry_server import Refusal, candidate, tool_frame
from kabo.scene import attachment
from kabo.tasks.core import Result
from kabo.tasks.robots import TaskScene
from kabo.tasks.robots.stages.meeting import Meeting
from tests.tasks.robots.test_stages import answers, make, values

GEARBOX = "assembly/gearbox.yaml"
First = Callable[..., TaskScene]


def in_hand(scene: TaskScene, name: str, robot: str, *pose: tuple[float, ...]) -> TaskScene:
    at = np.eye(4)
    at[:3, :3], at[:3, 3] = np.array(pose[:3]), pose[3]
    return scene.placing(name, attachment(f"{robot}.tool0", at))


def holding(scene: TaskScene) -> TaskScene:
    """The pipe across the one hand, the bearing on the tip of the other, face away from it."""
    for robot, finger in (("robot_1", 0.046), ("robot_2", 0.0109)):
        scene = scene.at(robot, [*scene.configuration(robot)[:6], finger])
    scene = in_hand(scene, "o3", "robot_1", (0, 0, 1), (0, 1, 0), (-1, 0, 0), (-0.07, 0, 0.13))
    return in_hand(scene, "o2", "robot_2", (1, 0, 0), (0, -1, 0), (0, 0, -1), (0, 0, 0.152))


def asked(scene: TaskScene, **properties: object) -> list[object]:
    stage = make("SampleMeeting", monitors="x", robot="robot_1", object="o3", partner="robot_2", **properties)
    return answers(stage.generate(scene, values(stage), 0))


def met(scene: TaskScene, at: Meeting) -> tuple[np.ndarray, np.ndarray]:
    """The poses of pipe and bearing where the robots have met."""
    there = scene.at("robot_1", at.q).at("robot_2", at.other)
    return there.pose("o3"), there.pose("o2")


def test_where_they_meet_the_parts_are_as_the_mate_says(first_scene: First) -> None:
    scene = holding(first_scene(GEARBOX))
    (result,) = asked(scene, part="o2", mate="bearing_in_pipe")
    assert isinstance(result, Result)
    target = result.properties["target"]
    found = [at for batch in islice(target.batches(), 4) for at in batch]
    assert len(found) > 40
    for at in found:
        pipe, bearing = met(scene, at)
        between = np.linalg.inv(pipe) @ bearing
        assert between[:3, 3] == pytest.approx([0, 0, 0.09], abs=1e-5)
        assert between[:3, 2] == pytest.approx([0, 0, 1], abs=1e-5)
    assert any(target.refused(scene, at) is None for at in found)


def test_those_near_home_come_first(first_scene: First) -> None:
    scene = holding(first_scene(GEARBOX))
    (result,) = asked(scene, part="o2", mate="bearing_in_pipe")
    home = {name: np.array(scene.robot(name).configurations["home"]) for name in ("robot_1", "robot_2")}
    away = [
        max(np.abs(at.q[:6] - home["robot_1"]).max(), np.abs(np.array(at.other[:6]) - home["robot_2"]).max())
        for at in next(result.properties["target"].batches())
    ]
    assert away == sorted(away)
    assert away[0] < 1.5


def test_where_the_robots_stand_changes_nothing(first_scene: First) -> None:
    scene = holding(first_scene(GEARBOX))
    elsewhere = scene.at("robot_1", scene.configuration("robot_1") + [*[0.1] * 6, 0.0])
    first, second = (
        next(asked(each, part="o2", mate="bearing_in_pipe")[0].properties["target"].batches())
        for each in (scene, elsewhere)
    )
    assert [(*a.q, *a.other) for a in first] == [(*b.q, *b.other) for b in second]


def test_a_receiver_meets_by_each_family_that_is_its_own(first_scene: First) -> None:
    scene = in_hand(first_scene(GEARBOX), "o1", "robot_1", (1, 0, 0), (0, -1, 0), (0, 0, -1), (0, 0, 0.157))
    stage = make("SampleMeeting", monitors="x", robot="robot_1", object="o1", partner="robot_2")
    results = answers(stage.generate(scene, values(stage), 0))
    assert [result.comment for result in results] == ["inside", "inside_below"]
    at = next(at for batch in results[1].properties["target"].batches() for at in batch)
    there = scene.at("robot_1", at.q)
    tip = candidate(scene.robot("robot_2"), at.other).pose(tool_frame(scene.robot("robot_2"))) @ [0, 0, 0.14, 1]
    assert np.linalg.inv(there.pose("o1")) @ tip == pytest.approx([0, 0, 0.012, 1], abs=1e-5)


def test_a_meeting_without_the_part_in_the_hand_is_refused_by_a_proof(first_scene: First) -> None:
    scene = in_hand(first_scene(GEARBOX), "o3", "robot_1", (0, 0, 1), (0, 1, 0), (-1, 0, 0), (-0.07, 0, 0.13))
    (failure,) = asked(scene, part="o2", mate="bearing_in_pipe")
    assert isinstance(failure, Refusal)
    assert failure.comment == "robot_2 does not hold o2"
    assert failure.proof


def test_a_partner_without_a_grasp_is_refused_by_a_proof(first_scene: First) -> None:
    scene = in_hand(first_scene(GEARBOX), "o3", "robot_1", (0, 0, 1), (0, 1, 0), (-1, 0, 0), (-0.07, 0, 0.13))
    (failure,) = asked(scene)
    assert isinstance(failure, Refusal)
    assert failure.reason == "empty_family"
