"""The laws of scheduling tasks: planning finds what is a solution by definition, all of it, pruned or not."""

from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from kabo.tasks.core import Flow
from tests.random_tasks import Trees, canonical, solutions

JOBS = 600  # trees that need more are not followed to the end, and compared with nothing


DEPTHS = st.integers(2, 4)  # of nested containers
SEEDS = st.integers(0, 10**9)


def planned(task, *, pruning, lazy=False):
    task.pruning, task.lazy = pruning, lazy
    task.reset()
    found = task.plan(jobs=JOBS)
    calls = sum(each.calls for each in task.statistics.values())
    return Counter(map(canonical, found)), calls, task.exhausted


@given(SEEDS, DEPTHS)
def test_planning_to_the_end_finds_every_solution_once(seed, depth):
    task = Trees(seed, monitors=False, depth=depth).task()
    found, _, exhausted = planned(task, pruning=True)
    if exhausted:
        assert found == Counter(solutions(task, Flow.GENERATE))


@given(SEEDS, DEPTHS)
def test_pruning_loses_nothing_even_where_stages_are_monitored(seed, depth):
    task = Trees(seed, monitors=True, depth=depth).task()
    pruned, few, done = planned(task, pruning=True)
    whole, many, all_done = planned(task, pruning=False)
    if done and all_done:
        assert pruned == whole
        assert few <= many


@given(SEEDS, DEPTHS)
def test_the_order_in_which_jobs_are_done_changes_nothing_in_the_end(seed, depth):
    task = Trees(seed, monitors=True, depth=depth).task()
    rounds, _, done = planned(task, pruning=True)
    lazily, _, all_done = planned(task, pruning=True, lazy=True)
    if done and all_done:
        assert rounds == lazily


@given(SEEDS, DEPTHS, st.integers(1, 40))
def test_planning_in_pieces_finds_the_same_in_the_same_order(seed, depth, piece):
    task = Trees(seed, monitors=True, depth=depth).task()
    at_once = [canonical(s) for s in task.plan(jobs=200)]
    task.reset()
    while len(task.solutions) < len(at_once):
        before = len(task.solutions)
        task.plan(jobs=piece)
        assert task.exhausted or len(task.solutions) >= before
        if task.exhausted:
            break
    assert [canonical(s) for s in task.solutions][: len(at_once)] == at_once
