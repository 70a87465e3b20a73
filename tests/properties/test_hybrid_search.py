"""Hybrid search against brute force: geometry is a random function, and all of its answers can be looked at.

Whatever is learnt from refusals, no plan may be lost by it, and every plan must be right.
"""

from collections import Counter

import pytest

from kabo.geometry_server import Success
from kabo.knowledge import ground
from kabo.options import Options
from kabo.planner.geometry import eager as interleaved
from kabo.planner.geometry import refusals as ledger
from kabo.planner.rounds import GeometricRounds
from kabo.planner.run import SolveRun
from kabo.planner.solve import planned
from tests.conftest import PROPERTY_SCALE
from tests.support.random_geometry import COMPONENTS, Hybrid, numbers, random_hybrid

COUNT = max(20, round(500 * PROPERTY_SCALE))  # of each kind; 1,200 more were run once: docs/decisions/017
EXPANSIONS = 30_000
SEARCHES = ("best", "breadth-first", "depth-first", "iterative-deepening")


def played(hybrid: Hybrid, search: str, order: str):
    """What the rounds of planning end with, and what was learnt of geometry."""
    options = Options(search, 0, 0.01, "bounding", order, EXPANSIONS, 1_000_000, 60.0)
    run = SolveRun(hybrid.problem, options, None, None)
    task = ground(hybrid.problem)
    rounds = GeometricRounds(run, task, hybrid, lambda _: None)  # type: ignore[arg-type]
    return planned(run, task, rounds), rounds.geometry


def check(hybrid: Hybrid, variants) -> None:
    """Follows every branch: what an action needs is known, its motion is one of the answers, the goal holds at the end."""
    acts = {act.name: act for act in hybrid.acts}
    waiting = [(variants[0], (*(False for _ in range(3)), None), dict.fromkeys(COMPONENTS, (0,)))]
    while waiting:
        variant, known, values = waiting.pop()
        node = variant.node
        if node.action is not None:
            act = acts[node.action.name]
            assert hybrid._holds(act.needs, known), act
            known = hybrid.after(act, known)
            if act.moves:
                assert isinstance(variant.answer, Success)
                assert all(set(values[name]) <= set(numbers(variant.situation, name)) for name in COMPONENTS)
                changes = {n: numbers_of(n, value) for n, value in variant.answer.changes.items()}
                free, _ = hybrid.answers(act, values, hybrid.most_effort)
                assert hybrid.impossible(act, values) is None
                assert changes in free
                values = {**values, **{name: (value,) for name, value in changes.items()}}
        if node.is_goal:
            assert hybrid.is_goal(known)
        for outcome, after in variant.following.items():
            sensed = known if outcome is None else (*known[:-1], outcome == "true")
            waiting.append((after, sensed, values))


def numbers_of(name, value):
    return int(value[0] if isinstance(value, tuple) else value.position[0])


CASES = [(search, order, senses) for search in SEARCHES for order in ("lazy", "eager") for senses in (False, True)]
MORE = [("best", "adaptive", True), ("greedy", "lazy", True), ("astar", "lazy", True), ("astar", "eager", False)]


@pytest.mark.slow
@pytest.mark.parametrize(("search", "order", "senses"), [*CASES, *MORE])
def test_a_plan_is_found_if_and_only_if_brute_force_finds_one(search, order, senses, monkeypatch):
    for module in (ledger, interleaved):
        monkeypatch.setattr(module, "MAX_EFFORT", 2)
    seen, lost = Counter(), {}
    for seed in range(COUNT):
        hybrid = random_hybrid(seed, senses)
        found, geometry = played(hybrid, search, order)
        solvable = hybrid.solvable()
        seen[type(found).__name__] += 1
        if isinstance(found, tuple):
            assert solvable, seed
            check(hybrid, found)
        elif solvable:
            lost[seed] = found
    assert not lost
    assert min(seen.values()) > COUNT // 8, seen


@pytest.mark.parametrize(
    ("seed", "search"),
    [(1300, "breadth-first")],
)
def test_problems_that_were_lost_once_are_solved(seed, search, monkeypatch):
    monkeypatch.setattr(ledger, "MAX_EFFORT", 2)
    hybrid = random_hybrid(seed, False)
    assert isinstance(played(hybrid, search, "lazy")[0], tuple)
