"""Sensing that nothing needs: the plan is that of the same problem without it, found by the same search."""

from pathlib import Path

import pytest

import kabo
from kabo.knowledge import ground
from kabo.language.problem import Problem
from kabo.planner.search.packed import PackedTask
from kabo.planner.search.skeleton import SearchLimits
from tests.domains.scenes import DOMAINS

LOOK = """
  look:
    parameters: {this: block}
    preconditions:
      - not Kw(marked(this))
    sense: marked(this)
"""


def stacked(folder: Path, n: int, *, look: bool, goal: str = "", initial: str = "") -> Problem:
    """STACKED with n blocks without a scene, with an action that looks whether a block is marked."""
    domain = (DOMAINS / "stacked" / "domain.yaml").read_text()
    if look:
        domain = domain.replace("predicates:\n", "predicates:\n  marked: [object]\n") + LOOK
    (folder / "domain.yaml").write_text(domain)
    problem = (DOMAINS / "stacked" / f"n{n}.yaml").read_text().replace("scene: scene.yaml\n", "")
    kept = problem[: problem.index("bodies:")] + problem[problem.index("initial:") :]
    (folder / "problem.yaml").write_text(kept.replace("goal:\n", f"{initial}goal:\n") + goal)
    return kabo.load_problem(folder / "problem.yaml")


@pytest.mark.parametrize("n", [4, 8, 12])
def test_a_look_that_nothing_needs_changes_no_action_of_the_plan(tmp_path: Path, n: int) -> None:
    (tmp_path / "with").mkdir()
    (tmp_path / "without").mkdir()
    plans = [
        kabo.solve(stacked(tmp_path / name, n, look=name == "with"), geometry="none").plan
        for name in ("with", "without")
    ]
    first, second = (
        [(node.action, dict(node.arguments)) for node in plan.nodes.values()] for plan in plans if plan
    )
    assert first == second


def test_a_plan_that_must_look_still_looks(tmp_path: Path) -> None:
    problem = stacked(tmp_path, 3, look=True, goal="  - Kw(marked(o1))\n")
    assert PackedTask(ground(problem)).linear(None, SearchLimits()) is None
    plan = kabo.solve(problem, geometry="none").plan
    assert plan is not None and any(node.action == "look" for node in plan.nodes.values())
    assert kabo.verify(problem, plan, knowledge_only=True).ok


def test_what_is_open_at_the_start_is_branched_on_although_nothing_needs_it(tmp_path: Path) -> None:
    problem = stacked(tmp_path, 3, look=True, initial="  - add(Kw, marked(o1))\n")
    assert PackedTask(ground(problem)).linear(None, SearchLimits()) is None


def test_the_attempt_without_sensing_ends_after_its_expansions(tmp_path: Path) -> None:
    task = PackedTask(ground(stacked(tmp_path, 12, look=True)))
    assert task.linear(None, SearchLimits(expansions=1)) is None
    assert task.linear(None, SearchLimits()) is not None
