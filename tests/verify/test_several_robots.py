"""Two hands, mates, groups: right plans are verified, and every way of spoiling one is caught where it happens."""

from dataclasses import replace

import numpy as np
import pytest

from kabo.plan import Grant, Node, ObjectPose, StateChange
from kabo.scene import load_scene
from kabo.verify import verify_plan
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.trajectories.judge import followed
from kabo.verify.motion.windows import window_path, windows
from tests.verify import bench as by_hand
from tests.verify.bench import Bench
from tests.verify.smooth import smooth, smooth_node
from tests.verify.test_verification import found


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Bench:
    return by_hand.load(tmp_path_factory.mktemp("bench"))


def report(bench, *nodes: Node):
    return verify_plan(bench.problem, bench.plan(*nodes))


def with_segment(node: Node, index: int, **changes) -> Node:
    """The node with one segment changed."""
    motion = list(node.motion)
    motion[index] = replace(motion[index], **changes)
    return replace(node, motion=tuple(motion))


def later(node: Node, first: int, by: float) -> Node:
    """The node with all segments from one on put off."""
    moved = [
        replace(s, times=tuple(round(t + by, 6) for t in s.times)) if i >= first else s
        for i, s in enumerate(node.motion)
    ]
    return replace(node, motion=tuple(moved))


# --------------------------------------------------------------------------------------------------- right plans
@pytest.mark.parametrize(
    "nodes",
    [
        lambda: [by_hand.take_peg(), by_hand.hand_over()],
        lambda: [by_hand.take_peg(), by_hand.insert()],
        lambda: [by_hand.take_peg(), by_hand.insert(), by_hand.take_socket()],
        lambda: [by_hand.take_peg(), by_hand.take_socket(), by_hand.insert_bimanual()],
        lambda: [by_hand.take_peg(), by_hand.insert(), take_both()],
    ],
    ids=["hand over", "insert", "group by its root", "bimanual", "group by its member"],
)
def test_right_plans_of_two_hands_are_verified(bench, nodes):
    told = report(bench, *nodes())
    assert told.ok, str(told)


# -------------------------------------------------------------------------------------------------------- mates
def test_an_insertion_without_its_permit_is_a_collision(bench):
    node = by_hand.insert(allowed_contacts=by_hand.fingers("left", "peg"))
    found(report(bench, by_hand.take_peg(), node), "peg and socket collide", "n1")


def test_parts_that_are_put_together_beside_their_mate_are_caught(bench):
    """The peg ends 5 mm too high, which its recorded pose says too."""
    node = by_hand.insert()
    high = by_hand.above(by_hand.SOCKET[0] - 0.02, by_hand.SOCKET[1], by_hand.SOCKET[2] + 0.07)
    motion = list(node.motion)
    motion[1] = replace(motion[1], waypoints=(motion[1].waypoints[0], high))
    motion[3] = replace(motion[3], waypoints=(high, motion[3].waypoints[-1]))
    record = replace(node.after, objects={"peg": replace(by_hand.SEATED, position=(-0.02, 0.0, 0.055))})
    told = report(bench, by_hand.take_peg(), replace(node, motion=tuple(motion), after=record))
    found(told, r"peg and socket are not put together as any of their mates says \(seated: .* 4.9 mm", "n1")


def test_contact_is_permitted_on_the_last_way_into_the_mate_only(bench):
    first, second, *rest = by_hand.insert().motion
    wider = replace(first, allowed_contacts=second.allowed_contacts)
    node = replace(by_hand.insert(), motion=(wider, second, *rest))
    found(report(bench, by_hand.take_peg(), node), "permits contact of peg and socket", "n1")


def test_while_parts_are_mated_nothing_else_may_touch(bench):
    held = (*by_hand.fingers("left", "peg"), by_hand.MATED)
    granted = by_hand.granting(held)
    for pair in (("left.left", "socket"), ("peg", "pedestal")):
        node = by_hand.insert(allowed_contacts=(*held, pair))
        text = f"permits contact of {pair[0]} and {pair[1]}, but does not say what grants it"
        found(report(bench, by_hand.take_peg(), with_segment(node, 1, grants=granted)), text, "n1")


def test_parts_that_are_never_put_together_are_caught(bench):
    node = by_hand.insert(attach=())
    found(report(bench, by_hand.take_peg(), node), "never puts peg and socket together", "n1")


def test_a_hand_that_goes_away_without_opening_is_caught(bench):
    first, second, opening, retreat = by_hand.insert().motion
    closed = replace(opening, waypoints=((0.02,), (0.02,)))
    node = replace(by_hand.insert(), motion=(first, second, closed, retreat))
    told = report(bench, by_hand.take_peg(), node)
    found(told, "left.left and peg collide|left.right and peg collide", "n1")
    found(told, "left gave peg away, but its finger is not open", "n1")


def test_a_hand_that_opens_before_the_part_is_in_its_place_is_caught(bench):
    """The part would stay in the air."""
    first, second, opening, retreat = by_hand.insert().motion
    begin = opening.times[-1] - opening.times[0]
    early = replace(opening, times=tuple(round(t - opening.times[0] + second.times[0], 6) for t in opening.times))
    moved = replace(second, times=tuple(round(t + begin, 6) for t in second.times))
    node = replace(by_hand.insert(), motion=(first, early, moved, retreat))
    found(report(bench, by_hand.take_peg(), node), "left moves its hand while it holds peg", "n1")


def test_a_procedure_that_mates_nothing_may_attach_nothing_to_a_body(bench):
    node = with_segment(by_hand.take_peg(), 2, attach=(("peg", "table"),))
    found(report(bench, node, by_hand.hand_over()), "attaches peg to table, which it may not", "n0")


# ----------------------------------------------------------------------------------------------------- two hands
def test_arms_that_move_at_once_are_judged_where_they_are_at_that_time(bench):
    """Together the socket rises to the peg; after the peg has gone down to where it will be, it must be free."""
    pair = [by_hand.take_peg(), by_hand.take_socket()]
    told = report(bench, *pair, by_hand.insert_bimanual())
    assert told.ok, str(told)
    late = report(bench, *pair, by_hand.insert_bimanual(delay=0.2))
    found(late, "lets peg and socket touch by the mate seated, but right begins or ends to move meanwhile", "n2")
    crossing = [meeting(0.1), meeting(2.0)]
    assert report(bench, by_hand.take_peg(), crossing[1], by_hand.hand_over()).ok
    told = report(bench, by_hand.take_peg(), crossing[0], by_hand.hand_over())
    found(told, "left.* and right.*collide|right.* and left.*collide", "n1")
    assert 0.3 < next(f.time for f in told.findings if "collide" in f.message) < 1.7


def meeting(delay: float) -> Node:
    """Both arms pass through the same place and return; the right one starts so much later."""
    left, right = by_hand.UP, by_hand.HOME["right"]
    up = (*left[:2], -0.4, 0.0)
    there = (0.0, 0.0, -0.4, 0.0)
    one = by_hand.stretch(
        "left", 0.0, [left, up, there, up, left], allowed_contacts=by_hand.fingers("left", "peg")
    )
    place = by_hand.beside(-0.02, 0.0, 0.45)
    other = by_hand.stretch("right", delay, [right, place, right])
    change = by_hand.after({"left": left, "right": right}, {"left": 0.02, "right": 0.045})
    return Node("action", "wave", {"r": "left", "r2": "right"}, motion=(one, other), after=change)


def smooth_report(bench, *nodes: Node):
    """The report on the nodes with trajectories."""
    return verify_plan(bench.problem, smooth(bench.plan(*nodes), load_scene(bench.problem.scene)))


@pytest.mark.parametrize("delay", [0.0, 0.001, 0.1])
def test_two_arms_that_follow_trajectories_lift_at_once_what_stands_under_them(bench, delay):
    """Where only one arm moves a body away from its support, it does not matter when the other arm moves."""
    told = smooth_report(bench, by_hand.lift_both(delay=delay), by_hand.insert_bimanual())
    assert told.ok, str(told)


def test_parts_that_touch_while_two_arms_move_have_one_law_of_time(bench):
    pair = [by_hand.take_peg(), by_hand.take_socket()]
    told = smooth_report(bench, *pair, by_hand.insert_bimanual())
    assert told.ok, str(told)
    late = smooth_report(bench, *pair, by_hand.insert_bimanual(delay=0.001))
    found(late, "lets peg and socket touch .*, but right begins or ends to move meanwhile", "n2")


@pytest.mark.parametrize(("delay", "least", "most"), [(0.0, 0.0, 1e-9), (0.001, 5e-8, 1e-3)])
def test_only_arms_with_a_common_law_follow_their_joined_path_exactly(bench, delay, least, most):
    scene = load_scene(bench.problem.scene)
    arms = SceneModel(scene).arms
    motion = smooth_node(by_hand.lift_both(delay=delay), scene).motion
    q = {name: np.array(scene.start.robots[name]) for name in arms}
    how = [followed(segment) for segment in motion]
    *_, both = [window for window in windows(motion) if len(window.running) == 2]
    path = window_path(both, motion, arms, q, how)
    assert least <= path.deviations.max() <= most
    of_left = np.arange(path.steps.shape[1]) < len(q["left"])
    strays = path.strays(np.array([of_left, ~of_left, of_left | True], float)).max(axis=0)
    assert strays[:2].max() <= 1e-9, "what only one arm moves does not see the law of the other one"
    assert least <= strays[2]


def test_a_hand_over_to_a_hand_that_is_not_closed_is_caught(bench):
    node = with_segment(by_hand.hand_over(), 2, waypoints=((0.045,), (0.04,)))
    found(report(bench, by_hand.take_peg(), node), "peg is not taken as any.*side: finger is at 0.04", "n1")


def test_a_hand_that_moves_on_before_the_other_has_opened_is_caught(bench):
    node = by_hand.hand_over()
    last = node.motion[2]
    there = by_hand.beside(*by_hand.MEET)
    away = (there[0], there[1], there[2] + 0.05, there[3])
    pulled = by_hand.stretch("right", last.times[-1], [there, away])
    told = report(bench, by_hand.take_peg(), replace(node, motion=(*node.motion[:3], pulled)))
    found(told, "peg and left|left.* and peg", "n1")


def test_what_the_giver_drops_before_it_is_taken_is_caught(bench):
    """Left lets go before right has come."""
    carry, reach, close, open_, leave = by_hand.hand_over().motion
    open_ = replace(open_, times=tuple(t + carry.times[-1] - open_.times[0] for t in open_.times), detach=("peg",))
    reach, close = (replace(s, times=tuple(round(t + 0.5, 6) for t in s.times)) for s in (reach, close))
    leave = replace(leave, times=tuple(t + 1 for t in leave.times))
    node = replace(by_hand.hand_over(), motion=(carry, open_, reach, close, leave))
    found(report(bench, by_hand.take_peg(), node), "peg is not taken as any of its grasp families", "n1")


def test_what_is_recorded_of_a_hand_over_is_compared(bench):
    node = by_hand.hand_over()
    kept = replace(node.after, objects={"peg": by_hand.ON_LEFT})
    found(report(bench, by_hand.take_peg(), replace(node, after=kept)), "records peg on left.palm", "n1")
    none = replace(node.after, objects={})
    found(report(bench, by_hand.take_peg(), replace(node, after=none)), "does not record where peg is", "n1")


def test_a_robot_that_the_call_does_not_name_may_not_move(bench):
    node = by_hand.hand_over()
    node = replace(node, action="join", arguments={"r": "left", "o": "peg", "other": "socket"})
    found(report(bench, by_hand.take_peg(), node), "moves right, which it does not name", "n1")


# -------------------------------------------------------------------------------------------------------- groups
def take_both(**objects: ObjectPose) -> Node:
    """Left picks the peg that sits in the socket: the socket comes along."""
    low, high = by_hand.seat(by_hand.SOCKET), by_hand.seat(by_hand.SOCKET, 0.2)
    held = by_hand.fingers("left", "peg")
    lifted = (
        *by_hand.granting(held),
        Grant("support", ("socket", "pedestal"), "top"),
    )  # nothing grants what is together
    lifting = {"allowed_contacts": (*held, ("pedestal", "socket"), by_hand.MATED), "grants": lifted}
    closing = {"attach": (("peg", "left.palm"),), "allowed_contacts": by_hand.fingers("left", "peg")}
    motion = by_hand.one_after_the_other(
        ("left", [high, low], {}),
        ("left", [(0.045,), (0.02,)], closing),
        ("left", [low, high], lifting),
    )
    hung = {"peg": by_hand.ON_LEFT, "socket": ObjectPose("peg", (0.02, 0.0, -0.05), by_hand.STRAIGHT)} | objects
    change = by_hand.after({"left": high}, {"left": 0.02}, **hung)
    return Node("action", "take", {"r": "left", "o": "peg"}, motion=motion, after=change)


def test_a_group_is_swept_as_a_whole(tmp_path):
    """A bar where only the peg comes by while right lifts the socket that it sits in."""
    bar = "  bar: {box: [0.3, 0.02, 0.01], pose: {position: [0.15, 0.012, 0.31]}}\n  peg: {model"
    bench = by_hand.load(tmp_path, scene=by_hand.SCENE.replace("  peg: {model", bar))
    nodes = [by_hand.take_peg(), by_hand.insert(), by_hand.take_socket()]
    told = report(bench, *nodes)
    found(told, "peg and bar collide", "n2")
    assert all("bar" in f.bodies for f in told.findings if f.node == "n2")


def test_the_root_of_a_group_is_who_is_held(bench):
    start = [by_hand.take_peg(), by_hand.insert()]
    told = report(bench, *start, take_both(peg=by_hand.SEATED, socket=ObjectPose(
        "left.palm", (0.02, 0.0, -0.175), by_hand.STRAIGHT)))  # fmt: skip
    found(told, "records peg on socket", "n2")
    node = take_both()
    alone = replace(node.after, objects={"peg": by_hand.ON_LEFT})
    found(report(bench, *start, replace(node, after=alone)), "records? .*(socket|peg)", "n2")
    off = take_both(socket=ObjectPose("peg", (0.02, 0.0, -0.06), by_hand.STRAIGHT))
    found(report(bench, *start, off), "records socket 0.01 away", "n2")


def test_a_group_that_stands_may_be_recorded_by_any_root(bench):
    """The peg sits in the socket: whether it hangs on the socket, or the socket on it, is the same."""
    turned = {
        "peg": ObjectPose("world", (0.28, 0.0, 0.25), by_hand.STRAIGHT),
        "socket": ObjectPose("peg", (0.02, 0.0, -0.05), by_hand.STRAIGHT),
    }
    node = by_hand.insert()
    node = replace(node, after=replace(node.after, objects=turned))
    told = report(bench, by_hand.take_peg(), node, take_both())
    assert told.ok, str(told)
    apart = {"peg": turned["peg"]}
    node = replace(node, after=replace(node.after, objects=apart))
    found(report(bench, by_hand.take_peg(), node, take_both()), "records peg on world", "n1")


# --------------------------------------------------------------------------------------------- tasks of one's own
def test_a_task_of_the_domain_s_own_is_judged_as_far_as_it_can_be(bench):
    push = by_hand.take_peg()
    node = replace(push, action="shove")
    told = report(bench, node, by_hand.insert())
    assert told.ok and any('"stir" is a task of the domain\'s own' in note for note in told.notes), str(told)
    wrong = with_segment(node, 2, attach=(("socket", "left.palm"),))
    found(report(bench, wrong, by_hand.insert()), r"stir\(left, peg\) attaches socket, which it may not", "n0")
    lost = replace(node, after=StateChange(node.after.robots))
    found(report(bench, lost, by_hand.insert()), "does not record where peg is", "n0")
    foreign = replace(node, arguments={"r": "right", "o": "peg"})
    found(report(bench, foreign, by_hand.insert()), "moves left, which it does not name", "n0")


# -------------------------------------------------------------------------------------- motions that begin early
def early(node: Node, seconds: float) -> Node:
    """The node, begun before the one before has ended."""
    return replace(node, overlap=seconds)


def test_a_motion_may_begin_early_if_nothing_can_meet_however_late_either_runs(bench):
    nodes = [by_hand.take_peg(), early(by_hand.take_socket(), 1.0), by_hand.insert_bimanual()]
    told = report(bench, *nodes)
    assert told.ok, str(told)


def test_a_motion_that_begins_early_may_not_come_where_the_one_before_still_is(bench):
    """Right swings through where left passes: one after the other that is free, at once it need not be."""
    left, right = [meeting_of(robot) for robot in ("left", "right")]
    told = report(bench, by_hand.take_peg(), left, right, by_hand.hand_over())
    assert told.ok, str(told)
    told = report(bench, by_hand.take_peg(), left, early(right, 0.01), by_hand.hand_over())
    assert told.ok, str(told)  # by then left is back above where it began
    told = report(bench, by_hand.take_peg(), left, early(right, 1.5), by_hand.hand_over())
    found(told, "can meet, as it begins before n1 has ended", "n2")
    assert {f.node for f in told.findings} == {"n2"}


def meeting_of(robot: str) -> Node:
    """One arm of `meeting`."""
    node = meeting(0.0)
    motion = tuple(segment for segment in node.motion if segment.robot == robot)
    return replace(node, motion=motion, after=StateChange({robot: node.after.robots[robot]}))


def coming_near(y: float) -> Node:
    """Right comes near where left passes, `y` to its side, and returns."""
    home, place = by_hand.HOME["right"], by_hand.beside(-0.02, y, 0.45)
    return replace(meeting_of("right"), motion=(by_hand.stretch("right", 0.0, [home, place, home]),))


def test_who_may_begin_early(bench):
    start = by_hand.take_peg()
    cases = [
        ([early(start, 0.5), by_hand.hand_over()], "not after exactly one node that goes on with it alone", "n0"),
        ([start, early(by_hand.hand_over(), 0.5)], "both move or use left", "n1"),
        ([start, early(by_hand.take_socket(), 9.0), by_hand.insert_bimanual()], "n0 lasts 1.89 s only", "n1"),
        ([start, early(by_hand.take_socket(), 1.5), early(meeting_of("left"), 1.5), by_hand.insert_bimanual()],
         "begins before what comes before n1 has ended", "n2"),
    ]  # fmt: skip
    for nodes, text, place in cases:
        found(report(bench, *nodes), text, place)
