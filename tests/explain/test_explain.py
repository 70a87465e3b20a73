"""Explanations: root causes of what can never be known, what is of no use, and dead ends."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest

from kabo.explain.explain import explain, explanation_to_json
from kabo.language import formulas as f
from kabo.language import load_problem
from kabo.language.problem import Function
from kabo.plan import schema
from kabo.planner.solve import solve
from tests.support.small_problems import (
    FUEL,
    action,
    add,
    app,
    atom,
    cmp,
    delete,
    know,
    lit,
    no,
    problem,
    var,
    when,
)

ROOT = Path(__file__).resolve().parents[2]
SCHEMA = schema("kabo-explain-1")
T = var("t")


def explained(*, actions=(), initial=(), goal, **more):
    found = explain(problem(actions=actions, initial=initial, goal=goal, **more))
    jsonschema.validate(explanation_to_json(found), SCHEMA)
    return found


def why(found, number=0):
    return " ".join(found.unreachable_goals[number].why)


# ------------------------------------------------------------------------------------------------------ verdicts
def test_a_problem_with_a_plan_is_solvable_and_nothing_in_it_is_in_vain():
    found = explained(actions=[action("make", effects=[add(lit("r"))])], goal=[know(lit("r"))])
    assert (found.verdict, found.reachable, found.layers) == ("solvable", True, 1)
    assert (found.unreachable_goals, found.unused_actions, found.never_known) == ((), (), ())


def test_a_spent_budget_is_said():
    make = action("make", effects=[add(lit("r"))])
    found = explain(problem(actions=[make], goal=[know(lit("r"))]), max_expansions=0, search="breadth-first")
    assert found.verdict == "exhausted" and found.reachable and "as many nodes as allowed" in str(found)


# ---------------------------------------------------------------------------------------------------- root causes
def test_the_chain_is_told_down_to_what_nothing_makes():
    actions = [
        action("first", effects=[add(lit("s"))]),
        action("second", pre=[know(lit("s")), know(lit("p", "x"))], effects=[add(lit("q", "x"))]),
        action("third", pre=[know(lit("q", "x"))], effects=[add(lit("r"))]),
        action("other", pre=[know(lit("q", "y"))], effects=[add(lit("p", "x"))]),
        action("more", pre=[know(lit("r"))], effects=[add(lit("q", "y"))]),
    ]
    found = explained(actions=actions, goal=[know(lit("r")), know(lit("s"))])
    assert found.verdict == "proved" and not found.reachable
    (goal,) = found.unreachable_goals
    assert goal.text == "K(r)" and goal.layer == 1
    assert "K(r) can only come from third(), which needs K(q(x)), and that never holds." in goal.why
    assert any("wait for each other" in sentence and "K(p(x))" in sentence for sentence in goal.why)
    assert any(sentence.startswith("second() can never be done") for sentence in found.unused_actions)


def test_only_what_waits_for_each_other_is_called_so():
    actions = [
        action("one", pre=[know(lit("p", "y"))], effects=[add(lit("p", "x"))]),
        action("two", pre=[know(lit("p", "x"))], effects=[add(lit("p", "y"))]),
        action("end", pre=[know(lit("p", "x"))], effects=[add(lit("r"))]),
    ]
    goal = explained(actions=actions, goal=[know(lit("r"))]).unreachable_goals[0]
    assert goal.why[-1] == "So K(p(x)) and K(p(y)) wait for each other, and none of them holds at the start."


def test_a_goal_about_all_states_that_fails_at_the_start_is_told():
    mark = action("mark", effects=[add(no("p", "x"))])
    found = explained(actions=[mark], goal=[f.Temporal("always", know(lit("p", "x")))])
    assert why(found) == "always(K(p(x))) does not hold at the start already."


def test_goals_about_the_initial_state_are_told_in_the_language_of_the_file():
    mark = action("mark", effects=[add(no("q", "x"), no("p", "x"))])
    part = f.Temporal("initially", know(lit("p", "x")))
    found = explained(actions=[mark], goal=[part, know(lit("q", "x"))])
    assert found.verdict == "proved" and "initially p" not in str(found)


def test_the_missing_want_nearest_to_a_root_cause_is_told():
    actions = [
        action("long", pre=[know(lit("q", "x"))], effects=[add(lit("q", "y"))]),
        action("make", pre=[know(lit("q", "y")), know(lit("p", "x"))], effects=[add(lit("r"))]),
        action("end", effects=[add(no("p", "x"))]),
        action("never", pre=[know(lit("p", "y"))], effects=[add(lit("q", "x"))]),
        action("forget", effects=[add(no("p", "y"))]),
    ]
    found = explained(actions=actions, goal=[know(lit("r"))])
    assert "make(), which needs K(p(x))" in why(found) and "Nothing makes K(p(x))" in why(found)


def test_what_no_action_senses_can_never_be_known_whether():
    found = explained(actions=[action("go", effects=[add(lit("r"))])], goal=[f.KnowWhether(atom("p", "x"))])
    assert (
        why(found)
        == "p(x) can never be known whether: it is not known at the start, and no action adds or senses it."
    )


def test_sensing_that_is_out_of_reach_is_named_with_what_it_needs():
    look = action("look", parameters=[T], pre=[know(lit("q", T))], sense=[atom("p", T)])
    mark = action("mark", parameters=[T], pre=[know(no("q", T))], effects=[add(no("q", T))])
    found = explained(actions=[look, mark], goal=[know(lit("p", "x"))])
    assert "K(p(x)) can only come from sensing by look(x), which needs K(q(x))" in why(found)
    assert any(
        "p(x) can never be known whether, needed by the goal: only look(x) could tell" in s
        for s in found.never_known
    )


def test_an_action_without_instances_is_the_cause_of_what_it_would_make():
    make = action("make", parameters=[T], pre=[know(lit("p", T))], effects=[add(lit("q", T))])
    found = explained(actions=[make], goal=[know(lit("q", "x"))])
    cause = "make has no instance: K(p(t)) holds for no objects, and nothing changes that."
    assert found.unused_actions == (cause,)
    assert "make has no instance (K(p(t)) holds for no objects" in why(found)


def test_what_is_known_at_the_start_and_never_changes_is_said():
    found = explained(initial=[add(no("p", "x"))], goal=[know(lit("p", "x"))])
    assert why(found) == "K(p(x)) never holds: not p(x) is known from the start, and nothing ever changes that."


def test_knowledge_that_must_be_absent_but_is_never_lost_is_said():
    make = action("make", effects=[add(lit("r"))])
    found = explained(actions=[make], initial=[add(lit("r"))], goal=[f.Not(know(lit("r")))])
    assert why(found) == "K(r) holds from the start, and nothing ever takes that away."


def test_every_alternative_of_a_disjunction_is_explained():
    actions = [action("a", effects=[add(no("p", "x"))]), action("b", effects=[add(no("r"))])]
    found = explained(actions=actions, goal=[f.Or((know(lit("p", "x")), know(lit("r"))))])
    assert "Nothing makes K(p(x))" in why(found) and "Nothing makes K(r)" in why(found)


def test_inference_counts_as_a_way_only_if_something_could_start_it():
    given = {"initial": [add(lit("p", "x"), lit("p", "y"), to="Kx")], "goal": [know(lit("p", "x"))]}
    assert "Nothing makes K(p(x))" in why(explained(**given))
    look = action("look", pre=[know(lit("r"))], sense=[atom("p", "y")])
    forget = action("forget", effects=[add(no("r"))])
    told = why(explained(actions=[look, forget], **given))
    assert "knowing that exactly one holds of p(x) and p(y)" in told and "sensing by look()" in told


def test_like_goals_are_explained_once():
    make = action("make", parameters=[T], pre=[know(lit("q", T))], effects=[add(lit("p", T))])
    unmark = action("unmark", parameters=[T], effects=[add(no("q", T))])
    found = explained(actions=[make, unmark], goal=[know(lit("p", "x")), know(lit("p", "y"))])
    assert why(found, 1) == "For the same reasons as K(p(x))."


# ----------------------------------------------------------------------------------------------------- of no use
def test_instances_that_never_apply_are_told_by_schema():
    use = action("use", parameters=[T], pre=[know(lit("p", T))], effects=[add(lit("r"))])
    undo = action("undo", parameters=[T], pre=[know(lit("p", T))], effects=[add(no("p", T))])
    found = explained(actions=[use, undo], initial=[add(lit("p", "x"))], goal=[know(lit("r"))])
    assert "use: 1 of 2 instances can never be done; for use(y), K(p(y)) can never hold." in found.unused_actions


def test_rules_that_never_fire_are_told():
    rule = when(know(lit("q", "x")), add(lit("r")))
    other = action("other", effects=[add(lit("p", "x"))])
    found = explained(actions=[other], update_rules=[rule], goal=[know(lit("p", "x"))])
    (told,) = found.unused_actions
    assert told.startswith("Update rule 1 never fires: K(q(x)) ")
    assert found.verdict == "solvable"


def test_values_that_nobody_senses_are_told():
    use = action("use", pre=[f.KnowValue(app("hue", "x"))], effects=[add(lit("r"))])
    paint = action("paint", pre=[know(lit("r"))], effects=[add(cmp(app("hue", "x"), "=", "red"))])
    found = explained(
        actions=[use, paint],
        functions=[Function("hue", ("thing",), values=("red", "blue"))],
        goal=[know(lit("r"))],
    )
    assert any(told.startswith("hue(x) can never be known, needed by use()") for told in found.never_known)


def test_numbers_of_which_nothing_is_known_are_told():
    drive = action("drive", pre=[know(cmp(app("fuel"), ">", 1))], effects=[add(lit("r"))])
    found = explained(actions=[drive], functions=[FUEL], goal=[know(lit("r"))])
    assert found.verdict == "proved"
    assert any("fuel" in told for told in found.never_known)


# ----------------------------------------------------------------------------------------------------- dead ends
def test_parts_that_exclude_each_other_are_a_dead_end():
    actions = [
        action("one", pre=[know(lit("r"))], effects=[add(no("r"), lit("p", "x"))]),
        action("two", pre=[know(lit("r"))], effects=[add(no("r"), lit("p", "y"))]),
    ]
    goal = [know(lit("p", "x")), know(lit("p", "y"))]
    found = explained(actions=actions, initial=[add(lit("r"))], goal=goal)
    assert (found.verdict, found.reachable, found.unreachable_goals) == ("proved", True, ())
    assert "dead end" in found.summary[0]
    assert "Each part of the goal can be reached alone, but not K(p(x)) and K(p(y)) together" in found.summary[1]


def test_an_outcome_from_which_nothing_leads_on_is_named():
    look = action("look", sense=[atom("p", "x")])
    win = action("win", pre=[know(lit("p", "x"))], effects=[add(lit("r"))])
    found = explained(actions=[look, win], goal=[know(lit("r"))])
    assert found.verdict == "proved" and found.reachable
    assert (
        "With luck look() and win() would reach the goal; but once p(x) turns out to be false" in found.summary[1]
    )


@pytest.mark.parametrize("goal", [know(lit("p", "x")), know(lit("r"))])
def test_solve_says_the_same_as_explain(goal):
    make = action("make", pre=[know(lit("p", "x"))], effects=[add(lit("r"))])
    given = problem(actions=[make, action("unmark", effects=[add(no("p", "x"))])], goal=[goal])
    reason = solve(given).reason
    assert reason is not None and reason.proved == "knowledge"
    assert reason.details == explain(given).unreachable_goals[0].why


def test_forgetting_is_explained_where_it_is_out_of_reach():
    lose = action("lose", pre=[know(lit("p", "x"))], effects=[delete(lit("r"))])
    spoil = action("spoil", effects=[add(no("p", "x"))])
    found = explained(actions=[lose, spoil], initial=[add(lit("r"))], goal=[f.Not(know(lit("r")))])
    assert "K(r) holds from the start and can only be lost by lose(), which needs K(p(x))" in why(found)


# -------------------------------------------------------------------------------------------------------- domains
@pytest.mark.parametrize("name", ["bartender/four_bottles", "safes/n3", "doors/n3", "unix/n2", "stacked/n4"])
def test_domains_are_solvable(name):
    found = explain(load_problem(ROOT / "domains" / f"{name}.yaml"), geometry=False)
    jsonschema.validate(explanation_to_json(found), SCHEMA)
    assert found.verdict == "solvable"


def test_what_geometry_refuses_is_told():
    given = load_problem(ROOT / "domains" / "bartender/four_bottles.yaml")
    region = given.scene.regions["dishwasher"]
    away = replace(region, pose=replace(region.pose, frame="world", position=(5.0, 0.0, 0.155)))
    given = replace(given, scene=replace(given.scene, regions={**given.scene.regions, "dishwasher": away}))
    found = explain(given, timeout=600.0, changes=0)
    jsonschema.validate(explanation_to_json(found), SCHEMA)
    assert found.verdict == "proved"
    assert found.summary[0].startswith("There is no plan, which is proven: place(")
    assert "It is out of reach by" in found.summary[1]
    assert "Procedures that failed:" in str(found)
    assert explain(given, geometry=False).verdict == "solvable"


@pytest.mark.parametrize("name", ["coloured_balls/n4_2", "asking_bartender/n3", "stacked/n4"])
def test_a_domain_without_one_of_its_actions_names_what_is_missing(name):
    given = load_problem(ROOT / "domains" / f"{name}.yaml")
    first, *rest = given.domain.actions
    domain = replace(given.domain, actions={action: given.domain.actions[action] for action in rest})
    found = explain(replace(given, domain=domain))
    jsonschema.validate(explanation_to_json(found), SCHEMA)
    assert found.verdict == "proved", first
    assert found.unreachable_goals and all(goal.why for goal in found.unreachable_goals)


def test_the_same_text_in_every_process():
    code = (
        "from dataclasses import replace\n"
        "from kabo.language import load_problem\n"
        "from kabo.explain.explain import explain\n"
        f"given = load_problem({str(ROOT / 'domains/coloured_balls/n4_2.yaml')!r})\n"
        "actions = dict(list(given.domain.actions.items())[1:])\n"
        "print(explain(replace(given, domain=replace(given.domain, actions=actions))))\n"
    )
    said = []
    for seed in ("1", "2"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        run = subprocess.run([sys.executable, "-c", code], capture_output=True, env=environment, check=True)
        said.append(run.stdout)
    assert said[0] == said[1] and b"never" in said[0]
