"""Breadth-first search on STACKED n OBJECTS and on tasks made for its corners."""

import numpy as np
import pytest

from kabo.finite_domain import (
    CompiledTask,
    Effect,
    FiniteTask,
    Operator,
    SearchBudget,
    StateVariable,
    breadth_first,
    validate,
)
from kabo.finite_domain.search.compiled_breadth_first import _BreadthFirstArrays
from tests.finite_domain.stacked import stacked


def counter(digits, base=4):
    """Counts up from zero; the goal is the last number, and the only plan is to count all the way."""
    operators = [
        Operator(
            f"carry into digit {d}",
            tuple((k, (base - 1,)) for k in range(d)),
            (
                *(Effect((), k, 0) for k in range(d)),
                *(Effect(((d, (x,)),), d, x + 1) for x in range(base - 1)),
            ),
        )
        for d in range(digits)
    ]
    variables = tuple(StateVariable(f"digit {d}", base) for d in range(digits))
    return FiniteTask(variables, (0,) * digits, tuple(operators), tuple((d, (base - 1,)) for d in range(digits)))


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6])
def test_stacked_takes_two_actions_for_each_block_less_one(n):
    task = stacked(n)
    assert n > 4 or not validate(task)
    result = breadth_first(CompiledTask(task))
    assert (result.status, len(result.plan), result.optimal) == ("solved", 2 * n - 1, True)


def test_both_twins_find_the_same_plan_after_the_same_work():
    compiled = CompiledTask(stacked(5))
    plain, kernel = breadth_first(compiled, plain_work=1 << 30), breadth_first(compiled, plain_work=0)
    assert plain == kernel


def test_states_of_many_words_are_found_again():
    """35 variables that nobody touches make the states long; counting visits each number once."""
    task = counter(6)
    still = tuple(StateVariable(f"still {i}", 9) for i in range(35))
    wide = FiniteTask(still + task.variables, (3,) * 35 + task.initial, _shifted(task, 35), _moved(task.goal, 35))
    compiled = CompiledTask(wide)
    assert compiled.packing.words > 1
    result = breadth_first(compiled, plain_work=0)
    assert (len(result.plan), result.states) == (4**6 - 1, 4**6)


def _moved(conditions, by):
    return tuple((v + by, values) for v, values in conditions)


def _shifted(task, by):
    return tuple(
        Operator(
            o.name,
            _moved(o.preconditions, by),
            tuple(Effect(_moved(e.conditions, by), e.variable + by, e.value) for e in o.effects),
        )
        for o in task.operators
    )


def test_memory_grows_with_what_is_found():
    result = breadth_first(CompiledTask(counter(9)), plain_work=0)
    assert (len(result.plan), result.states) == (4**9 - 1, 4**9)


def test_a_budget_of_expansions_or_memory_exhausts_and_a_caller_stops():
    compiled = CompiledTask(counter(9))
    for work in (0, 1 << 30):
        assert breadth_first(compiled, plain_work=work, budget=SearchBudget(expansions=70)).status == "exhausted"
        assert breadth_first(compiled, plain_work=work, budget=SearchBudget(expansions=70)).expanded == 70
        assert breadth_first(compiled, plain_work=work, budget=SearchBudget(stop=lambda: True)).status == "stopped"
    small = _BreadthFirstArrays(np.zeros(1, np.uint64), 9)
    kept = small.states.nbytes + small.parents.nbytes + small.table.nbytes
    assert breadth_first(compiled, plain_work=0, budget=SearchBudget(memory=2 * kept)).status == "exhausted"


def test_a_goal_that_holds_takes_no_action_and_one_beyond_reach_is_proven_so():
    task = counter(3)
    done = FiniteTask(task.variables, (3, 3, 3), task.operators, task.goal)
    assert breadth_first(CompiledTask(done)).plan == ()
    compiled = CompiledTask(task)
    for work in (0, 1 << 30):
        result = breadth_first(compiled, forbidden=[0, 1, 0], plain_work=work)
        assert (result.status, result.plan, result.states) == ("unsolvable", None, 4)


def test_wrong_starts_and_wrong_bans_are_refused():
    compiled = CompiledTask(counter(3))
    with pytest.raises(ValueError, match="a value for each of the 3 variables"):
        breadth_first(compiled, start=(0, 4, 0))
    with pytest.raises(ValueError, match="one entry for each of the 3 operators"):
        breadth_first(compiled, forbidden=[0])
