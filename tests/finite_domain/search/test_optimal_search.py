"""A* with LM-cut on STACKED n OBJECTS, and on tasks made for its corners."""

import pytest

from kabo.finite_domain import CompiledTask, Effect, FiniteTask, Operator, SearchBudget, StateVariable, astar
from tests.finite_domain.search.test_blind_search import counter
from tests.finite_domain.stacked import stacked


@pytest.mark.parametrize("n", [2, 3, 5, 10])
def test_the_bound_sees_through_goals_that_have_to_be_given_up(n):
    """All goals but two hold at the start of STACKED, and the bound is what the plan costs."""
    result = astar(CompiledTask(stacked(n)), plain_work=0)
    assert (result.status, result.cost, result.initial_estimate) == ("solved", 2 * n - 1, 2 * n - 1)
    assert result.expanded == 2 * n - 1


@pytest.mark.parametrize("work", [0, 1 << 30])
def test_many_cheap_actions_are_better_than_one_dear_action(work):
    leap = Operator("leap", ((0, (0,)),), (Effect((), 0, 3),), 7)
    steps = [Operator(f"step {x}", ((0, (x,)),), (Effect((), 0, x + 1),), 2) for x in range(3)]
    task = FiniteTask((StateVariable("place", 4),), (0,), (leap, *steps), ((0, (3,)),))
    result = astar(CompiledTask(task), plain_work=work)
    assert (result.cost, result.plan, result.optimal) == (6, (1, 2, 3), True)
    assert astar(CompiledTask(task), forbidden=[0, 0, 1, 0], plain_work=work).plan == (0,)
    assert astar(CompiledTask(task), forbidden=[1, 0, 1, 0], plain_work=work).status == "unsolvable"
    assert astar(CompiledTask(task), start=(3,), plain_work=work).plan == ()


def test_two_goals_made_by_one_effect_and_its_condition_pay_once():
    """Making the second goal needs the first to be false, but one doing makes both."""
    both = Operator("both", ((0, (0,)),), (Effect((), 0, 1), Effect(((2, (0,)),), 1, 1)), 2)
    task = FiniteTask(tuple(StateVariable(name, 2) for name in "abc"), (0, 0, 0), (both,), ((0, (1,)), (1, (1,))))
    result = astar(CompiledTask(task), plain_work=0)
    assert (result.cost, result.initial_estimate) == (2, 2)


@pytest.mark.parametrize("work", [0, 1 << 30])
def test_counting_takes_every_step(work):
    result = astar(CompiledTask(counter(4)), plain_work=work)
    assert (result.status, result.cost) == ("solved", 4**4 - 1)


@pytest.mark.parametrize("work", [0, 1 << 30])
def test_a_budget_exhausts_and_a_caller_stops(work):
    compiled = CompiledTask(counter(8))
    assert astar(compiled, plain_work=work, budget=SearchBudget(expansions=70)).status == "exhausted"
    assert astar(compiled, plain_work=work, budget=SearchBudget(stop=lambda: True)).status == "stopped"


def test_memory_exhausts():
    assert astar(CompiledTask(counter(6)), plain_work=0, budget=SearchBudget(memory=1 << 18)).status == "exhausted"
