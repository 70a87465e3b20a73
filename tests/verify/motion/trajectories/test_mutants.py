"""No trajectory that is wrong by construction is verified, and those from which they were made are."""

from collections import Counter

import pytest

from kabo.scene import load_scene
from kabo.verify import verify_plan
from tests.plan_mutants import MUTATIONS, Case, mutants, trajectories
from tests.support.remembered_distances import remembered_distances
from tests.verify import bench
from tests.verify.smooth import smooth

TOTAL = 240


def kinds() -> list:
    """The kinds of this one file, in its order."""
    return [made for made in vars(trajectories).values() if made in MUTATIONS.values()]


@pytest.fixture(scope="module")
def cases(tmp_path_factory) -> list[Case]:
    """One hand, two hands one after the other, and two at once."""
    found = []
    for number, nodes in enumerate(
        ((bench.take_peg(), bench.hand_over()), (bench.take_peg(), bench.take_socket(), bench.insert_bimanual()))
    ):
        world = bench.load(tmp_path_factory.mktemp(f"bench{number}"))
        found.append(Case(world.problem, smooth(world.plan(*nodes), load_scene(world.problem.scene))))
    return found


def test_the_plans_themselves_are_verified(cases):
    for case in cases:
        report = verify_plan(case.problem, case.plan)
        assert report.ok, str(report)


def test_no_mutant_of_a_trajectory_is_verified(cases):
    made: Counter[str] = Counter()
    with remembered_distances():
        for mutant in mutants(cases, TOTAL, seed=2026, kinds=kinds()):
            made[mutant.kind] += 1
            report = verify_plan(mutant.problem, mutant.plan)
            assert not report.ok, f"overlooked: {mutant.kind} of {mutant.plan.problem}"
    assert sum(made.values()) == TOTAL and len(made) >= 15, made
