"""Random problems with everything that knowledge knows, against an exhaustive planner on the verifier's own states.

A plan is found if and only if there is one, every plan is verified, and found again exactly.
"""

from collections import Counter

import pytest

from kabo.errors import InputError
from kabo.language import load_problem
from kabo.plan import plan_to_json
from kabo.planner.solve import solve
from kabo.verify import verify_plan
from tests.conftest import PROPERTY_SCALE
from tests.support.oracles_worlds import verdict
from tests.support.random_knowledge import random_problem

#: 10,000 problems in the whole run, 150 in the usual one.
COUNT = 10_000 if PROPERTY_SCALE >= 1.0 else max(20, round(1500 * PROPERTY_SCALE))
SEARCHES = ("best", "greedy", "breadth-first")
EXPANSIONS = 20_000

#: Seeds on which planner and judge are known to disagree, each with a reason. Must be empty.
DISAGREEMENTS: dict[int, str] = {}


@pytest.fixture(scope="module")
def problems(tmp_path_factory):
    """Every problem by its seed, with what the exhaustive planner says of it."""
    folder, found = tmp_path_factory.mktemp("problems"), {}
    for seed in range(COUNT):
        domain, text = random_problem(seed)
        (folder / "domain.yaml").write_text(domain)
        (folder / "problem.yaml").write_text(text)
        problem = load_problem(folder / "problem.yaml")
        found[seed] = problem, verdict(problem)
    return found


def answer(problem, search):
    """The status of a search and its plan, or what was wrong with the problem."""
    try:
        result = solve(problem, search=search, max_expansions=EXPANSIONS)
    except InputError as error:
        assert "contradicts" in str(error) or "settle" in str(error) or "rounds" in str(error), str(error)
        return "contradiction", None
    if result.reason is not None and result.reason.budget == "reasoning":
        return "reasoning", None  # everything was tried, but that is no proof
    return result.status, result.plan


@pytest.mark.parametrize("search", SEARCHES)
def test_a_plan_is_found_if_and_only_if_there_is_one(problems, search):
    wrong, seen = {}, Counter()
    for seed, (problem, truth) in problems.items():
        status, plan = answer(problem, search)
        seen[status] += 1
        mistaken = [("solvable", "no_plan"), ("solvable", "reasoning"), ("unsolvable", "solved")]
        if (truth, status) in mistaken or (status == "contradiction" and truth in ("solvable", "unsolvable")):
            wrong[seed] = f"{truth}, but {status}"
        if plan is not None and truth != "contradiction":  # what inference has not noticed, no plan can mend
            report = verify_plan(problem, plan, knowledge_only=True)
            if not report.ok:
                wrong[seed] = str(report)
    assert wrong.keys() == DISAGREEMENTS.keys(), wrong
    assert min(seen["solved"], seen["no_plan"]) > COUNT // 8


def test_there_is_no_known_disagreement():
    assert not DISAGREEMENTS


@pytest.mark.parametrize("search", SEARCHES)
def test_the_same_plan_is_found_again(problems, search):
    for problem, _ in list(problems.values())[: COUNT // 5]:
        first, second = (answer(problem, search)[1] for _ in range(2))
        assert (first is None) == (second is None)
        if first is not None:
            assert plan_to_json(first) == plan_to_json(second)
