"""Certificates of plans in which robots move together, hands meet and parts are joined; and what cannot be proven."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kabo import load_problem, solve
from kabo.geometry.collision.separation_proofs import Course
from kabo.geometry_server import GeometryServer
from kabo.plan import Certificate, Plan, plan_from_json, plan_to_json
from kabo.planner.certify.certifying import certified, certify
from kabo.planner.certify.motion_stretches import at_time, stretches
from kabo.planner.certify.overlapping_pairs import every_pair_of_pieces
from kabo.scene import load_scene
from kabo.verify import verify_plan
from tests.verify import bench as by_hand
from tests.verify.bench import Bench
from tests.verify.certified import small_robot, with_certificate
from tests.verify.test_several_robots import coming_near, early, meeting, meeting_of, take_both

DOMAINS = Path(__file__).resolve().parents[3] / "domains"


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Bench:
    return by_hand.load(tmp_path_factory.mktemp("bench"))


def tried(bench, plan: Plan):
    scene = load_scene(bench.problem.scene)
    return certify(plan, GeometryServer(scene, scene.epsilon, 0).surroundings)


RIGHT = {
    "hand over": lambda: [by_hand.take_peg(), by_hand.hand_over()],
    "insert": lambda: [by_hand.take_peg(), by_hand.insert()],
    "group by its root": lambda: [by_hand.take_peg(), by_hand.insert(), by_hand.take_socket()],
    "bimanual": lambda: [by_hand.take_peg(), by_hand.take_socket(), by_hand.insert_bimanual()],
    "group by its member": lambda: [by_hand.take_peg(), by_hand.insert(), take_both()],
}


@pytest.mark.parametrize("nodes", RIGHT.values(), ids=RIGHT)
def test_two_hands_groups_and_mates_are_proven(bench, nodes):
    plan = with_certificate(bench, bench.plan(*nodes()))
    report = verify_plan(bench.problem, plan)
    assert report.ok, str(report)
    assert report.certificate is not None and report.certificate.proven


def test_every_window_of_motions_that_overlap_is_proven(bench):
    plan = with_certificate(
        bench, bench.plan(by_hand.take_peg(), by_hand.take_socket(), by_hand.insert_bimanual())
    )
    together = [proof for proof in plan.certificate.proofs if len(proof.segments) > 1]
    assert together and any(
        pair.first.split(".")[0] != pair.second.split(".")[0] for p in together for pair in p.pairs
    )


@pytest.mark.parametrize("delay", [0.1, 1.0, 2.0, 4.0])
def test_arms_that_move_at_once_are_proven_or_said_to_meet(bench, delay):
    """Both ways agree: what is proven is verified, what is not comes near."""
    plan = bench.plan(by_hand.take_peg(), meeting(delay))
    made = tried(bench, plan)
    findings = [f for f in verify_plan(bench.problem, plan).findings if "collide" in str(f)]
    assert isinstance(made, Certificate) == (not findings)
    if findings:
        assert {made[0].node} == {findings[0].node} and "not proven apart" in str(made[0])


def test_a_plan_that_collides_keeps_no_certificate_and_says_why(bench):
    scene = load_scene(bench.problem.scene)
    plan = bench.plan(by_hand.take_peg(), by_hand.insert(allowed_contacts=by_hand.fingers("left", "peg")))
    told, figures = certified(plan, GeometryServer(scene, scene.epsilon, 0).surroundings)
    gaps = figures["certificate_gaps"]
    assert told == replace(plan, certificate_gaps=tuple(gaps)) and any("peg and socket" in gap for gap in gaps)
    assert plan_from_json(plan_to_json(told)) == told
    assert f"certificate: none could be made: {gaps[0]}" in str(verify_plan(bench.problem, told))


@pytest.mark.slow
def test_fingers_round_what_they_let_go_of_are_proven_apart_though_a_plan_permits_contact():
    """The boxes of both meet until the hand is up and away, so that whoever checks wants a proof."""
    problem = load_problem(DOMAINS / "circular_rearrange" / "n2.yaml")
    plan, nodes = solve(problem, seed=0, certificate=False).plan, {}
    for name, node in plan.nodes.items():
        fingers = sorted({pair for s in node.motion for pair in s.allowed_contacts if any("." in t for t in pair)})
        motion = tuple(
            replace(s, allowed_contacts=tuple(sorted({*s.allowed_contacts, *fingers}))) for s in node.motion
        )
        nodes[name] = replace(node, motion=motion)
    scene, plan = load_scene(problem.scene), replace(plan, nodes=nodes)
    made = certify(plan, GeometryServer(scene, scene.epsilon, 0).surroundings)
    assert isinstance(made, Certificate), [str(gap) for gap in made]
    report = verify_plan(problem, replace(plan, certificate=made))
    assert report.certificate is not None and report.certificate.proven
    assert all("does not say what grants it" in each.message for each in report.findings), str(report)


def test_stretches_end_wherever_a_segment_begins_or_ends(bench):
    motion, robots = meeting(0.5).motion, dict(load_scene(bench.problem.scene).robots)
    start = {name: np.array([*by_hand.HOME[name], 0.0]) for name in robots}
    found = list(stretches(motion, robots, start))
    assert [stretch.segments for stretch in found] == [(0,), (0, 1), (1,)] or found[-1].segments == (0,)
    assert [stretch.ending for stretch in found][0] == ()
    for stretch in found:
        assert len({len(rows) for rows in stretch.waypoints.values()}) == 1, "robots share their way points' times"
    for name, segment in zip(("left", "right"), motion, strict=True):
        rows = np.vstack([stretch.waypoints[name] for stretch in found if name in stretch.waypoints])
        assert rows[0][:4] == pytest.approx(segment.waypoints[0]) and rows[-1][:4] == pytest.approx(
            segment.waypoints[-1]
        )
        assert start[name] == pytest.approx(rows[-1]), "where it is afterwards"


def test_between_way_points_a_configuration_is_proportional_to_time():
    segment = by_hand.take_peg().motion[0]
    middle = 0.5 * (segment.times[0] + segment.times[1])
    assert at_time(segment, middle) == pytest.approx(np.mean(segment.waypoints[:2], axis=0))
    assert at_time(segment, segment.times[-1]) == pytest.approx(segment.waypoints[-1])


# ---------------------------------------------------------------------------------------- motions that begin early
@pytest.mark.parametrize("y", [0.0, 0.06, 0.088, 0.092, -0.1, 0.15])
@pytest.mark.parametrize("seconds", [0.1, 1.0, 1.1, 1.5])
def test_a_motion_that_begins_early_is_proven_or_may_meet_the_one_before(bench, y, seconds):
    """Both ways of judging say how near right may come to where left passes, and from when on."""
    nodes = by_hand.take_peg(), meeting_of("left"), early(coming_near(y), seconds), by_hand.hand_over()
    plan = bench.plan(*nodes)
    made, report = tried(bench, plan), verify_plan(bench.problem, plan)
    assert isinstance(made, Certificate) == report.ok, f"{made}\n{report}"
    if isinstance(made, Certificate):
        told = verify_plan(bench.problem, replace(plan, certificate=made))
        assert told.ok and told.certificate.proven, str(told)
        own = [proof for proof in made.proofs if proof.before]
        assert {proof.node for proof in own} == {"n2"}, "with or without pairs that come near"


def test_every_couple_of_pieces_is_passed():
    tree = small_robot()[0].tree
    first, second = (
        Course(tree, np.cumsum(np.full((rows, tree.size), 0.1), axis=0), [], np.empty((0, 3), np.int64))
        for rows in (4, 3)
    )
    for cut in (1, 2, 3):
        path = every_pair_of_pieces(first, second, np.empty((0, 3), np.int64), cut)
        pieces = {
            (round(min(a[0], b[0]) * 10 * cut), round(min(a[-1], b[-1]) * 10 * cut))
            for a, b in zip(path.waypoints, path.waypoints[1:], strict=False)
            if a[0] != b[0] and a[-1] != b[-1]
        }
        wanted = {(i + cut, k + cut) for i in range(3 * cut) for k in range(2 * cut)}
        assert pieces == wanted and path.at_any_times
