"""How near two links of one robot come, as refusals say it: against distances that are known by construction."""

from dataclasses import replace
from pathlib import Path

import pytest

from kabo.geometry_server import GeometryServer, Refusal
from kabo.language import load_scene_description
from kabo.scene import load_scene
from kabo.tasks.core.model.stages import Stage
from kabo.tasks.refusals import Refusals
from kabo.tasks.robots import STAGES, TaskScene
from kabo.tasks.robots.motion.nearness import own_nearness
from kabo.tasks.robots.motion.questions import along
from tests.support.small_robots import write_arm

FINGERS = ("arm.left", "arm.right")  # boxes 1 cm wide, whose middles are 3 q + 0.001 m apart
WIDE = "0.03 0.04 0.07"  # of the right one: 1 cm larger on all sides


@pytest.fixture
def scene(tmp_path: Path) -> TaskScene:
    write_arm(tmp_path)
    text = "scene: s\nepsilon: 0.01\nrobots:\n  arm: {urdf: small.urdf}\nobjects:\n  cup: {box: [0.1, 0.1, 0.1]}\n"
    (tmp_path / "scene.yaml").write_text(text)
    made = load_scene(load_scene_description(tmp_path / "scene.yaml"))
    return TaskScene.of(GeometryServer(made).context(), made.start)


def test_links_that_overlap_are_told_with_the_depth(tmp_path: Path, scene: TaskScene) -> None:
    text = (
        (tmp_path / "small.urdf")
        .read_text()
        .replace("0.01 0.02 0.05", "0.03 0.04 0.07")
        .replace(WIDE, "0.01 0.02 0.05", 1)
    )
    (tmp_path / "small.urdf").write_text(text)
    made = load_scene(load_scene_description(tmp_path / "scene.yaml"))
    scene = TaskScene.of(GeometryServer(made).context(), made.start)
    open_scene = scene.at("arm", (0.0, 0.0, 0.0, 0.04))
    found = own_nearness(open_scene, "arm", FINGERS, [(0.0, 0.0, 0.0, 0.0)])
    assert found is not None
    assert found.said == "arm.left and arm.right overlap by 10 mm or more"
    assert found.found == pytest.approx(-0.01, abs=1e-6)


def test_links_whose_edges_cross_are_told_without_a_depth(scene: TaskScene) -> None:
    found = own_nearness(scene.at("arm", (0.0, 0.0, 0.0, 0.04)), "arm", FINGERS, [(0.0, 0.0, 0.0, 0.0)])
    assert found is not None and found.said == "arm.left and arm.right touch or overlap"


def test_links_that_are_nearer_than_epsilon_are_told_with_the_distance(scene: TaskScene) -> None:
    open_scene = scene.at("arm", (0.0, 0.0, 0.0, 0.04))
    found = own_nearness(open_scene, "arm", FINGERS, [(0.0, 0.0, 0.0, 0.004)])
    assert found is not None
    assert found.said == "arm.left and arm.right are at most 3 mm apart, with epsilon = 10 mm"


@pytest.mark.usefixtures("scene")
def test_links_that_are_to_keep_a_distance_are_told_with_it(tmp_path: Path) -> None:
    """An uncertain robot keeps twice as much from itself; no word of it was said, only the epsilon."""
    path = tmp_path / "scene.yaml"
    hand = "gripper: {joints: [finger], open: {finger: 0.04}, closed: {finger: 0}, touch_links: [left, right]}"
    path.write_text(path.read_text().replace("{urdf: small.urdf}", f"{{urdf: small.urdf, {hand}}}"))
    made = replace(load_scene(load_scene_description(path)), uncertain={"arm": 0.02})
    uncertain = TaskScene.of(GeometryServer(made).context(), made.start)
    found = own_nearness(uncertain, "arm", ("arm.base", "arm.lower"), [(0.0, 0.0, 0.0, 0.004)])
    assert found is not None
    assert " apart, where 40 mm are to be kept, with epsilon = 10 mm" in found.said, found.said
    fingers = own_nearness(uncertain, "arm", FINGERS, [(0.0, 0.0, 0.0, 0.004)])
    assert fingers is not None and "kept" not in fingers.said  # only the gripper moves them


def test_it_is_said_where_the_robot_stands_so_already(scene: TaskScene) -> None:
    found = own_nearness(scene, "arm", FINGERS, [(0.0, 0.5, 0.0, 0.0)])
    assert found is not None and found.said.endswith("too near already where arm stands")


def test_other_pairs_are_not_measured(scene: TaskScene) -> None:
    assert own_nearness(scene, "arm", ("arm.left", "cup"), [(0.0, 0.0, 0.0, 0.0)]) is None


def test_the_refusal_of_a_call_has_the_measure_of_the_pair_that_blocks_most(scene: TaskScene) -> None:
    stage: Stage = STAGES["MoveTo"]("move", robot="arm", goal="home")
    counted = Refusals()
    asked = along(scene, "arm", (0.0, 0.0, 0.0, 0.0))
    counted.observe(stage, Refusal.collision(("arm.left", "cup"), question=asked))
    for _ in range(2):
        counted.observe(stage, Refusal.collision(FINGERS, question=asked))
    total = counted.total("arm cannot move", frozenset(), scene.context.scene)
    (measure,) = total.measures
    assert measure.name == "arm.left – arm.right"
    assert f"most often {measure.text}" in total.comment
