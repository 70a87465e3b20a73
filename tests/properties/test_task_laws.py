"""The laws of scheduling tasks: every strategy finds what is a solution by definition, all of it, pruned or not."""

from collections import Counter

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

from tests.support.inline_workers import InlineWorkers
from tests.support.oracles_alive import at_rest, audit
from tests.support.oracles_tasks import by_definition
from tests.support.random_tasks import Rich, Trees, canonical

JOBS = 400  # trees that need more are not followed to the end, and compared with nothing
STRATEGIES = {
    "rounds": {},
    "lazily": {"lazy": True},
    "depth first at first": {"depth_first": 30},
    "with workers": {"workers": 3},
}
SEEDS = st.integers(0, 10**9)
TREES = st.builds(
    lambda kind, seed, monitors, depth: kind(seed, monitors=monitors, depth=depth).task(),
    st.sampled_from([Trees, Rich, Rich, Rich]),
    SEEDS,
    st.booleans(),
    st.integers(2, 4),
)


def planned(task, *, jobs=JOBS, pruning=True, lazy=False, depth_first=0, workers=None, piece=None):
    """A task, planned anew."""
    task.reset()
    task.pruning, task.lazy, task.depth_first = pruning, lazy, depth_first
    if workers is not None:
        task._workers = InlineWorkers(task._run(None), workers, min_seconds=0.0)
    found = task.plan(jobs=jobs if piece is None else piece, workers=workers)
    while piece is not None and not task.exhausted and sum(s.calls for s in task.statistics.values()) < jobs:
        found = task.plan(jobs=piece, workers=workers)
    return found


@pytest.mark.parametrize("strategy", STRATEGIES)
@given(TREES)
def test_planning_to_the_end_finds_every_solution_once(strategy, task):
    truth = by_definition(task)
    assume(truth is not None)
    for pruning in (True, False):
        found = planned(task, pruning=pruning, **STRATEGIES[strategy])
        event(f"to the end: {task.exhausted}, solved: {bool(found)}")
        if task.exhausted:
            assert Counter(map(canonical, found)) == truth


@pytest.mark.parametrize("strategy", STRATEGIES)
@given(TREES)
def test_after_each_job_nothing_was_given_up_that_is_of_use(strategy, task):
    task.audit = audit
    planned(task, jobs=150, **STRATEGIES[strategy])
    if task.exhausted:
        at_rest(task._planning)


@given(TREES)
def test_pruning_saves_calls_and_costs_none(task):
    few, many = [], []
    for pruning, calls in ((True, few), (False, many)):
        planned(task, pruning=pruning)
        calls.append(sum(each.calls for each in task.statistics.values()))
        assume(task.exhausted)
    assert few <= many


@given(TREES, st.integers(1, 40), st.sampled_from([None, 3]))
def test_planning_in_pieces_or_with_workers_finds_the_same_in_the_same_order(task, piece, workers):
    at_once = [canonical(s) for s in planned(task, jobs=200)]
    exhausted = task.exhausted
    assert [canonical(s) for s in planned(task, jobs=200, piece=piece, workers=workers)][: len(at_once)] == at_once
    assert task.exhausted or not exhausted
