"""A connector that can join nothing because of the order of the stages ends planning, however many states still come."""

from itertools import count

import pytest

from kabo.tasks.core import Alternatives, Connector, Result, Task, forward, generator
from kabo.tasks.core.model.results import StructuralReason
from kabo.tasks.core.run.leaves import MAX_STRUCTURAL_MISMATCHES

TOLD = "AllowContact is missing"


@generator()
def endless(scene, properties, seed):
    yield from (Result(("free", number)) for number in count())


@generator()
def touching(scene, properties, seed):
    yield from (Result(("touching", number)) for number in count())


@generator()
def mixed(scene, properties, seed):
    yield from (Result(("free" if number % 10 == 0 else "touching", number)) for number in count())


@forward()
def late(scene, properties, seed):
    if scene[1] > 30:  # noqa: PLR2004
        yield Result(("touching", scene[1]))


@forward()
def same(scene, properties, seed):
    yield Result(scene)


class Join(Connector):
    def mismatch(self, start, end, properties):
        if start[1] > end[1]:
            return "it is later"
        return None if start[0] == end[0] else StructuralReason(TOLD)

    def connect(self, start, end, properties, seed):
        return [Result()]


@pytest.mark.parametrize("lazy", [False, True])
def test_planning_ends_and_says_why_before_all_else(lazy):
    task = Task("t", endless("here"), Join("way"), touching("there"), lazy=lazy)
    assert task.plan(max_solutions=1) == [] and not task.exhausted
    why = task.explain()
    assert why.stage is not None and why.stage.name == "way"
    reason, times = next(iter(why.mismatches.items()))
    assert reason == TOLD and MAX_STRUCTURAL_MISMATCHES <= times <= 2 * MAX_STRUCTURAL_MISMATCHES
    assert task.plan(max_solutions=1) == [], "and it ends at once when it is asked again"


def test_where_a_pair_has_fitted_planning_goes_on():
    task = Task("t", endless("here"), Join("way"), mixed("there"))
    assert len(task.plan(max_solutions=20)) == 20  # noqa: PLR2004
    assert task.figures(task.children[1]).mismatches[TOLD] > 100  # noqa: PLR2004


def test_where_children_are_chosen_among_another_one_may_fit():
    either = Alternatives("either", same("never"), late("late"))
    task = Task("t", endless("here"), either, Join("way"), touching("there"))
    assert len(task.plan(max_solutions=1, jobs=20_000)) == 1
