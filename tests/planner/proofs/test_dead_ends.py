"""Where what is tried first leads nowhere in geometry: the search comes back, with every order of asking.

`dead_ends/` has a cupboard (only what is held from the side fits in; what stands in front is in the way, whether or not
the goal knows it) and a crossing (what is put down in between may stand where another thing is to go).
"""

from functools import cache
from pathlib import Path

import pytest

import kabo
from kabo.plan import Plan, plan_statistics
from kabo.planner.result import Result

FOLDER = Path(__file__).parent / "dead_ends"
CASES = [("grasp", 0, "adaptive"), ("grasp", 2, "lazy"), ("grasp", 1, "eager")]
CASES += [("obstacle", 0, "adaptive"), ("obstacle", 2, "lazy"), ("obstacle", 1, "eager")]
CASES += [("order", 0, "adaptive"), ("crossing", 0, "adaptive")]


@cache
def solved(name: str, seed: int, order: str) -> Result:
    return kabo.solve(kabo.load_problem(FOLDER / f"{name}.yaml"), seed=seed, geometry_order=order)


def plan_of(name: str, seed: int, order: str = "adaptive") -> Plan:
    result = solved(name, seed, order)
    assert result.plan is not None, result.reason
    return result.plan


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed", "order"), CASES)
def test_dead_ends_are_left_with_every_order_of_asking(name: str, seed: int, order: str) -> None:
    """More seeds, and what they cost: docs/decisions/017-hybrid-search.md."""
    assert kabo.verify(kabo.load_problem(FOLDER / f"{name}.yaml"), plan_of(name, seed, order)).ok


def test_what_is_to_stand_behind_is_put_there_first() -> None:
    placed = [n.arguments["l"] for n in plan_of("order", 0).nodes.values() if n.action == "put_down"]
    assert placed.index("behind") < placed.index("in_front")


@pytest.mark.parametrize(("seed", "order"), [(0, "adaptive"), (2, "lazy"), (1, "eager")])
def test_what_the_goal_does_not_mention_is_moved_out_of_the_way(seed: int, order: str) -> None:
    nodes = plan_of("obstacle", seed, order).nodes.values()
    assert "obstacle" in [n.arguments["o"] for n in nodes if n.action == "pick_up"]
    assert plan_statistics(plan_of("obstacle", seed, order)).plan_actions <= 6


def test_what_crosses_the_table_is_put_down_where_it_is_in_nobodys_way() -> None:
    assert plan_statistics(plan_of("crossing", 0)).plan_actions <= 11
    assert solved("crossing", 0, "adaptive").statistics["collision_checks"] <= 2000


def test_a_first_grasp_that_leads_nowhere_is_given_up_for_another_one() -> None:
    rows = [solved(*case).statistics["procedures"]["pick"]["calls"] for case in CASES[:2]]
    assert max(rows) > 1
