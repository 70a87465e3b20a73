"""Relaxed plans of tasks small enough to see the answer, from both twins."""

import numpy as np
import pytest

from kabo.finite_domain import RelaxedOperator, RelaxedTask

ENGINES = ("python", "compiled")
CHAIN = (RelaxedOperator((0,), (1,), 1, 7), RelaxedOperator((1,), (2,), 1, 8), RelaxedOperator((1, 2), (3,), 2, 9))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_chain_costs_the_sum_and_prefers_its_first_link(engine):
    estimate = RelaxedTask(4, CHAIN, (3,), engine=engine).evaluate([0])
    assert estimate.value == 4
    assert estimate.preferred == (7,)
    assert sorted(estimate.plan_facts) == [1, 2, 3]


@pytest.mark.parametrize("engine", ENGINES)
def test_what_cannot_be_reached_has_no_value(engine):
    task = RelaxedTask(5, CHAIN, (4,), engine=engine)
    assert task.evaluate([0, 1, 2]).value is None
    assert task.evaluate([4]).value == 0


@pytest.mark.parametrize("engine", ENGINES)
def test_an_operator_is_preferred_through_axioms(engine):
    operators = [RelaxedOperator((0,), (1,), 0), RelaxedOperator((1,), (2,), 3, 5)]
    estimate = RelaxedTask(3, operators, (2,), engine=engine).evaluate([0])
    assert estimate == (3, (5,), (2,))


@pytest.mark.parametrize("engine", ENGINES)
def test_an_owner_pays_once_for_its_dearest_operator(engine):
    operators = [RelaxedOperator((0,), (1,), 2, 3), RelaxedOperator((0,), (2,), 5, 3)]
    assert RelaxedTask(3, operators, (1, 2), engine=engine).evaluate([0]) == (5, (3,), (2, 1))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_free_owned_operator_is_no_axiom(engine):
    operators = [RelaxedOperator((0,), (1,), 0, 1), RelaxedOperator((1,), (2,), 4, 2)]
    assert RelaxedTask(3, operators, (2,), engine=engine).evaluate([0])[:2] == (4, (1,))


@pytest.mark.parametrize("engine", ENGINES)
def test_bits_lists_and_arrays_of_facts_are_the_same_question(engine):
    task = RelaxedTask(70, [RelaxedOperator((0, 69), (5,), 1, 0)], (5,), engine=engine)
    assert task.evaluate([69, 0]) == task.evaluate(np.array([0, 69])) == task.evaluate(1 << 69 | 1)


@pytest.mark.parametrize("engine", ENGINES)
def test_another_goal_may_be_asked_in_between(engine):
    task = RelaxedTask(4, CHAIN, (3,), engine=engine)
    assert task.evaluate([0], goal=(1,)).value == 1
    assert task.with_goal((2,)).evaluate([0]).value == 2
    assert task.evaluate([0]).value == 4
    assert task.evaluate([0], goal=()).value == 0


@pytest.mark.parametrize("engine", ENGINES)
def test_exploding_sums_are_cut_off_and_still_answered(engine):
    """Each fact needs the two before it, so that h_add doubles and more at every step."""
    operators = [RelaxedOperator((max(i - 1, 0), i), (i + 1,), 1 << 20, i) for i in range(99)]
    assert RelaxedTask(100, operators, (99,), engine=engine).evaluate([0]).value == 99 << 20


@pytest.mark.parametrize("engine", ENGINES)
def test_costs_beyond_the_buckets_are_corrected_until_they_are_least(engine):
    """Dear first, then cheaper by a hair, both in the last bucket."""
    operators = [
        RelaxedOperator((), (0,), 1),
        RelaxedOperator((0,), (1,), 9000, 1),
        RelaxedOperator((0,), (2,), 8000, 2),
        RelaxedOperator((2,), (1,), 500, 3),
        RelaxedOperator((1,), (3,), 7, 4),
    ]
    assert RelaxedTask(4, operators, (3,), engine=engine).evaluate([]).value == 1 + 8000 + 500 + 7


def test_much_asking_loads_the_kernel(monkeypatch):
    monkeypatch.setattr("kabo.tuning.PLAIN_RELAXATION_VISITS", 20)
    task = RelaxedTask(4, CHAIN, (3,))
    answers = {task.evaluate([0]) for _ in range(9)}
    assert len(answers) == 1
    assert task._core._switched


def test_layers_count_rounds_and_axioms_take_none():
    operators = [*CHAIN, RelaxedOperator((2,), (4,), 0)]
    task = RelaxedTask(6, operators, (3,))
    assert task.layers([0]).tolist() == [0, 1, 2, 3, 2, -1]
    assert task.reachable(1).tolist() == [True] * 5 + [False]


@pytest.mark.parametrize(
    ("facts", "operators", "goal"),
    [
        (2, [RelaxedOperator((2,), (1,))], (0,)),
        (2, [RelaxedOperator((0,), (-1,))], (0,)),
        (2, [RelaxedOperator((0,), (1,), -1)], (0,)),
        (2, [], (2,)),
    ],
)
def test_numbers_out_of_range_are_refused(facts, operators, goal):
    with pytest.raises(ValueError, match=r"beyond|from 0"):
        RelaxedTask(facts, operators, goal)
