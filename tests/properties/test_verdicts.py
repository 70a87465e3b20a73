""" "Proven: there is no plan" is true: random contingent problems against brute force on sets of worlds.

`when` on unknown conditions, `or`, `oneof`, clauses and sensing as PDDL; `when`, Kx, Kor, sensing and a term with values in
kabo's own language. The oracle shares no code with kabo and knows nothing of knowledge.
"""

from collections import Counter
from functools import cache

import pytest

from kabo.errors import InputError
from kabo.knowledge import GroundedTask, ground
from kabo.language import load_problem
from kabo.planner.search.algorithms import ALGORITHMS
from kabo.planner.search.contingent import find_skeleton
from kabo.planner.search.nodes import SearchSpace
from kabo.planner.search.skeleton import Exhausted, SearchLimits
from kabo.planner.solve import solve
from kabo.verify import verify_plan
from tests.conftest import PROPERTY_SCALE
from tests.support import oracles_planning as oracles
from tests.support.random_beliefs import own_files, pddl, random_small

#: 2,000 problems for each search in the whole run, 200 in the usual one.
COUNT = max(20, round(2000 * PROPERTY_SCALE))
#: Of the problems that truly have no plan at least this share is proved: 45 % of the PDDL ones are, 55 % of the others.
PROVED = 0.35
#: How often every state of knowledge may be expanded at most: 9.5 times was measured (iterative deepening).
TIMES = 25


@pytest.fixture(scope="module")
def load(tmp_path_factory):
    """Loads the problem of a seed, as PDDL or in kabo's own language; each once."""
    folder = tmp_path_factory.mktemp("verdicts")

    @cache
    def loaded(seed: int, own: bool):
        small = random_small(seed, own=own)
        if own:
            domain, problem = own_files(small)
            (folder / "domain.yaml").write_text(domain)
            (folder / "problem.yaml").write_text(problem)
            return load_problem(folder / "problem.yaml")
        (folder / "problem.pddl").write_text(pddl(small))
        return load_problem(folder / "problem.pddl")

    return loaded


@cache
def truth(seed: int, own: bool) -> str:
    """What brute force says of a problem."""
    small = random_small(seed, own=own)
    if not oracles.start(small):
        return "contradiction"
    return {True: "solvable", False: "unsolvable", None: "too large"}[oracles.solvable(small)]


def verdict(problem, search: str) -> str:
    """The status of a search, or which part of the budget ended it; every plan is verified."""
    try:
        result = solve(problem, search=search, max_expansions=50_000)
    except InputError as error:
        assert "contradicts" in str(error), str(error)
        return "contradiction"
    if result.plan is not None:
        report = verify_plan(problem, result.plan, knowledge_only=True)
        assert report.ok, str(report)
    return result.status if result.reason is None else result.reason.budget or result.status


@pytest.mark.parametrize("own", [False, True], ids=["pddl", "own"])
@pytest.mark.parametrize("search", sorted(ALGORITHMS))
def test_what_is_proved_to_have_no_plan_has_none(load, search, own):
    seen, wrong = Counter(), {}
    for seed in range(COUNT):
        said, true = verdict(load(seed, own), search), truth(seed, own)
        seen[true, said] += 1
        if (said == "contradiction") != (true == "contradiction"):
            wrong[seed] = f"{true}, but {said}"
        if (true, said) in (("solvable", "no_plan"), ("unsolvable", "solved")) or said in ("expansions", "time"):
            wrong[seed] = f"{true}, but {said}"
    assert wrong == {}
    proved, unproved = seen["unsolvable", "no_plan"], seen["unsolvable", "reasoning"]
    assert proved > PROVED * (proved + unproved), "hardly anything is proved any more"
    assert seen["solvable", "solved"] > COUNT // 5


@pytest.mark.parametrize("search", sorted(ALGORITHMS))
def test_a_search_on_finitely_many_states_ends(load, search):
    for seed in range(COUNT):
        if truth(seed, False) == "contradiction":
            continue
        task = ground(load(seed, False))
        found = find_skeleton(task, search=search, limits=SearchLimits(50_000))
        assert not isinstance(found, Exhausted), seed
        if found.statistics.expanded > TIMES:
            assert found.statistics.expanded <= TIMES * states_of_knowledge(task), seed


def states_of_knowledge(task: GroundedTask) -> int:
    """How many states of knowledge can be reached, those counted once that say the same."""
    space = SearchSpace(task, None, task.may_wait)
    seen, waiting = {space.key(space.start)}, [space.start]
    while waiting:
        node = waiting.pop()
        branchings = task.open_branchings(node[0])
        after = [child for branching in branchings for _, child in space.outcomes(node, branching)]
        if not branchings or task.may_wait:
            after += [child for _, _, child in space.moves(node)]
        for child in after:
            if space.key(child) not in seen:
                seen.add(space.key(child))
                waiting.append(child)
    return len(seen)
