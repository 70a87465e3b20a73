"""Plans of kabo in unified-planning and back, for its problems and for those of `domains/`."""

import dataclasses
from pathlib import Path

import pytest
from unified_planning.io import PDDLReader
from unified_planning.model import ContingentProblem
from unified_planning.plans import ContingentPlan

import kabo
import kabo.up
from kabo.plan import Node, Plan, ValueOf
from kabo.plan.plan import Done
from tests.support.oracles_up import failures
from tests.support.random_up import random_problem

DOMAINS = Path(__file__).parents[2] / "domains"
PROBLEMS = sorted(
    next(file for file in sorted(folder.glob("*.yaml")) if file.name not in ("domain.yaml", "scene.yaml"))
    for folder in DOMAINS.iterdir()
    if folder.is_dir()
)
JUDGED = ("bomb_in_the_toilet", "btcs", "canadian_traveller", "doors", "grid", "medicate", "safes", "logistics")
Run = tuple[tuple[str, ...], tuple[tuple[str, str], ...]]  # the actions of a branch, and what is observed on it


def runs_of(plan: Plan) -> set[Run]:
    """Every branch of kabo's plan: its actions with their arguments, values by what was observed, and the observations."""
    found = set()
    waiting: list[tuple[str, tuple, tuple]] = [(plan.root, (), ())]
    while waiting:
        name, done, seen = waiting.pop()
        node = plan.nodes[name]
        if node.kind == "goal":
            found.add((done, tuple(sorted(dict(seen).items()))))
            continue
        if node.kind != "branch":
            done = (*done, f"{node.action}({', '.join(shown(node, dict(seen)))})")
        if node.branches:
            waiting += [(after, done, (*seen, (node.on, outcome))) for outcome, after in node.branches.items()]
        else:
            waiting.append((node.next, done, seen))
    return found


def shown(node: Node, known: dict) -> list[str]:
    values = [
        known.get(each.term, each.term) if isinstance(each, ValueOf) else str(each)
        for each in node.arguments.values()
    ]
    return [each.lower() for each in values]


def actions_in(plan: ContingentPlan) -> set[tuple[str, ...]]:
    """The actions of every branch of a tree, a missing outcome being a branch that ends there."""
    found, waiting = set(), [(plan.root_node, ())]
    while waiting:
        node, done = waiting.pop()
        values = ", ".join(str(each) for each in node.action_instance.actual_parameters)
        done = (*done, f"{node.action_instance.action.name}({values})")
        waiting += [(child, done) for _, child in node.children]
        if len(node.children) != 1 or node.children[0][0]:
            found.add(done)
    return found


def ran(text: str) -> dict:
    """What is left behind by Python source that kabo wrote."""
    space: dict = {}
    exec(text, space)
    return space


@pytest.mark.parametrize("path", PROBLEMS, ids=lambda path: path.parent.name)
def test_the_plan_of_a_domain_is_rebuilt_by_unified_planning_with_the_same_actions_on_every_branch(path):
    problem = kabo.load_problem(path)
    plan = kabo.solve(problem, geometry="none").plan
    left = ran(kabo.up.export_up(problem, plan))
    exported = kabo.up.problem_to_up(problem)
    assert left["plan"] == kabo.up.plan_to_up(plan, exported.translation)
    assert [each.name for each in left["problem"].actions] == [
        each.name for each in exported.translation.original.actions
    ]
    walked = {done for done, _ in runs_of(plan)}
    rebuilt = actions_in(left["plan"])
    assert {done for done in rebuilt if done in walked} == walked
    # What is more ends at a sense action, behind which an outcome needs nothing more or is impossible.
    assert all(any(whole[: len(done)] == done for whole in walked) for done in rebuilt - walked)


@pytest.mark.parametrize("name", JUDGED)
def test_a_problem_of_which_nothing_is_left_out_is_judged_by_unified_planning(name):
    problem = kabo.load_problem(next(path for path in PROBLEMS if path.parent.name == name))
    exported = kabo.up.problem_to_up(problem)
    assert exported.omitted == ()
    plan = kabo.up.plan_to_up(kabo.solve(problem).plan, exported.translation)
    assert not failures(exported.translation.original, plan, number=10)


def test_what_unified_planning_has_no_form_for_is_named():
    exported = kabo.up.problem_to_up(kabo.load_problem(DOMAINS / "asking_bartender" / "n3.yaml"))
    assert (
        'action confirm, precondition "Kv(order(g))": it is about knowledge, not about the world'
        in exported.omitted
    )


@pytest.mark.parametrize("seed", range(12))
def test_a_plan_that_went_to_unified_planning_and_back_is_the_same(seed):
    translation = kabo.up.problem_from_up(random_problem(seed, contingent=seed % 2 == 0))
    plan = kabo.solve(translation.problem).plan
    if plan is None:
        return
    back = kabo.up.plan_from_up(kabo.up.plan_to_up(plan, translation), translation)
    assert kabo.plan_to_json(back) == kabo.plan_to_json(plan)
    assert kabo.verify(translation.problem, back).ok


@pytest.mark.parametrize("seed", range(12))
def test_the_source_of_a_problem_and_its_plan_builds_them_anew(seed):
    problem = random_problem(seed, contingent=seed % 2 == 0)
    left = ran(kabo.up.source_of(problem))["problem"]
    assert set(left.actions) == set(problem.actions) and left.goals == problem.goals
    assert left.explicit_initial_values == problem.explicit_initial_values
    if isinstance(problem, ContingentProblem):
        assert left.hidden_fluents == problem.hidden_fluents
        assert (
            left.oneof_constraints == problem.oneof_constraints and left.or_constraints == problem.or_constraints
        )
    else:
        assert left == problem


def test_a_plan_that_branches_later_than_it_senses_becomes_a_tree_that_branches_at_once():
    translation = late_branching()
    plan = Plan(
        "tiger", {}, {}, "n0",
        {
            "n0": Node("sense", "listen", {}, "n1", delivers=("tiger_left",)),
            "n1": Node("action", "wait", {}, "n2"),
            "n2": Node("branch", on="tiger_left", branches={"false": "n3", "true": "n4"}),
            "n3": Node("action", "open_left", {}, "n5"),
            "n4": Node("action", "open_right", {}, "n5"),
            "n5": Node("goal"),
        },
    )  # fmt: skip
    tree = kabo.up.plan_to_up(plan, translation)
    assert actions_in(tree) - {("listen()",)} == {
        ("listen()", "wait()", "open-left()"),
        ("listen()", "wait()", "open-right()"),
    }
    assert not failures(translation.original, tree)


def test_a_fact_that_is_seen_with_another_one_may_be_branched_on_later():
    """The plan branches on `a` where both are seen, and on `b` behind that."""
    from unified_planning.model import SensingAction
    from unified_planning.shortcuts import And, Fluent, Iff, InstantaneousAction, Not

    problem = ContingentProblem("two signals")
    a, b, equal = Fluent("a"), Fluent("b"), Fluent("equal")
    for fluent in (a, b, equal):
        problem.add_fluent(fluent, default_initial_value=False)
    problem.add_unknown_initial_constraint(a())
    problem.add_unknown_initial_constraint(b())
    see, flip, tell = SensingAction("see"), InstantaneousAction("flip"), InstantaneousAction("tell")
    see.add_observed_fluents([a(), b()])
    flip.add_precondition(Not(Iff(a, b)))
    flip.add_effect(a, Not(a))
    tell.add_precondition(Iff(a, b))
    tell.add_effect(equal, True)
    problem.add_actions([see, flip, tell])
    problem.add_goal(And(equal, Iff(a, b)))
    translation = kabo.up.problem_from_up(problem)
    plan = kabo.solve(translation.problem).plan
    assert plan is not None and plan.nodes[plan.root].on == "a"
    tree = kabo.up.plan_to_up(plan, translation)
    assert {("see()", "tell()"), ("see()", "flip()", "tell()")} <= actions_in(tree)
    assert not failures(problem, tree)
    assert kabo.verify(translation.problem, kabo.up.plan_from_up(tree, translation)).ok


def late_branching():
    from unified_planning.model import InstantaneousAction

    from tests.up.test_engine import doors

    problem = doors(with_listening=True)
    problem.add_action(InstantaneousAction("wait"))
    return kabo.up.problem_from_up(problem)


def test_a_plan_of_another_problem_and_a_tree_that_is_too_large_are_refused():
    translation = late_branching()
    other = Plan("other", {}, {}, "n0", {"n0": Node("action", "fly", {}, "n1"), "n1": Node("goal")})
    with pytest.raises(kabo.InputError, match="none of this problem"):
        kabo.up.plan_to_up(other, translation)
    nodes = {"g": Node("goal")}
    following = "g"
    for number in range(15):
        nodes[f"s{number}"] = Node(
            "sense", "listen", {}, on="tiger_left", branches={"false": following, "true": following}
        )
        following = f"s{number}"
    with pytest.raises(kabo.InputError, match="as a tree the plan has 32768 branches"):
        kabo.up.plan_to_up(Plan("tiger", {}, {}, following, nodes), translation)


def test_a_plan_that_begins_in_the_state_of_a_run_is_refused():
    translation = late_branching()
    plan = dataclasses.replace(kabo.solve(translation.problem).plan, done=(Done("wait"),))
    with pytest.raises(kabo.InputError, match="begins in the state of a run"):
        kabo.up.plan_to_up(plan, translation)


def test_a_changed_plan_comes_back_and_is_judged_by_kabo():
    translation = late_branching()
    plan = kabo.solve(translation.problem).plan
    wrong = dataclasses.replace(
        plan,
        nodes={
            name: dataclasses.replace(
                node, branches=dict(zip(node.branches, reversed(node.branches.values()), strict=True))
            )
            for name, node in plan.nodes.items()
        },
    )
    tree = kabo.up.plan_to_up(wrong, translation)
    assert failures(translation.original, tree)
    assert not kabo.verify(translation.problem, kabo.up.plan_from_up(tree, translation)).ok


@pytest.mark.parametrize("seed", range(16))
def test_pddl_of_a_problem_is_read_by_kabo_and_by_unified_planning_as_the_same(seed, tmp_path):
    problem = random_problem(seed, contingent=seed % 2 == 0)
    texts = kabo.up.pddl_from_up(problem)
    files = tmp_path / "domain.pddl", tmp_path / "problem.pddl"
    for file, text in zip(files, texts, strict=True):
        file.write_text(text)
    direct = kabo.solve(kabo.up.problem_from_up(problem).problem)
    read = kabo.solve(kabo.load_problem(files[1], files[0]))
    assert (read.plan is None) == (direct.plan is None)
    if "- thing)" in texts[0].split("(:action")[0].split("(:functions")[-1]:
        return  # its reader does not know functions with objects as values
    again = PDDLReader().parse_problem(str(files[0]), str(files[1]))
    result = kabo.up.KaboEngine().solve(again)
    assert (result.plan is None) == (direct.plan is None)
    assert result.plan is None or not failures(again, result.plan)


def test_pddl_says_what_is_observed_and_what_is_unknown():
    from tests.up.test_engine import doors

    domain, problem = kabo.up.pddl_from_up(doors(with_listening=True))
    assert ":observe (tiger_left)" in domain
    assert "(oneof (tiger_left) (tiger_right))" in problem
