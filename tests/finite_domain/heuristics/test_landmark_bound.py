"""LM-cut over given operators: never above the least cost of any choice of owners, by brute force."""

import random
from itertools import combinations

import numpy as np

from kabo.finite_domain import RelaxedOperator
from kabo.finite_domain.heuristics.landmark_bound import LandmarkBound
from tests.conftest import PROPERTY_SCALE

CASES = max(60, round(2000 * PROPERTY_SCALE))


def drawn(seed):
    """Facts, operators, what is true, the goal, and what owners cost."""
    draw = random.Random(seed)
    facts, owners = draw.randint(3, 9), draw.randint(1, 7)

    def some(most):
        return tuple(draw.sample(range(facts), draw.randint(0, min(most, facts))))

    operators = [
        RelaxedOperator(some(3), some(3), draw.randint(0, 3), draw.choice([-1, *range(owners), *range(owners)]))
        for _ in range(draw.randint(1, 16))
    ]
    costs = {owner: draw.choice([0, 1, 1, 2, 5]) for owner in range(owners)}
    return facts, operators, sorted(some(2)), some(3), costs


def reached(operators, true, chosen):
    """What becomes true with these owners, and all axioms."""
    facts, old = set(true), None
    while facts != old:
        old = set(facts)
        for o in operators:
            if (o.owner < 0 or o.owner in chosen) and facts.issuperset(o.preconditions):
                facts.update(o.adds)
    return facts


def least(operators, true, goal, costs):
    """The least cost of owners with which the goal is reached; None: it is not."""
    able = [
        sum(costs[owner] for owner in chosen)
        for size in range(len(costs) + 1)
        for chosen in combinations(costs, size)
        if reached(operators, true, chosen).issuperset(goal)
    ]
    return min(able, default=None)


def test_the_bound_is_never_above_the_least_cost_and_tells_what_is_out_of_reach():
    positive = exact = 0
    for seed in range(CASES):
        facts, operators, true, goal, costs = drawn(seed)
        bound = LandmarkBound(facts, operators, goal, costs).below(np.array(true, np.int64))
        cost = least(operators, true, goal, costs)
        if cost is None or bound is None:
            assert bound == cost, seed
            continue
        assert 0 <= bound <= cost and (bound > 0) == (cost > 0), seed
        positive += cost > 0
        exact += 0 < cost == bound
    assert positive > CASES // 20 and exact > positive // 2


def test_an_owner_of_two_conditional_effects_pays_once():
    operators = [RelaxedOperator((0,), (1,), 1, 7), RelaxedOperator((0, 2), (3,), 1, 7)]
    bound = LandmarkBound(4, operators, (1, 3), {7: 5})
    assert bound.below(np.array([0, 2])) == 5
    assert bound.below(np.array([0])) is None


def test_one_bound_may_be_asked_many_times():
    bound = LandmarkBound(
        3, [RelaxedOperator((0,), (1,), 1, 0), RelaxedOperator((1,), (2,), 1, 1)], (2,), {0: 2, 1: 3}
    )
    assert [bound.below(np.array(true, np.int64)) for true in ([0], [1], [2], [], [0])] == [5, 3, 0, None, 5]
