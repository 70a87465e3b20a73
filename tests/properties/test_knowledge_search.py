"""Laws of the contingent search [docs/explanation/knowledge.md]: every leaf fulfils the goal, and "no plan" is a proof."""

import os
import subprocess
import sys

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.knowledge import ground
from kabo.planner.search.algorithms import ALGORITHMS
from kabo.planner.search.contingent import find_skeleton
from kabo.planner.search.skeleton import FoundSkeleton, Unreachable
from tests.support import oracles_knowledge as oracles
from tests.support.small_problems import branching_problems, gambles, problems

ANY = st.one_of(gambles(), branching_problems(), problems())


@given(problem=ANY, search=st.sampled_from(sorted(ALGORITHMS)))
def test_a_plan_reaches_the_goal_in_every_possible_world(problem, search):
    """Executed step by step by an interpreter that shares no code with the planner."""
    found = find_skeleton(ground(problem), search=search)
    event(type(found).__name__)
    if isinstance(found, FoundSkeleton):
        nodes = list(found.skeleton.nodes())
        event(f"branches: {sum(len(node.outcomes) for node in nodes)}")
        for world in oracles.worlds(problem, oracles.initial_state(problem)):
            oracles.execute(problem, found.skeleton.root, world)


def agrees_with_brute_force(problem):
    """All searches agree, and lie between brute force with and without stopping early at a goal."""
    found = [find_skeleton(ground(problem), search=search) for search in ALGORITHMS]
    assert all(isinstance(result, FoundSkeleton | Unreachable) for result in found)
    solved = {isinstance(result, FoundSkeleton) for result in found}
    assert len(solved) == 1, "the searches disagree"
    surely, perhaps = oracles.solvable(problem, early=False), oracles.solvable(problem, early=True)
    event(f"solvable: {perhaps}" + ("" if surely == perhaps else ", depends on the order of branching"))
    assert surely <= solved.pop() <= perhaps


@given(problem=st.one_of(branching_problems(), problems()))
def test_there_is_a_plan_if_and_only_if_brute_force_finds_one(problem):
    """The least fixpoint over all reachable knowledge states."""
    agrees_with_brute_force(problem)


@pytest.mark.slow
@settings(max_examples=3 * settings().max_examples)
@given(problem=gambles())
def test_a_failure_that_hangs_on_an_ancestor_is_no_proof_elsewhere(problem):
    """Boards full of circles: what cannot be solved on the way from one node may be solvable from another."""
    agrees_with_brute_force(problem)


@given(problem=ANY)
def test_breadth_first_and_iterative_deepening_find_shortest_weak_plans(problem):
    """The first weak plan is as long as the goal is far, if no branch forces another way."""
    for search in ("breadth-first", "iterative-deepening"):
        found = find_skeleton(ground(problem), search=search)
        if isinstance(found, FoundSkeleton) and not any(node.outcomes for node in found.skeleton.nodes()):
            length = sum(node.action is not None for node in found.skeleton.nodes())
            event(f"length: {length}")
            assert length == oracles.shortest_weak_plan(problem)


PROGRAM = """
from hypothesis import HealthCheck, given, settings
from kabo.knowledge import ground
from kabo.planner.search.contingent import find_skeleton
from tests.support.small_problems import branching_problems

@settings(max_examples=40, derandomize=True, database=None, deadline=None, suppress_health_check=list(HealthCheck))
@given(problem=branching_problems())
def show(problem):
    found = find_skeleton(ground(problem))
    print(type(found).__name__, found.statistics)
    if hasattr(found, "skeleton"):
        nodes = list(found.skeleton.nodes())
        number = {id(node): i for i, node in enumerate(nodes)}
        for node in nodes:
            print(node.action, node.on, node.delivers, [(o, number[id(c)]) for o, c in node.outcomes])
show()
"""


def test_the_hash_seed_of_python_changes_nothing():
    """Equal input gives an equal skeleton and equal counts in another process."""
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    texts = {
        subprocess.run(
            [sys.executable, "-c", PROGRAM],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
            cwd=root,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(texts) == 1
    assert "FoundSkeleton" in texts.pop()
