"""Tests of what callers are told that give a path, or nothing, in place of what was loaded from it."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import kabo
from kabo.execution import KnownTruth, execute

DOMAIN = Path(__file__).parents[1] / "domains" / "doors"
SCENE = Path(__file__).parents[1] / "examples" / "two_cans" / "scene.yaml"
BY_PATH = "problem must be a Problem, as kabo.load_problem(path) makes it, and is 'n3.yaml'"
NO_PLAN = "and is None; a result without a plan says why: result.reason"


@pytest.fixture(scope="module")
def problem() -> kabo.Problem:
    return kabo.load_problem(DOMAIN / "n3.yaml")


@pytest.fixture(scope="module")
def plan(problem: kabo.Problem) -> kabo.Plan:
    found = kabo.solve(problem).plan
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda _, plan: kabo.solve("n3.yaml"), BY_PATH),
        (lambda _, plan: kabo.explain("n3.yaml"), BY_PATH),
        (lambda _, plan: kabo.verify("n3.yaml", plan), BY_PATH),
        (lambda _, plan: kabo.after("n3.yaml", plan), BY_PATH),
        (lambda problem, _: kabo.verify(problem, None), NO_PLAN),
        (lambda problem, _: kabo.verify(problem, kabo.solve(problem)), "and is of type Result"),
        (lambda problem, _: kabo.after(problem, "plan.json"), "kabo.load_plan(path) makes it, and is 'plan.json'"),
        (lambda problem, _: kabo.solve(problem, start={}), "start must be a State"),
        (lambda *_: kabo.export("plan.json", "dot"), "and is 'plan.json'"),
        (lambda *_: execute(None, None, None, KnownTruth()), NO_PLAN),
        (lambda _, plan: execute(plan, "scene.yaml", None, KnownTruth()), "kabo.load_scene(path) makes it"),
        (lambda problem, _: kabo.plan_motion(problem, "arm", "home", "home"), "scene must be a Scene"),
    ],
)
def test_what_makes_it_is_named(call: Callable[..., Any], words: str, problem: kabo.Problem, plan: kabo.Plan):
    with pytest.raises(TypeError, match=re.escape(words)):
        call(problem, plan)


def test_a_motion_is_planned_in_the_scene_of_a_file():
    there = {"panda_joint1": 0.1}
    found = kabo.plan_motion(SCENE, "arm", "home", there)
    assert found == kabo.plan_motion(kabo.load_scene(SCENE), "arm", "home", there)
