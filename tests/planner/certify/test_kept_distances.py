"""Distances that are asked for: kept by planning, proven by certificates, and refused where they are not proven."""

from dataclasses import replace
from pathlib import Path

import pytest

from kabo import load_problem, solve
from kabo.geometry_server import GeometryServer
from kabo.plan import Certificate
from kabo.planner.certify.certifying import certify
from kabo.scene import load_scene
from kabo.verify import verify_plan

STACKED = Path(__file__).resolve().parents[3] / "domains/stacked/n2.yaml"
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


def test_lengths_on_the_command_line_may_have_a_unit():
    from kabo.cli.argument_types import bounded

    read = bounded(0.0, 0.3, "m")
    assert read("3mm") == read("0.003") == read("0.3 cm") == KEPT and read("0") == 0.0
