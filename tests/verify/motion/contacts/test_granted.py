"""Contact is granted where a stroke begins or ends, nowhere else; what the plan says grants it is asked of the scene."""

from dataclasses import replace

import pytest

from kabo.plan import Grant
from kabo.verify import verify_plan
from tests.verify import bench as by_hand
from tests.verify import counter as with_mug
from tests.verify.counter import HIGH, LOW, at
from tests.verify.test_several_robots import report, with_segment
from tests.verify.test_verification import found

LIFT, LOWER = 3, 1  # numbers of these segments in `take` and `put`


def through(segment, *points, seconds=4.0):
    """The segment through other points of the arm, slowly."""
    first, last = segment.times[0], segment.times[-1]
    times = tuple(round(first + (last - first) * k / (len(points) - 1), 6) for k in range(len(points)))
    assert seconds > 0.0
    return replace(segment, waypoints=tuple(tuple(map(float, p)) for p in points), times=times)


def with_path(counter, action, index, *points):
    """The report of the plan with one segment through other points, at any speed."""
    segment = counter.plan.nodes[counter.node(action)].motion[index]
    changed = through(segment, *points)
    return verify_plan(
        counter.problem,
        counter.with_segment(action, index, waypoints=changed.waypoints, times=changed.times),
    )


@pytest.mark.parametrize("deep", [1e-4, 0.0015, 0.019])
def test_what_is_pushed_into_its_support_and_dragged_is_caught(counter, deep):
    """The plan on which the verifier was wrong: 1.5 mm into the table, and 20 cm along it."""
    low = LOW - deep
    told = with_path(counter, "take", LIFT, at(-0.3, LOW), at(-0.3, low), at(-0.1, low), at(-0.3, HIGH))
    found(
        told,
        "lets mug and table touch by the lift of the grasp top, but the motion that lifts mug",
        counter.node("take"),
    )
    found(told, "mug and table collide", counter.node("take"))


def test_what_slides_on_its_support_is_caught(counter):
    told = with_path(counter, "take", LIFT, at(-0.3, LOW), at(-0.28, LOW), at(-0.3, HIGH))
    found(told, "the motion that lifts mug leaves its line by 20 mm after 0 mm", counter.node("take"))


def test_what_comes_down_too_deep_is_caught(counter):
    told = with_path(counter, "put", LOWER, at(0.3, HIGH), at(0.3, LOW - 2e-4), at(0.3, LOW))
    found(told, "the motion that puts mug down does not lead away all the time", counter.node("put"))


@pytest.mark.parametrize(("deep", "right"), [(5e-6, True), (5e-5, True), (5e-4, False)])
def test_what_is_put_down_goes_no_deeper_than_it_may_stand(counter, deep, right):
    low, high = at(0.3, LOW - deep), at(0.3, HIGH)
    node = counter.node("put")
    motion = list(counter.plan.nodes[node].motion)
    motion[LOWER] = through(motion[LOWER], high, low)
    motion[LOWER + 2] = replace(motion[LOWER + 2], waypoints=(low, *motion[LOWER + 2].waypoints[1:]))
    after = counter.plan.nodes[node].after
    served = replace(with_mug.SERVED, position=(0.3, 0.0, round(0.05 - deep, 9)))
    told = verify_plan(
        counter.problem,
        counter.with_node("put", motion=tuple(motion), after=replace(after, objects={"mug": served})),
    )
    wrong = [f for f in told.findings if "where mug stands the two overlap" in f.message]
    assert not right or told.ok, str(told)
    assert right or wrong, str(told)


@pytest.mark.parametrize("grant", [
    Grant("support", ("mug", "plate"), "top"),
    Grant("support", ("mug", "table"), "side"),
    Grant("support", ("mug", "table"), None),
    Grant("mate", ("mug", "table"), "top"),
    Grant("grasp", ("arm.palm", "mug"), "top"),
    Grant("support", ("table", "mug"), "top"),
    Grant("support", ("nobody", "nothing"), "top"),
    Grant("grasp", ("arm.left", "nothing"), "top"),
])  # fmt: skip
def test_a_statement_that_the_scene_does_not_bear_out_is_caught(counter, grant):
    segment = counter.plan.nodes[counter.node("take")].motion[LIFT]
    others = tuple(g for g in segment.grants if g.kind == "grasp")
    plan = counter.with_segment(
        "take",
        LIFT,
        allowed_contacts=(*with_mug.FINGERS, *with_mug.MUG_TABLE, grant.bodies),
        grants=(*others, grant),
    )
    found(
        verify_plan(counter.problem, plan),
        r"lets \w.* touch by (the mate|the grasp|the lift of|a grasp)",
        counter.node("take"),
    )


def test_a_retreat_an_approach_and_a_lift_have_the_length_of_their_family(counter):
    short = at(-0.3, LOW + 0.02)
    node = counter.node("take")
    motion = list(counter.plan.nodes[node].motion)
    motion[0], motion[1] = (
        through(motion[0], *motion[0].waypoints, short),
        through(motion[1], short, at(-0.3, LOW)),
    )
    told = verify_plan(counter.problem, counter.with_node("take", motion=tuple(motion)))
    found(told, "arm approaches mug by no stroke along tool.approach: it is 20 mm long, not 25 to 101 mm", node)


def test_a_hand_that_closes_again_beside_what_it_has_let_go_of_is_caught(counter):
    """Fingers may touch what was let go until the arm moves, not whenever the plan says so."""
    node = counter.node("put")
    motion, after = counter.plan.nodes[node].motion, counter.plan.nodes[node].after
    beside = (0.3, 0.01, LOW, 0.0)
    start = motion[-1].times[-1]
    opening = motion[LOWER + 1]
    back = with_mug.stretch(
        start, [motion[-1].waypoints[-1], (0.3, 0.01, with_mug.OVER, 0.0), beside], "x", "place"
    )
    shut = with_mug.stretch(back.times[-1], [(0.045,), (0.02,), (0.045,)], "x", "place")
    shut = replace(shut, allowed_contacts=opening.allowed_contacts, grants=opening.grants)
    joints = {**after.robots["arm"], "y": 0.01, "z": LOW}
    plan = counter.with_node("put", motion=(*motion, back, shut), after=replace(after, robots={"arm": joints}))
    told = verify_plan(counter.problem, plan)
    found(
        told,
        "lets arm.left and mug touch by the grasp top, but arm neither holds nor takes mug",
        node,
    )
    found(told, "arm.(left|right) and mug collide", node)


def test_parts_that_share_space_when_they_are_put_together_are_caught(tmp_path):
    """A mate 10 mm deep in a full block, and an insertion that leads there."""
    deep = by_hand.SCENE.replace("[0.0299, 0.0301]", "[0.0199, 0.0201]").replace(
        "-0.02, 0, 0.02", "-0.02, 0, 0.01"
    )
    bench = by_hand.load(tmp_path, scene=deep)
    low = by_hand.above(by_hand.SOCKET[0] - 0.02, 0.0, by_hand.SOCKET[2] + 0.055)
    node = by_hand.insert()
    node = with_segment(node, 1, waypoints=(node.motion[1].waypoints[0], low))
    node = with_segment(node, 3, waypoints=(low, node.motion[3].waypoints[1]))
    found(report(bench, by_hand.take_peg(), node), "but where they are put together the two overlap", "n1")


@pytest.mark.parametrize("off", [5e-5, 3e-4])
def test_an_insertion_keeps_to_its_axis_within_the_tolerance_of_its_mate(tmp_path, off):
    """0.1 mm, if the scene does not say."""
    bench = by_hand.load(tmp_path)
    node = by_hand.insert()
    over, low = node.motion[1].waypoints
    middle = tuple((a + b) / 2 + (off if k == 0 else 0.0) for k, (a, b) in enumerate(zip(over, low, strict=True)))
    times = node.motion[1].times
    spoilt = with_segment(node, 1, waypoints=(over, middle, low), times=(times[0], sum(times) / 2, times[1]))
    told = report(bench, by_hand.take_peg(), spoilt)
    if off < 1e-4:
        assert told.ok, str(told)
    else:
        found(told, "lets peg and socket touch by the mate seated, but its insertion leaves its line", "n1")
        wider = by_hand.load(
            tmp_path, scene=by_hand.SCENE.replace("    insertion:", "    tolerance: 0.0004\n    insertion:")
        )
        assert report(wider, by_hand.take_peg(), spoilt).ok
