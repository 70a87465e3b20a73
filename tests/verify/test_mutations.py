"""What an oracle sees collide is refused, and what is refused for a collision is near one; benchmarks/verification.py
does the same with the plans of scenarios."""

from itertools import islice

import pytest

from kabo.scene import load_scene
from kabo.verify import verify_plan
from tests.support.motion_mutations import Case, mutants
from tests.support.oracles_motions import Judge, replay_of, states_of
from tests.verify import bench as by_hand

PLANS = {
    "hand over": lambda: [by_hand.take_peg(), by_hand.hand_over()],
    "group": lambda: [by_hand.take_peg(), by_hand.insert(), by_hand.take_socket()],
    "bimanual": lambda: [by_hand.take_peg(), by_hand.take_socket(), by_hand.insert_bimanual()],
}
MUTANTS = 24  # of each plan: every kind of mutation twice, or more often


@pytest.mark.parametrize("name", PLANS)
def test_every_mutant_that_collides_is_refused_and_none_that_is_clearly_free_for_a_collision(name, tmp_path):
    bench = by_hand.load(tmp_path)
    case = Case(name, bench.problem, bench.plan(*PLANS[name]()))
    assert verify_plan(case.problem, case.plan).ok
    colliding = 0
    for mutant in islice(mutants(case, 1), MUTANTS):
        scene = load_scene(mutant.problem.scene)
        judge, states = Judge(scene), states_of(mutant.plan, scene)
        replays = [
            (node, state, replay_of(scene, state, mutant.plan.nodes[node], case.plan.nodes[node]))
            for node in mutant.nodes
            for state in states[node]
        ]
        hit = next((hit for node, _, replay in replays for hit in judge.hits(node, replay)), None)
        report = verify_plan(mutant.problem, mutant.plan)
        colliding += hit is not None
        assert hit is None or not report.ok, f"overlooked: {mutant.kind}, {hit}"
        for finding in report.findings:
            if " collide" in finding.message and finding.node in mutant.nodes:
                again = [replay_of(scene, s, mutant.plan.nodes[n]) for n, s, _ in replays if n == finding.node]
                nearest = min(judge.least(finding.bodies, replay) for replay in again)
                assert nearest <= 2 * scene.epsilon, f"{mutant.kind}: {finding} is clearly free, {nearest:.3g} m"
    assert colliding > MUTANTS // 5, "the mutations collide too seldom to be a test"
