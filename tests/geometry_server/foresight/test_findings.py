"""What is foreseen of scenes: nothing of those that are shipped, and the right numbers of those that are not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kabo.errors import About
from kabo.geometry_server import opening_of, start_findings
from kabo.language import load_problem, load_scene_description
from kabo.language.scene_description import SceneDescription
from kabo.scene import load_scene
from tests.planner.gantry import gantry_problem

ROOT = Path(__file__).resolve().parents[3]
SHIPPED = ["bartender/four_bottles", "stacked/n8", "circular_rearrange/n3", "force_sensing/n4", "assembly/gearbox"]


def scene_of(folder: Path, **given: object) -> SceneDescription:
    scene = gantry_problem(folder, **given).scene
    assert scene is not None
    return scene


def said(scene: SceneDescription) -> list[str]:
    return [finding.message for finding in start_findings(scene)]


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scenes_have_no_warnings(name: str) -> None:
    scene = load_problem(ROOT / "domains" / f"{name}.yaml").scene
    assert scene is not None and start_findings(scene) == []


def test_a_scene_file_alone_is_examined() -> None:
    assert start_findings(load_scene_description(ROOT / "domains" / "bartender" / "scene.yaml")) == []


def test_cubes_that_overlap_stand_inside_or_only_touch_are_told_apart(tmp_path: Path) -> None:
    cubes = {"cube": (0.2, 0.0, 0.02), "second": (0.23, 0.0, 0.02), "third": (-0.2, 0.0, 0.02)}
    (only,) = said(scene_of(tmp_path, things=cubes))
    assert (
        only == "cube and second overlap at the start, by up to 10 mm, proven"
    )  # each is 40 mm wide, 30 mm apart
    (inside,) = said(
        scene_of(tmp_path, things={"cube": (0.2, 0.0, 0.1)}, walls={"block": ((0.3, 0.3, 0.3), (0.2, 0, 0.15))})
    )
    assert inside.startswith("cube begins inside block, up to 1") and inside.endswith("mm deep, proven")
    assert said(scene_of(tmp_path, things={"cube": (0.2, 0.0, 0.02), "second": (0.24, 0.0, 0.02)})) != []
    assert said(scene_of(tmp_path, things={"cube": (0.2, 0.0, 0.02), "second": (0.26, 0.0, 0.02)})) == []


def test_the_remedy_says_how_much_higher_an_object_is_free_of_what_it_should_stand_on(tmp_path: Path) -> None:
    (sunk,) = start_findings(scene_of(tmp_path, things={"cube": (0.2, 0.0, -0.05)}))  # the middle of the table
    assert sunk.hint is not None and sunk.hint.endswith("; cube is above table if it is 70 mm higher")
    (beside,) = start_findings(scene_of(tmp_path, things={"cube": (0.2, 0.0, 0.02), "second": (0.23, 0.0, 0.02)}))
    assert beside.hint is not None and "higher" not in beside.hint  # their middles are apart


def test_an_object_as_large_as_if_in_millimetres_swallows_the_robot_and_is_told_at_its_own_line(
    tmp_path: Path,
) -> None:
    scene = scene_of(tmp_path)
    cube = scene.bodies["cube"]
    huge = replace(cube, shape=replace(cube.shape, size=(40.0, 40.0, 40.0)))
    found = start_findings(replace(scene, bodies={**scene.bodies, "cube": huge}))
    inside = [each for each in found if each.message.startswith("gantry.mast begins inside cube")]
    assert [each.line for each in inside] == [cube.place.line if cube.place else 1]


def test_things_nearer_than_epsilon_are_told_with_their_distance(tmp_path: Path) -> None:
    (near,) = said(scene_of(tmp_path, things={"cube": (0.2, 0.0, 0.02), "second": (0.2405, 0.0, 0.02)}))
    assert near.startswith("cube is 0.5 mm from second at the start") and "epsilon = 10 mm" in near


@pytest.mark.parametrize("gap", [0.0005, 0.01, 0.2])
def test_what_hangs_in_the_air_is_told_with_its_height(tmp_path: Path, gap: float) -> None:
    (only,) = said(scene_of(tmp_path, things={"cube": (0.2, 0.0, 0.02 + gap)}))
    assert f"{1000 * gap:g} mm above table" in only


def test_what_has_nothing_below_it_is_told(tmp_path: Path) -> None:
    (only,) = said(scene_of(tmp_path, things={"cube": (2.0, 0.0, 0.02)}))
    assert only == "cube hangs in the air at the start: nothing is below it"


def test_an_allowed_contact_of_things_that_never_meet_is_told_with_how_that_is_known(tmp_path: Path) -> None:
    scene = scene_of(tmp_path, walls={"far": ((0.1, 0.1, 0.1), (9.0, 0.0, 0.05))})
    fixed = replace(scene, bodies={**scene.bodies, "far": replace(scene.bodies["far"], movable=False)})
    (only,) = said(replace(fixed, allowed_contacts=(("gantry.left", "far"),)))
    assert only.startswith("the allowed contact of gantry.left and far is never needed: they stay ")
    assert only.endswith("proven by the lengths of links")
    assert said(replace(fixed, allowed_contacts=(("gantry.left", "table"),))) == []
    (sampled,) = said(replace(fixed, allowed_contacts=(("gantry.mast", "table"),)))
    assert "sampled configurations, which is no proof" in sampled  # the mast ends 0.35 m above the table


def test_a_gripper_is_as_wide_as_its_fingers_are_apart(tmp_path: Path) -> None:
    robot = load_scene(scene_of(tmp_path)).robots["gantry"]
    for value in (0.0, 0.02, 0.035):
        found = opening_of(robot, (value,), np.array([0.0, 0.0, -0.05]))
        if value == 0.0:
            assert found is None  # it is closed already: nothing moves
        else:
            assert found is not None and found.metres == pytest.approx(
                2.0 * value
            )  # fingers 10 mm thick, 5 mm aside


def test_a_cube_wider_than_the_gripper_opens_is_a_proof(tmp_path: Path) -> None:
    scene = scene_of(tmp_path)
    cube = scene.bodies["cube"]
    wide = replace(cube, shape=replace(cube.shape, size=(0.08, 0.04, 0.04)))
    (only,) = said(replace(scene, bodies={**scene.bodies, "cube": wide}))
    assert "cube is 80 mm wide where grasp from_above holds it, the gripper of gantry opens 70 mm" in only
    assert only.endswith("10 mm too little, proven")
    across = replace(cube, shape=replace(cube.shape, size=(0.04, 0.08, 0.04)))
    assert said(replace(scene, bodies={**scene.bodies, "cube": across})) == []


def test_a_movable_thing_that_nobody_can_grasp_is_told_where_it_overlaps_and_nowhere_else(tmp_path: Path) -> None:
    given = scene_of(tmp_path, things={"cube": (0.2, 0.0, 0.0)})
    sunk = replace(given, bodies={**given.bodies, "cube": replace(given.bodies["cube"], grasps={})})
    (only,) = start_findings(sunk)
    assert only.message == "cube and table overlap at the start, by up to 20 mm, proven"
    assert (only.severity, only.about) == ("warning", About(("cube", "table"), pytest.approx(-0.02, abs=1e-6)))
    fixed = replace(sunk.bodies["cube"], movable=False)
    assert start_findings(replace(sunk, bodies={**sunk.bodies, "cube": fixed})) == []
    pose = replace(sunk.bodies["cube"].pose, position=(0.2, 0.0, 0.5))
    hanging = replace(sunk.bodies["cube"], pose=pose)
    assert start_findings(replace(sunk, bodies={**sunk.bodies, "cube": hanging})) == []
