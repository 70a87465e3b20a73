"""What a task may say, and what searches make of tasks at the edge."""

import pytest

from kabo.finite_domain import (
    CompiledTask,
    Effect,
    FiniteTask,
    Operator,
    StateVariable,
    astar,
    bfws,
    breadth_first,
    validate,
)
from kabo.finite_domain.normal_form import normal_form
from kabo.finite_domain.task import successor

A = (StateVariable("a", 3), StateVariable("b", 2))


def task(*operators, goal=((0, (1,)),), initial=(0, 0), variables=A):
    return FiniteTask(variables, initial, operators, goal)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (task(Operator("o", ((2, (0,)),), ())), "operator o tests variable 2"),
        (task(Operator("o", (), (Effect((), 0, 3),))), "sets variable 0 to 3"),
        (task(Operator("o", (), (Effect((), 0, 1), Effect((), 0, 2)))), "to 1 and 2 at once"),
        (task(Operator("o", (), (Effect(((1, (0,)),), 0, 1), Effect(((0, (0,)),), 0, 2)))), "to 1 and 2 at once"),
        (task(Operator("o", (), (), -1)), "costs -1"),
        (task(initial=(0, 2)), "initial values"),
        (task(goal=((0, (7,)),)), "the goal tests variable 0"),
        (task(variables=(StateVariable("a", 3), StateVariable("b", 0))), "variable b has no value"),
    ],
)
def test_what_is_wrong_is_said(wrong, said):
    assert any(said in sentence for sentence in validate(wrong))


def test_an_effect_with_a_condition_counts_before_one_without():
    o = Operator("o", (), (Effect(((1, (0,)),), 0, 2), Effect((), 0, 1)))
    assert not validate(task(o))
    assert successor(o, (0, 0)) == (2, 0)
    assert successor(o, (0, 1)) == (1, 1)
    for search in (breadth_first, bfws, astar):
        for work in (0, 1 << 30):
            assert search(CompiledTask(task(o)), plain_work=work).status == "unsolvable"
            assert search(CompiledTask(task(o, goal=((0, (2,)),))), plain_work=work).plan == (0,)
            assert search(CompiledTask(task(o)), start=(0, 1), plain_work=work).plan == (0,)


def test_operators_share_what_depends_on_a_variable_in_whatever_order_they_say_it():
    low, high = Effect(((0, (0,)),), 1, 1), Effect(((0, (1,)),), 2, 1)
    variables = (*A, StateVariable("c", 2))
    found = normal_form(task(Operator("o", (), (low, high)), Operator("p", (), (high, low)), variables=variables))
    assert len(found.switches) == 1
    assert [one.switches for one in found.operators] == [(0,), (0,)]
    for values, after in (((0, 0, 0), (0, 1, 0)), ((1, 0, 0), (1, 0, 1)), ((2, 0, 0), (2, 0, 0))):
        assert successor(Operator("o", (), (low, high)), values) == after


@pytest.mark.parametrize("search", [breadth_first, bfws, astar])
@pytest.mark.parametrize("work", [0, 1 << 30])
def test_edges(search, work):
    def ask(asked):
        result = search(CompiledTask(asked), plain_work=work)
        return result.status, result.plan

    step = Operator("step", (), (Effect((), 0, 1),))
    assert ask(FiniteTask((), (), (), ())) == ("solved", ())
    assert ask(task()) == ("unsolvable", None)
    assert ask(task(step, goal=((0, ()),))) == ("unsolvable", None)  # no value is allowed
    assert ask(task(Operator("never", ((0, ()),), step.effects))) == ("unsolvable", None)
    assert ask(task(Operator("torn", ((0, (0,)), (0, (1,))), step.effects))) == ("unsolvable", None)
    assert ask(task(step)) == ("solved", (0,))
    ring = tuple(Operator(f"{i}", ((0, (i,)),), (Effect((), 0, (7 * i + 1) % 300),)) for i in range(300))
    around = FiniteTask(
        (StateVariable("place", 300),), (0,), ring, ((0, (57,)),)
    )  # 0, 1, 8, 57: several groups of 64
    assert ask(around) == ("solved", (0, 1, 8))
