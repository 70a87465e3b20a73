"""Distances that are asked for: kept by planning, proven by certificates, and refused where they are not proven."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kabo import load_problem, solve
from kabo.geometry_server import GeometryServer
from kabo.plan import Certificate
from kabo.planner.certify.certified_pairs import Thing, kept_distances
from kabo.planner.certify.certifying import certify
from kabo.scene import load_scene
from kabo.verify import verify_plan
from kabo.verify.certificate.kept import KeptDistances
from kabo.verify.motion.arms import Mount
from kabo.verify.motion.stretches import MotionStretch
from kabo.verify.motion.sweep import SweptBody

STACKED = Path(__file__).resolve().parents[3] / "domains/stacked/n2.yaml"
GEARBOX = STACKED.parents[1] / "assembly/gearbox.yaml"
KEPT = 0.003


@pytest.fixture(scope="module")
def problem():
    return load_problem(STACKED)


@pytest.fixture(scope="module")
def plan(problem):
    found = solve(problem, clearance=KEPT)
    assert found.plan is not None
    return found.plan


def test_a_plan_with_a_clearance_proves_it_for_every_pair(problem, plan):
    assert plan.options["clearance"] == KEPT and plan.certificate is not None
    assert all(each.clearance is None or each.clearance >= KEPT for each in plan.certificate.segments)
    report = verify_plan(problem, plan)
    assert report.ok, str(report)
    assert all(each.distance is None or each.distance >= KEPT for each in report.certificate.objects)


def test_a_plan_that_claims_more_than_it_proves_is_refused(problem, plan):
    report = verify_plan(problem, replace(plan, options={**plan.options, "clearance": 0.05}))
    assert not report.ok and "that they are to keep" in str(report)


def test_a_clearance_without_a_certificate_is_refused(problem, plan):
    report = verify_plan(problem, replace(plan, certificate=None))
    assert not report.ok and "has no certificate that proves it" in str(report)


def test_an_uncertain_object_and_its_robot_are_kept_apart_from_others_by_both(problem, plan):
    scene = load_scene(problem.scene)
    name, robot = next(iter(scene.movable)), next(iter(scene.robots))
    uncertain = replace(scene, uncertain={name: 0.004, robot: 0.001})
    surroundings = GeometryServer(uncertain, clearance=KEPT).surroundings
    assert surroundings.kept(name) == pytest.approx(KEPT / 2 + 0.004)
    assert surroundings.kept(name, robot) == pytest.approx(KEPT / 2 + 0.005)
    assert surroundings.kept(f"{robot}.any_link") == pytest.approx(KEPT / 2 + 0.001)
    plain = GeometryServer(scene).surroundings
    assert not plain.keeps and plain.greatest_kept == 0.0


def test_what_cannot_be_proven_with_its_distance_is_a_gap(problem, plan):
    scene = load_scene(problem.scene)
    made = certify(plan, GeometryServer(scene, clearance=0.3).surroundings)
    assert not isinstance(made, Certificate) and "not proven apart" in str(made[0])


def test_what_is_attached_to_a_mate_is_spared_by_planner_and_verifier_alike():
    """A pipe in a hand goes onto a tree, to which a bearing is attached already."""
    scene = load_scene(load_problem(GEARBOX).scene)
    robot = scene.robots["robot_1"]
    link = robot.gripper.touch_links[0]
    joint = robot.links[link.partition(".")[2] or link].joint
    moving, standing = ["robot_1.left_finger", "o3"], ["o4", "o1", "table"]
    roots, permitted = {"o1": "o4", "o4": "o4", "o3": "o3", "o2": "o3"}, frozenset([frozenset(("o3", "o4"))])
    things = [Thing(name, 0, None, "robot_1", KEPT / 2, robot.hand(joint)) for name in moving]
    things += [Thing(name, 0, None, None, KEPT / 2) for name in standing]
    pairs = [(i, k, 0) for i in range(len(moving)) for k in range(i + 1, len(things))]
    found = kept_distances(things, np.array(pairs), permitted, roots)
    spared = {(things[i].name, things[k].name) for (i, k, _), kept in zip(pairs, found, strict=True) if not kept}
    assert spared == {("robot_1.left_finger", "o3"), ("robot_1.left_finger", "o1"), ("o3", "o1")}

    judge = KeptDistances(scene, KEPT)
    bodies = [SweptBody(name, None, mount=Mount(joint, np.eye(4), "robot_1")) for name in moving]
    bodies += [SweptBody(name, None, np.eye(4)) for name in standing]
    stretch = MotionStretch("n0", (0,), None, bodies[:2], bodies[2:], permitted, roots=roots)
    near = judge.spared(stretch)
    assert [judge.between(bodies[i], bodies[k], near) for i, k, _ in pairs] == pytest.approx(found)
    assert judge.between(bodies[1], bodies[3]) == pytest.approx(KEPT)


def test_lengths_on_the_command_line_may_have_a_unit():
    from kabo.cli.argument_types import bounded

    read = bounded(0.0, 0.3, "m")
    assert read("3mm") == read("0.003") == read("0.3 cm") == KEPT and read("0") == 0.0
