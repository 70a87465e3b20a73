"""Goals that can never hold, and the sentences that say why."""

from pathlib import Path

from kabo.language import load_problem
from kabo.planner.proofs.unreachable import unreachable_because

DOMAIN = """domain: cups
types: {cup: }
predicates: {washed: [cup]}
actions:
  wash:
    parameters: {c: cup}
    effects: ["add(Kf, washed(c))"]
"""
PROBLEM = """problem: both
domain: domain.yaml
objects: {cup: [a]}
goal: [K(washed(a)), K(not washed(a))]
"""


def test_a_goal_that_asks_for_opposites_is_said_to_contradict_itself(tmp_path: Path) -> None:
    (tmp_path / "domain.yaml").write_text(DOMAIN)
    (tmp_path / "problem.yaml").write_text(PROBLEM)
    (found,) = unreachable_because(load_problem(tmp_path / "problem.yaml"))
    assert found.text == "K(not washed(a))"
    assert found.why[0] == "The goal contradicts itself: it asks for K(washed(a)) as well."
