"""Looking at every node once: finds plans where there are any, proves where there are none, and ends."""

import pytest
from hypothesis import assume, event, given

from kabo import tuning
from kabo.knowledge import ground
from kabo.planner.search import contingent
from kabo.planner.search.fixpoint import Fixpoint
from kabo.planner.search.nodes import SearchSpace
from kabo.planner.search.skeleton import FoundSkeleton, SearchLimits, Skeleton, Unreachable
from kabo.planner.search.solved import Solved
from kabo.planner.search.weak_plans import BudgetSpent, Counter
from tests.support import oracles_knowledge as oracles
from tests.support.small_problems import branching_problems, gambles


@given(problem=branching_problems() | gambles())
def test_it_agrees_with_the_search_and_its_plans_reach_the_goal(problem):
    assume(not any(_sets_what_it_senses(each) for each in problem.domain.actions.values()))
    task = ground(problem)
    for may_wait in (False, True) if task.may_wait else (False,):
        counter = Counter(SearchLimits())
        looked = Fixpoint(SearchSpace(task, None, may_wait), counter).solve(100_000)
        if looked:
            break
    assert isinstance(looked, Solved) == isinstance(contingent.find_skeleton(task), FoundSkeleton)
    event(f"solved: {isinstance(looked, Solved)}")
    if isinstance(looked, Solved):
        assert len(list(Skeleton(looked.node).nodes())) <= 1 + 2 * counter.generated
        for world in oracles.worlds(problem, oracles.initial_state(problem)):
            oracles.execute(problem, looked.node, world)


@given(problem=branching_problems() | gambles())
def test_where_the_search_turns_to_it_the_answer_stays(problem):
    task = ground(problem)
    patience, tuning.FAILED_CHOICES_BEFORE_FIXPOINT = tuning.FAILED_CHOICES_BEFORE_FIXPOINT, 0
    try:
        soon = [contingent.find_skeleton(task, search=name) for name in ("greedy", "depth-first")]
    finally:
        tuning.FAILED_CHOICES_BEFORE_FIXPOINT = patience
    late = contingent.find_skeleton(task, search="greedy")
    assert {type(found) for found in soon} == {type(late)} <= {FoundSkeleton, Unreachable}


def test_it_stops_after_as_many_nodes_as_it_may_look_at_and_goes_on_from_there():
    problem = _ring(12)
    fixpoint = Fixpoint(SearchSpace(ground(problem), None), counter := Counter(SearchLimits()))
    assert fixpoint.solve(3) is True and counter.expanded == 3
    assert fixpoint.solve(100) is not True and counter.expanded <= 13


def test_the_budget_ends_it():
    with pytest.raises(BudgetSpent):
        Fixpoint(SearchSpace(ground(_ring(12)), None), Counter(SearchLimits(5))).solve(100)


def _sets_what_it_senses(action):
    """Such a step says that it delivers a fact which is known by then; the oracle wants it to be open."""
    added = {getattr(fact, "atom", None) for change in action.effects for fact in getattr(change, "facts", ())}
    return bool(added & set(action.sense))


def _ring(count):
    from kabo.language import formulas as f
    from kabo.language.problem import Function
    from tests.support.small_problems import action, add, app, cmp, know, problem

    at = app("at")
    steps = [
        action(f"go_{n}", pre=[know(cmp(at, "=", f"n{n}"))], effects=[add(cmp(at, "=", f"n{(n + 1) % count}"))])
        for n in range(count)
    ]
    values = tuple(f"n{n}" for n in range(count))
    goal = f.And((know(cmp(at, "=", "n1")), know(cmp(at, "=", "n2"))))
    where = Function("at", (), values=values)
    return problem(actions=steps, initial=[add(cmp(at, "=", "n0"))], goal=[goal], functions=[where])
