"""Bounds of what weak plans cost are never too high, by brute force over all that can be known."""

import random
from dataclasses import replace
from heapq import heappop, heappush
from math import inf

import pytest

from kabo.errors import InputError
from kabo.knowledge import ground
from kabo.language import load_problem
from kabo.planner.search.cost_bounds import CostBounds
from kabo.planner.search.delete_relaxation import Relaxation
from tests.conftest import PROPERTY_SCALE
from tests.support.random_knowledge import random_problem
from tests.support.small_problems import action, add, atom, delete, know, lit, no, problem

COSTS = (0.0, 0.25, 1.0, 1.0, 2.5)
STATES = 300
Q, R = lit("q"), lit("r")


@pytest.fixture(scope="module")
def tasks(tmp_path_factory):
    """Random tasks, their actions at different costs."""
    folder, found = tmp_path_factory.mktemp("problems"), []
    for seed in range(max(30, round(800 * PROPERTY_SCALE))):
        domain, text = random_problem(seed)
        (folder / "domain.yaml").write_text(domain)
        (folder / "problem.yaml").write_text(text)
        try:
            task = ground(load_problem(folder / "problem.yaml"))
        except InputError:
            continue
        draw = random.Random(seed)
        actions = tuple(replace(one, cost=draw.choice(COSTS)) for one in task.actions)
        found.append(replace(task, actions=actions))
    return found


def comes_from(task):
    """For each state that can be reached, the states one step before it with what the step costs."""
    before = {task.initial: []}
    waiting = [task.initial]
    for state in waiting:  # grows while it is walked
        branching = task.open_branching(state)
        steps = [] if branching is None else [(child, 0.0) for _, child in branching.outcomes(state)]
        steps += [(one.after(state), one.cost) for one in task.actions if one.applicable(state)]
        for child, cost in steps:
            if child is None or (child not in before and len(before) >= STATES):
                continue
            if child not in before:
                before[child] = []
                waiting.append(child)
            before[child].append((state, cost))
    return before


def least_costs(task, before):
    """What the cheapest way to the goal costs from each state, every outcome as hoped."""
    costs = {state: 0.0 if task.goal_query.holds(state) else inf for state in before}
    queue = [(0.0, state) for state, cost in costs.items() if cost == 0.0]
    while queue:
        cost, state = heappop(queue)
        for earlier, price in before[state] if cost <= costs[state] else ():
            if cost + price < costs[earlier]:
                costs[earlier] = cost + price
                heappush(queue, (cost + price, earlier))
    return costs


def test_no_way_costs_less_than_its_bound(tasks):
    told = exact = 0
    for task in tasks:
        bounds = CostBounds(task, Relaxation(task))
        for state, cost in least_costs(task, comes_from(task)).items():
            bound = bounds.below(state)
            assert cost == inf if bound is None else bound <= cost + 1e-9
            told += bound is not None and bound > 0.0
            exact += bound is not None and bound > 0.0 and bound >= cost - 1e-9
    assert told > len(tasks) and exact > told // 3


def below(*actions, goal, **pieces):
    task = ground(problem(actions=list(actions), goal=goal, **pieces))
    return CostBounds(task, Relaxation(task)).below(task.initial)


def test_what_one_action_does_in_two_ways_is_paid_once():
    once = action("both", effects=[add(Q), add(R)])
    assert below(once, goal=[know(Q), know(R)]) == 1.0


def test_sensing_may_turn_out_well_but_is_paid():
    look = action("look", sense=[atom("q")])
    assert below(look, goal=[know(Q)]) == 1.0
    assert below(look, goal=[know(Q)], initial=[add(no("q"))]) is None


def test_what_must_be_done_first_is_counted():
    first = action("first", effects=[add(R), delete(Q)])
    then = action("then", pre=[know(R)], effects=[add(Q)])
    assert below(first, then, goal=[know(Q)]) == 2.0
