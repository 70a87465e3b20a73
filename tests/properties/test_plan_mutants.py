"""No plan that is wrong by construction is verified, and the shipped plans from which it was made are."""

import os
from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from kabo.language import load_problem
from kabo.planner.solve import solve
from kabo.verify import verify_plan
from tests.plan_mutants import MUTATIONS, Case, mutants
from tests.support.remembered_distances import remembered_distances

DOMAINS = Path(__file__).parents[2] / "domains"
SCALE = float(os.environ.get("KABO_PROPERTY_SCALE", "0.1"))
TOTAL = max(50, round(500 * SCALE))
SMALL = ("stacked/n2", "assembly/gearbox", "force_sensing/n2", "circular_rearrange/n2")
LARGE = (*SMALL, "bartender/four_bottles", "circular_rearrange/n3", "stacked/n5")


@cache
def case(name: str) -> Case:
    problem = load_problem(DOMAINS / f"{name}.yaml")
    return Case(problem, solve(problem, seed=0).plan)


@pytest.mark.slow
@pytest.mark.parametrize("name", LARGE if SCALE >= 1 else SMALL)
def test_the_plan_of_a_shipped_problem_is_verified(name):
    report = verify_plan(case(name).problem, case(name).plan)
    assert report.ok and report.certificate is not None, str(report)


@pytest.mark.slow
def test_no_mutant_of_a_shipped_plan_is_verified():
    """500 at full scale, of all kinds in turn; but for kinds about certificates none has one that would give it away."""
    made: Counter[str] = Counter()
    with remembered_distances():
        for mutant in mutants([case(name) for name in (LARGE if SCALE >= 1 else SMALL)], TOTAL, seed=2026):
            made[mutant.kind] += 1
            assert not verify_plan(mutant.problem, mutant.plan).ok, (
                f"overlooked: {mutant.kind} in {mutant.plan.problem}"
            )
    assert len(MUTATIONS) >= 50 and len(made) >= min(TOTAL, len(MUTATIONS)) - 2


def test_a_plan_without_statements_is_refused_by_name():
    plan = case("stacked/n2").plan
    nodes = {
        name: replace(node, motion=tuple(replace(s, grants=()) for s in node.motion))
        for name, node in plan.nodes.items()
    }
    (finding,) = verify_plan(case("stacked/n2").problem, replace(plan, nodes=nodes)).findings
    assert "does not say what grants its contacts" in finding.message and "make it anew" in finding.message
