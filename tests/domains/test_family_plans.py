"""The families without a scene, solved: plans that verify, of the size that their READMEs tell."""

import pytest

import kabo
from kabo.plan import Plan, plan_statistics
from kabo.verify import validate_worlds
from tests.domains.families import generated

# nodes (the goal counted) and actions on the longest branch: at most these
SMALL = [
    ("asking_bartender", {"n": 3}, 16, 15),
    ("bomb_in_the_toilet", {"n": 3}, 6, 5),
    ("bomb_in_the_toilet", {"n": 4, "toilets": 2}, 7, 6),
    ("btcs", {"n": 4}, 9, 5),
    ("canadian_traveller", {"n": 3}, 10, 6),
    ("coloured_balls", {"n": 3}, 40, 40),
    ("doors", {"n": 3}, 14, 8),
    ("elogistics", {"n": 3}, 147, 60),
    ("grid", {"n": 3}, 20, 15),
    ("logistics", {"n": 3, "wide": 1}, 146, 60),
    ("medicate", {"n": 5}, 12, 7),
    ("poisonous_liquid", {"n": 2}, 10, 6),
    ("rovers", {"n": 4}, 80, 40),
    ("safes", {"n": 3}, 6, 5),
    ("safes", {"n": 3, "note": True}, 3, 2),
    ("unix", {"n": 1}, 18, 14),
    ("unix", {"n": 2}, 49, 37),
    ("unix", {"n": 2, "anywhere": True}, 49, 37),
    ("wumpus", {"n": 4}, 45, 30),
]


def _plan(problem: kabo.Problem, search: str | None = None) -> Plan:
    result = kabo.solve(problem, search=search, timeout=60.0)
    assert result.plan is not None, result.reason
    return result.plan


@pytest.mark.parametrize(("family", "settings", "nodes", "actions"), SMALL)
def test_a_small_instance_is_solved_by_a_plan_of_the_size_told(tmp_path, family, settings, nodes, actions):
    problem = generated(tmp_path, family, **settings)
    plan = _plan(problem)
    assert kabo.verify(problem, plan).ok
    assert not validate_worlds(problem, plan).findings
    figures = plan_statistics(plan)
    assert figures.plan_nodes <= nodes
    assert figures.plan_actions <= actions


def _actions(plan: Plan) -> list[str]:
    return [node.action for node in plan.nodes.values() if getattr(node, "action", None)]


def test_a_guarded_safe_is_opened_by_what_the_note_says(tmp_path):
    plan = _plan(generated(tmp_path, "safes", n=3, note=True))
    assert _actions(plan) == ["read_note", "dial_what_is_known"]


def test_the_bartender_serves_what_was_ordered_without_a_branch_of_its_own_for_each_order(tmp_path):
    few, many = (_plan(generated(tmp_path, "asking_bartender", n=2, drinks=drinks)) for drinks in (2, 6))
    assert sorted(_actions(few)) == sorted(_actions(many))


def test_the_red_door_is_looked_for_before_any_paint(tmp_path):
    problem = generated(tmp_path, "painted_doors", n=2)
    plan = _plan(problem, search="breadth-first")
    assert kabo.verify(problem, plan).ok
    assert not validate_worlds(problem, plan).findings
    assert plan.nodes[plan.root].action == "look"


def test_bombs_are_dunked_without_sensing(tmp_path):
    plan = _plan(generated(tmp_path, "bomb_in_the_toilet", n=3))
    assert plan_statistics(plan).plan_leaves == 1
    assert _actions(plan).count("dunk") == 3


def test_nobody_drinks_before_the_lawn_has_told(tmp_path):
    problem = generated(tmp_path, "poisonous_liquid", n=1)
    assert _actions(_plan(problem)) == ["pour", "look", "drink"]


@pytest.mark.parametrize(("family", "n"), [("bartender", 6), ("force_sensing", 12)])
def test_more_objects_than_the_tables_hold_make_a_problem_without_a_scene(tmp_path, family, n):
    problem = generated(tmp_path, family, n=n)
    assert problem.scene is None
    plan = _plan(problem)
    assert kabo.verify(problem, plan).ok
    assert plan_statistics(plan).plan_nodes <= (6 if family == "bartender" else 5) * n + 1
