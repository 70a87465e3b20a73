"""WAITER: two tables, none of whose cups can be brought to the other without driving; plans verified, explained, spoilt."""

from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import kabo
from kabo.explain.explain import explanation_to_json
from kabo.plan import Plan, schema
from kabo.scene import BASE_VALUES, Scene, world_T
from kabo.tasks.robots.motion.smoothing import DRIVEN_DEVIATION
from tests.domains.scenes import DOMAINS, problem_of, scene_of

FOLDER = DOMAINS / "waiter"
TWO = FOLDER / "two_cups.yaml"


@pytest.fixture(scope="module")
def plan() -> Plan:
    """The plan for two cups."""
    result = kabo.solve(problem_of(TWO))
    assert result.status == "solved" and result.plan is not None
    return result.plan


def _reach(scene: Scene) -> float:
    """More than the arm can reach from the axis of its base, level with the cups [m]."""
    tree, drive = scene.robots["waiter"].tree, scene.robots["waiter"].drive
    assert drive is not None
    return float(np.linalg.norm(tree.placement[drive.joint + 1 :, 9:], axis=1).sum()) + 0.11


def test_no_place_of_the_base_reaches_both_tables() -> None:
    scene = scene_of(TWO)
    tables = [world_T(scene, scene.start, name)[:2, 3] for name in ("guests_table", "counter_table")]
    nearest = float(np.linalg.norm(np.subtract(*tables))) - 2 * np.hypot(0.25, 0.425)
    assert nearest > 0.0
    assert np.linalg.norm(np.subtract(*tables)) > 2 * _reach(scene)


def test_every_plan_drives_and_the_verifier_agrees(plan: Plan) -> None:
    driven = {
        segment.procedure
        for node in plan.nodes.values()
        for segment in node.motion
        if "base_x" in segment.joints and np.ptp(np.array(segment.waypoints)[:, :BASE_VALUES], axis=0).max() > 0.5
    }
    assert {name.partition("(")[0] for name in driven} == {"pick", "place"}
    report = kabo.verify(problem_of(TWO), plan)
    assert not report.findings


def test_a_base_that_is_driven_over_the_edge_of_its_floor_is_found(plan: Plan) -> None:
    """The same plan, on a floor that ends where it drove."""
    scene = problem_of(TWO).scene
    assert scene is not None
    hall = scene.regions["hall"]
    small = replace(hall, shape=replace(hall.shape, size=(2.8, 3.2, 0.1)))
    problem = replace(problem_of(TWO), scene=replace(scene, regions={**scene.regions, "hall": small}))
    said = "\n".join(map(str, kabo.verify(problem, plan).findings))
    assert "the base of waiter leaves its floor hall by" in said


def test_strokes_are_of_the_arm_alone(plan: Plan) -> None:
    for node in plan.nodes.values():
        for segment in node.motion:
            if segment.stage in ("approach", "lift", "lower", "retreat") and "base_x" in segment.joints:
                assert np.ptp(np.array(segment.waypoints)[:, :BASE_VALUES], axis=0).max() == 0.0


@pytest.mark.slow
def test_a_robot_that_travels_in_a_configuration_folds_its_arm_before_it_drives() -> None:
    scene = problem_of(TWO).scene
    assert scene is not None and scene.robots["waiter"].drive is not None
    folded = replace(scene.robots["waiter"].drive, travel="home")
    robots = {"waiter": replace(scene.robots["waiter"], drive=folded)}
    problem = replace(problem_of(TWO), scene=replace(scene, robots=robots))
    result = kabo.solve(problem)
    assert result.plan is not None
    driven = 0
    for node in result.plan.nodes.values():
        for segment in node.motion:
            if "base_x" in segment.joints:
                steps = np.abs(np.diff(np.array(segment.waypoints), axis=0))
                base, arm = steps[:, :BASE_VALUES].sum(axis=1), steps[:, BASE_VALUES:].sum(axis=1)
                driven += int((base > 0.0).sum())
                both = np.minimum(base, arm).max()  # where one ends and the other begins, the corner is rounded
                assert (
                    both <= 2.0 * DRIVEN_DEVIATION or steps[:, :2].sum() < 1.0
                )  # short ways are not worth folding
    assert driven > 4


@pytest.mark.slow
def test_a_floor_that_is_too_small_is_told_with_the_distance_and_a_larger_one_is_tried(tmp_path: Path) -> None:
    scene = (FOLDER / "scene.yaml").read_text().replace("../../meshes", str(DOMAINS.parent / "meshes"))
    (tmp_path / "scene.yaml").write_text(scene.replace("box: [4.2, 3.2, 0.1]", "box: [2.0, 1.6, 0.1]"))
    (tmp_path / "domain.yaml").write_text((FOLDER / "domain.yaml").read_text())
    (tmp_path / "one.yaml").write_text(TWO.read_text())
    explained = kabo.explain(kabo.load_problem(tmp_path / "one.yaml"))
    said = str(explained)
    assert "m, wherever on hall the base of waiter stands" in said
    assert "with the floor hall of waiter larger by" in said.lower()
    jsonschema.validate(explanation_to_json(explained), schema("kabo-explain-1"))
