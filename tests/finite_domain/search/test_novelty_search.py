"""The novelty search on STACKED n OBJECTS, whose goals nearly all have to be given up first."""

import pytest

from kabo.finite_domain import CompiledTask, SearchBudget, bfws
from tests.finite_domain.search.test_blind_search import counter
from tests.finite_domain.stacked import stacked


@pytest.mark.parametrize("n", [2, 3, 5, 8, 12])
def test_stacked_is_solved_in_the_fewest_actions(n):
    result = bfws(CompiledTask(stacked(n)))
    assert (result.status, len(result.plan)) == ("solved", 2 * n - 1)


@pytest.mark.parametrize("task", [stacked(6), counter(5)])
def test_both_twins_find_the_same_plan_after_the_same_work(task):
    compiled = CompiledTask(task)
    assert bfws(compiled, plain_work=1 << 30) == bfws(compiled, plain_work=0)


def test_the_agenda_of_stacked_goes_from_the_bottom_to_the_top():
    assert CompiledTask(stacked(5)).agenda.before == ((), (0,), (0, 1), (0, 1, 2), (0, 1, 2, 3))


def test_nothing_is_left_out_though_nothing_is_new():
    """Counting shows no new pair most of the time."""
    for work in (0, 1 << 30):
        result = bfws(CompiledTask(counter(5)), plain_work=work)
        assert len(result.plan) == 4**5 - 1
        assert bfws(CompiledTask(counter(3)), forbidden=[0, 1, 0], plain_work=work).status == "unsolvable"


def test_a_budget_exhausts_and_a_caller_stops():
    compiled = CompiledTask(counter(6))
    for work in (0, 1 << 30):
        assert bfws(compiled, plain_work=work, budget=SearchBudget(expansions=70)).expanded == 70
        assert bfws(compiled, plain_work=work, budget=SearchBudget(expansions=70)).status == "exhausted"
        assert bfws(compiled, plain_work=work, budget=SearchBudget(stop=lambda: True)).status == "stopped"
    assert bfws(compiled, plain_work=0, budget=SearchBudget(memory=1 << 20)).status == "exhausted"


def test_pairs_are_forgotten_alike_where_there_is_no_room_for_them(monkeypatch):
    monkeypatch.setattr("kabo.tuning.NOVELTY_PAIR_BYTES", 200)
    compiled = CompiledTask(stacked(5))
    assert bfws(compiled, plain_work=1 << 30) == bfws(compiled, plain_work=0)
