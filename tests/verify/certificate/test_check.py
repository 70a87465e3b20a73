"""Certificates: right ones hold, wrong ones are refused in one sentence, and displacements that they allow are safe."""

from dataclasses import replace

import numpy as np
import pytest

from kabo.plan import plan_from_json, plan_to_json
from kabo.verify import verify_plan
from tests.verify import bench as by_hand
from tests.verify.certified import changed, with_certificate
from tests.verify.test_several_robots import coming_near, early, meeting_of


@pytest.fixture(scope="module")
def plan(counter):
    return with_certificate(counter)


def only_finding(counter, plan):
    """What the one finding says of the certificate."""
    report = verify_plan(counter.problem, plan)
    assert len(report.findings) == 1, [str(finding) for finding in report.findings]
    assert report.certificate is not None and not report.certificate.proven
    text = str(report.findings[0])
    assert "the certificate does not hold" in text
    return text


def first_proven(plan):
    """Place and proof of the first stretch beside the plate, whose box the arm's boxes meet on the way."""
    at = next(i for i, s in enumerate(plan.certificate.proofs) if any(p.second == "plate" for p in s.pairs))
    return at, plan.certificate.proofs[at]


def with_pair(plan, change):
    """The plan with the first proof beside the plate changed for which `change` has another."""
    proofs = list(plan.certificate.proofs)
    for i, stretch in enumerate(proofs):
        for k, pair in enumerate(stretch.pairs):
            other = change(pair) if pair.second == "plate" else None
            if other is not None:
                proofs[i] = replace(stretch, pairs=(*stretch.pairs[:k], other, *stretch.pairs[k + 1 :]))
                return changed(plan, proofs=tuple(proofs))
    raise AssertionError("no pair to change")


def test_the_certificate_of_a_right_plan_holds(counter, plan):
    report = verify_plan(counter.problem, plan)
    assert report.ok, str(report)
    told = report.certificate
    assert told.proven and told.stretches == sum(len(node.motion) for node in plan.nodes.values())
    assert told.axes > 0 and told.meshes > 3
    assert "certificate: holds" in str(report) and "may be displaced" in str(report)


def test_a_plan_without_a_certificate_is_checked_against_the_meshes_alone(counter):
    report = verify_plan(counter.problem, counter.plan)
    assert report.ok and report.certificate is None
    assert "certificate: none" in str(report) and report.to_dict()["certificate"] is None


def test_a_certificate_of_distances_alone_is_as_none(counter, plan):
    report = verify_plan(counter.problem, changed(plan, near=None, proofs=(), bodies={}))
    assert report.ok and report.certificate is None


def test_the_file_keeps_every_byte_of_it(plan):
    content = plan_to_json(plan)
    assert plan_from_json(content) == plan and plan_to_json(plan_from_json(content)) == content


def test_the_same_plan_has_the_same_certificate(counter, plan):
    assert plan_to_json(with_certificate(counter)) == plan_to_json(plan)


def test_a_stretch_without_proofs_is_missed(counter, plan):
    assert "says nothing of" in only_finding(counter, changed(plan, proofs=plan.certificate.proofs[1:]))


def test_a_stretch_that_is_not_there_is_noticed(counter, plan):
    foreign = replace(plan.certificate.proofs[0], node="n99")
    assert "n99" in only_finding(counter, changed(plan, proofs=(*plan.certificate.proofs, foreign)))


def test_a_pair_whose_boxes_meet_needs_a_proof(counter, plan):
    at, stretch = first_proven(plan)
    proofs = list(plan.certificate.proofs)
    proofs[at] = replace(stretch, pairs=())
    assert "no proof is given" in only_finding(counter, changed(plan, proofs=tuple(proofs)))


def test_a_contact_that_is_not_permitted_needs_a_proof(counter, plan):
    """The fingers close on a cup whose contact the segment no longer permits."""
    name, node = next((n, c) for n, c in plan.nodes.items() if any(s.attach for s in c.motion))
    motion = tuple(replace(s, allowed_contacts=()) if s.attach else s for s in node.motion)
    report = verify_plan(counter.problem, replace(plan, nodes={**plan.nodes, name: replace(node, motion=motion)}))
    assert any("no proof is given" in str(finding) for finding in report.findings)
    assert any("collide" in str(finding) for finding in report.findings), "the second way agrees"


def test_a_contact_that_a_plan_permits_itself_but_may_not_needs_a_proof(counter, plan):
    """Arms permit contact with the plate, and the certificate leaves out what then needs no proof."""
    at, stretch = first_proven(plan)
    node, proofs = plan.nodes[stretch.node], list(plan.certificate.proofs)
    proofs[at] = replace(stretch, pairs=tuple(p for p in stretch.pairs if p.second != "plate"))
    more = tuple((p.first, p.second) for p in stretch.pairs if p.second == "plate")
    motion = tuple(
        replace(s, allowed_contacts=(*s.allowed_contacts, *more)) if i in stretch.segments else s
        for i, s in enumerate(node.motion)
    )
    spoilt = replace(plan, nodes={**plan.nodes, stretch.node: replace(node, motion=motion)})
    findings = [str(each) for each in verify_plan(counter.problem, changed(spoilt, proofs=tuple(proofs))).findings]
    assert any("does not say what grants it" in each for each in findings)
    assert any("no proof is given" in each for each in findings), "the second way agrees"


def test_fingers_may_not_be_said_to_touch_what_they_do_not_hold_yet(counter):
    """Contact is permitted on the way there, too, where there is none."""
    motion = counter.plan.nodes[counter.node("take")].motion
    spoilt = counter.with_segment("take", 1, allowed_contacts=motion[2].allowed_contacts, grants=motion[2].grants)
    findings = [str(each) for each in verify_plan(counter.problem, spoilt).findings]
    assert any("but arm neither holds nor takes" in each for each in findings), findings


def test_its_epsilon_is_that_of_the_plan_and_where_that_is_not_the_scene_s_a_note_says_so(counter, plan):
    assert "it tells an epsilon of 0.005 m, the plan was made with 0.01 m" in only_finding(
        counter, changed(plan, epsilon=0.005)
    )
    other = replace(changed(plan, epsilon=0.005), options={**plan.options, "epsilon": 0.005})
    told = verify_plan(counter.problem, other)
    assert told.ok and "the plan was made with an epsilon of 0.005 m, the files say 0.01 m" in told.notes


def test_parts_that_are_smaller_than_their_mesh_are_refused(counter, plan):
    digest = min(plan.certificate.bodies)
    parts = plan.certificate.bodies[digest]
    smaller = replace(parts, vertices=(np.frombuffer(parts.vertices) * 0.999).tobytes())
    bodies = {**plan.certificate.bodies, digest: smaller}
    assert "do not enclose it" in only_finding(counter, changed(plan, bodies=bodies))


@pytest.mark.parametrize("wrong", [np.nan, np.inf, 1e300])
def test_vertices_that_are_no_places_are_refused(counter, plan, wrong):
    digest = min(plan.certificate.bodies)
    parts = plan.certificate.bodies[digest]
    numbers = np.frombuffer(parts.vertices).copy()
    numbers[4] = wrong
    bodies = {**plan.certificate.bodies, digest: replace(parts, vertices=numbers.tobytes())}
    only_finding(counter, changed(plan, bodies=bodies))


def test_a_body_without_parts_is_missed(counter, plan):
    bodies = dict(plan.certificate.bodies)
    bodies.popitem()
    assert "has no parts for" in only_finding(counter, changed(plan, bodies=bodies))


def test_a_walk_that_ends_early_or_goes_on_is_refused(counter, plan):
    early = with_pair(
        plan,
        lambda p: replace(p, walk=p.walk[:-1]) if p.walk == "tbb" else None,
    )
    assert "ends before" in only_finding(counter, early)
    longer = with_pair(plan, lambda p: replace(p, walk=p.walk + "b"))
    assert "goes on" in only_finding(counter, longer)


@pytest.mark.parametrize("axis", [(0, 0, 0), (-1, 0, 0), (0, 1, 0), (32767, 32767, 32767)])
def test_an_axis_that_does_not_separate_is_refused(counter, plan, axis):
    def turned(pair):
        own = np.frombuffer(pair.axes, "<i2")
        other = -own[:3] if axis == (-1, 0, 0) else np.array(axis, "<i2")
        return replace(pair, walk="a", axes=other.astype("<i2").tobytes()) if pair.walk == "a" else None

    plan = with_pair(plan, turned)
    report = verify_plan(counter.problem, plan)
    if report.ok:  # another axis may separate, too; then it is a proof
        assert axis not in ((0, 0, 0), (-1, 0, 0))
    else:
        only_finding(counter, plan)


def test_a_walk_that_halves_for_ever_is_refused(counter, plan):
    only_finding(counter, with_pair(plan, lambda pair: replace(pair, walk="t" * 100_000, axes=b"")))
    only_finding(counter, with_pair(plan, lambda pair: replace(pair, walk="f" * 100, axes=b"")))


def test_a_clearance_that_is_told_too_large_is_refused(counter, plan):
    told = list(plan.certificate.segments)
    i = min((i for i, entry in enumerate(told) if entry.clearance is not None), key=lambda i: told[i].clearance)
    told[i] = replace(told[i], clearance=told[i].clearance + 1e-4)
    assert "tells a clearance of" in only_finding(counter, changed(plan, segments=tuple(told)))
    told[i] = replace(told[i], clearance=1.5 * plan.certificate.near, between=None)
    assert "tells a clearance of" in only_finding(counter, changed(plan, segments=tuple(told)))


def test_the_certificate_of_another_scene_is_refused(counter, plan):
    """A box of the same name, but another mesh."""
    digest = sorted(plan.certificate.bodies)
    swapped = dict(zip(digest, [plan.certificate.bodies[d] for d in digest[1:] + digest[:1]], strict=True))
    only_finding(counter, changed(plan, bodies=swapped))


def test_clearances_are_told_for_every_object_and_branch(counter, plan):
    told = verify_plan(counter.problem, plan).certificate.to_dict()
    assert {each["object"] for each in told["clearance"]} == {"mug"}
    branches = told["branches"]
    assert len(branches) > 1 and all(set(each["distances"]) == {"mug"} for each in branches)
    distances = [each["distances"]["mug"] for each in branches if each["distances"]["mug"] is not None]
    assert min(distances) == told["clearance"][0]["distance"]


def test_what_no_reader_lets_through_is_refused_all_the_same(counter, plan):
    """Plans may be built without a file."""
    for walk, axes in (("a", b""), ("x", b""), ("", b""), ("e", b"123")):
        only_finding(counter, with_pair(plan, lambda pair, w=walk, a=axes: replace(pair, walk=w, axes=a)))


# ---------------------------------------------------------------------------------------- motions that begin early
@pytest.fixture(scope="module")
def overlapping(tmp_path_factory):
    """A bench where right comes near while left still passes, and the plan with its certificate."""
    bench = by_hand.load(tmp_path_factory.mktemp("early"))
    nodes = by_hand.take_peg(), meeting_of("left"), early(coming_near(0.1), 1.5), by_hand.hand_over()
    return bench, with_certificate(bench, bench.plan(*nodes))


def of_meetings(plan):
    """The places of proofs of motions that are under way at any times, with axes."""
    return [i for i, p in enumerate(plan.certificate.proofs) if p.before and any(pair.axes for pair in p.pairs)]


def test_proofs_of_motions_that_begin_early_hold_and_are_kept(overlapping):
    bench, plan = overlapping
    report = verify_plan(bench.problem, plan, paranoid=True)
    assert report.ok and report.certificate.proven and of_meetings(plan), str(report)
    assert plan_from_json(plan_to_json(plan)) == plan


def test_proofs_of_motions_that_begin_early_are_missed_and_judged(overlapping):
    bench, plan = overlapping
    proofs = list(plan.certificate.proofs)
    at = of_meetings(plan)[0]
    found = proofs[at]
    beside = f"{found.node}, segment {found.segments[0]}, beside {found.before[0]} of the node before"
    without = [p for i, p in enumerate(proofs) if i != at]
    assert f"it says nothing of {beside}" in only_finding(bench, changed(plan, proofs=tuple(without)))
    twice = (*proofs, found)
    assert f"it proves {beside} twice" in only_finding(bench, changed(plan, proofs=twice))
    many = replace(found, cut=100_000)
    assert "into too many parts" in only_finding(bench, changed(plan, proofs=(*without, many)))


def test_halving_time_inside_a_piece_is_no_proof_for_any_two_moments(overlapping):
    """At the same moments the two are apart, which says nothing of one that is late."""
    bench, plan = overlapping
    proofs = list(plan.certificate.proofs)
    at = of_meetings(plan)[0]
    deep = "t" * 24 + "b" * 25
    pairs = tuple(replace(pair, walk=deep, axes=b"") for pair in proofs[at].pairs)
    text = only_finding(
        bench, changed(plan, proofs=(*proofs[:at], replace(proofs[at], pairs=pairs), *proofs[at + 1 :]))
    )
    assert "a stretch is halved that cannot be" in text
