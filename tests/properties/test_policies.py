"""Laws of a plan's views: a policy reaches the goal in every possible world, a tree has exactly the plan's branches."""

import pytest
from hypothesis import given

from kabo.errors import InputError
from kabo.language import load_problem
from kabo.plan import Observation, policy, topological_order, unfold
from kabo.planner.solve import solve
from kabo.verify import verify_plan
from kabo.verify.knowledge.facts import truth
from kabo.verify.knowledge.ground import outcome_text
from kabo.verify.knowledge.replay.interpreter import Interpreter
from kabo.verify.knowledge.replay.relevance import Relevance
from tests.conftest import PROPERTY_SCALE
from tests.domains.families import generated
from tests.properties.test_plan import branches, built, trees, unfolded
from tests.support.linked_worlds import all_worlds, linked_groups
from tests.support.random_knowledge import random_problem

COUNT = max(60, round(1000 * PROPERTY_SCALE))


@given(tree=trees())
def test_unfolding_gives_exactly_the_branches_of_the_plan(tree):
    plan = built(tree)
    alone = unfold(plan)
    assert branches(unfolded(alone, alone.root)) == branches(unfolded(plan, plan.root))
    assert len(alone.nodes) == 1 + sum(len(node.successors) for node in alone.nodes.values())


@given(tree=trees())
def test_histories_are_the_branches(tree):
    plan = built(tree)
    rules = dict(policy(plan).rules())
    leaves = [history for history, decision in rules.items() if decision.is_last]
    assert len(leaves) == len(branches(tree))
    for history, decision in rules.items():
        assert policy(plan)(history) == decision
        assert all((*history, Observation(decision.observe, o)) in rules for o in decision.outcomes)


def all_that_is_the_case(interpreter, plan):
    """Every world, as the knowledge of somebody who knows all of it that matters to the plan."""
    start = interpreter.initial()
    symbols = Relevance(plan, topological_order(plan), interpreter).mattering(plan.root)
    for values in all_worlds(linked_groups(interpreter.problem, start, interpreter.rules, symbols), 3000) or ():
        state = start
        for symbol, value in values.items():
            state = state and interpreter.learned(state, symbol, value)
        if state is not None:
            yield state


def run(interpreter, plan, world):
    """The world after the policy; None if an action does what only luck decides."""
    history, chosen = [], policy(plan)
    while True:
        decision = chosen(history)
        for node in decision.actions:
            action = interpreter.action(node.action, node.arguments)
            assert all(holds(world) for holds in action.preconditions), f"{node.action} claims what is not so"
            world, _ = interpreter.act(world, action)
        if decision.is_last:
            return world
        thing = interpreter.read(decision.observe)
        if isinstance(thing[0], str):
            value = world.known.get(thing)
        else:
            truths = [truth(claim, world) for claim in thing]
            value = None if None in truths else all(truths)
        if value is None:
            return None
        history.append(Observation(decision.observe, outcome_text(value)))


@pytest.mark.parametrize(
    ("family", "settings"),
    [
        ("btcs", {"n": 4}),
        ("coloured_balls", {"n": 3}),
        ("doors", {"n": 3}),
        ("grid", {"n": 5}),
        ("medicate", {"n": 5}),
        ("safes", {"n": 3}),
        ("unix", {"n": 1}),
        ("wumpus", {"n": 4}),
    ],
)
def test_a_policy_solves_every_world_of_a_family(tmp_path, family, settings):
    problem = generated(tmp_path, family, **settings)
    plan, interpreter = solve(problem).plan, Interpreter(problem)
    worlds = list(all_that_is_the_case(interpreter, plan))
    assert len(worlds) > 2
    for world in worlds:
        after = run(interpreter, plan, world)
        assert after is not None
        assert interpreter.reaches_goal(after)


def test_a_policy_reaches_the_goal_in_every_possible_world(tmp_path):
    """Random problems without effects that depend on knowledge: a world is then changed alike whoever knows it."""
    worlds = observing = 0
    for seed in range(COUNT):
        domain, text = random_problem(seed)
        if any(
            word in domain + text
            for word in ("=>", "not K(", "del(", "LCW", "always", "initially", "update_rules")
        ):
            continue
        (tmp_path / "domain.yaml").write_text(domain)
        (tmp_path / "problem.yaml").write_text(text)
        problem = load_problem(tmp_path / "problem.yaml")
        try:
            plan = solve(problem, max_expansions=20_000).plan
        except InputError:
            continue
        if plan is None:
            continue
        assert verify_plan(problem, unfold(plan), knowledge_only=True).ok
        interpreter = Interpreter(problem)
        for world in all_that_is_the_case(interpreter, plan):
            after = run(interpreter, plan, world)
            if after is not None:
                assert interpreter.reaches_goal(after), f"seed {seed}, {world.known}"
                worlds += 1
                observing += len(plan.nodes) > 2
    assert min(worlds, observing) > COUNT // 20, (worlds, observing)
