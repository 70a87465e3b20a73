"""What an oracle sees collide is refused, and what is refused for a collision is near one; benchmarks/verification.py
does the same with the plans of scenarios."""

from dataclasses import replace
from itertools import islice

import pytest

from kabo.scene import load_scene
from kabo.verify import verify_plan
from tests.support.motion_mutations import Case, mutants
from tests.support.oracles_motions import Judge, replay_of, states_of
from tests.verify import bench as by_hand
from tests.verify.certified import with_certificate

PLANS = {
    "hand over": lambda: [by_hand.take_peg(), by_hand.hand_over()],
    "group": lambda: [by_hand.take_peg(), by_hand.insert(), by_hand.take_socket()],
    "bimanual": lambda: [by_hand.take_peg(), by_hand.take_socket(), by_hand.insert_bimanual()],
}
MUTANTS = 24  # of each plan: every kind of mutation twice, or more often


def test_what_a_certificate_has_to_prove_is_refused_without_a_look_at_the_meshes(counter):
    """All that the meshes refuse, the certificate refuses as well: they are two proofs of the same."""
    case = Case("counter", counter.problem, with_certificate(counter))
    alone = verify_plan(case.problem, case.plan, meshes=False)
    assert alone.ok and alone.certificate is not None and alone.pairs < verify_plan(case.problem, case.plan).pairs
    refused = 0
    for mutant in islice(mutants(case, 1), MUTANTS):
        by_both = verify_plan(mutant.problem, mutant.plan)
        bare = replace(mutant.plan, certificate=None)
        by_meshes, without = (verify_plan(mutant.problem, bare, meshes=meshes) for meshes in (True, False))
        assert without.findings == by_meshes.findings, "without a certificate there are only the meshes"
        assert verify_plan(mutant.problem, mutant.plan, meshes=False).ok is by_both.ok, mutant.kind
        refused += not by_meshes.ok
    assert refused > MUTANTS // 5
    empty = replace(case.plan, certificate=replace(case.plan.certificate, near=None))
    assert verify_plan(case.problem, empty, meshes=False).pairs == verify_plan(case.problem, empty).pairs


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
