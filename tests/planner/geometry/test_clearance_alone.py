"""Refused calls that the distance to be kept alone decides, told with the pair and an epsilon that may do."""

import re
from pathlib import Path

import pytest

from kabo import load_problem, solve

GEARBOX = Path(__file__).resolve().parents[3] / "domains/assembly/gearbox.yaml"
KEPT = 0.005  # m, which its epsilon of 20 mm cannot prove of a finger and a part that are 9.3 mm apart


@pytest.mark.slow
def test_a_run_whose_time_is_up_names_the_pair_and_an_epsilon_that_gives_a_plan():
    problem = load_problem(GEARBOX)
    late = solve(problem, clearance=KEPT, timeout=20.0)
    assert late.plan is None and late.reason is not None and late.reason.budget == "time"
    first = late.reason.details[0]
    assert first.startswith("pick(robot_2, o2): ") and "robot_2.left_finger and o2 are 9.3 mm apart" in first
    found = re.search(r"that 5 mm are kept \(try --epsilon ([\d.]+)\)", first)
    assert found is not None, first
    assert 0.001 < float(found[1]) < 0.00935 - KEPT  # which is told to a tenth of a millimetre
    assert solve(problem, clearance=KEPT, epsilon=float(found[1])).status == "solved"
