"""Rests of strokes move to the nodes that go on: nodes that end alike still do, all is proven, no branch gets slower."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from kabo.geometry_server import GeometryServer, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.planner.refine.freedom import NONE, freedoms
from kabo.planner.refine.junctions import junctions, move_rests
from kabo.planner.refine.legs import proven
from kabo.planner.refine.refining_stops import Stop, seconds_of
from kabo.planner.refine.timing import timed
from kabo.tasks.procedures import GeometricProcedures
from tests.tasks.conftest import DOMAINS, scene_of

BARTENDER = "bartender/four_bottles.yaml"
PICK, PLACE = GroundCall("pick", ("right", "bottle_3")), GroundCall("place", ("right", "bottle_3", "dishwasher"))


def stop_of(situation: Situation, call: GroundCall | None = None, answer: Success | None = None) -> Stop:
    node = SimpleNamespace(action=None if call is None else SimpleNamespace(call=call))
    return Stop([SimpleNamespace(node=node, answer=answer, overlap=0.0)], situation)  # type: ignore[list-item]


def linked(*edges: tuple[Stop, Stop]) -> None:
    for stop in dict.fromkeys(stop for stop, _ in edges):
        stop.following = tuple(after for first, after in edges if first is stop)
    for _, after in edges:
        after.ways_in += 1


def moving(robot: str) -> Stop:
    return stop_of(Situation({}, {}), PICK, Success((), {robot: (0.0,)}))


def standing() -> Stop:
    return stop_of(Situation({}, {}), PICK)


def test_nodes_meet_where_a_robot_stands_still_between_them() -> None:
    sense, first, second, other, then, goal = (
        standing(),
        moving("r"),
        moving("r"),
        moving("s"),
        moving("r"),
        stop_of(Situation({}, {})),
    )
    linked(
        (sense, first), (sense, second), (first, other), (other, then), (second, then), (then, goal), (sense, goal)
    )
    stops = [sense, first, second, other, then, goal]
    middle, last = junctions(stops, "r")
    assert (middle.ending, middle.beginning, middle.between) == ((first, second), (then,), (other,))
    assert (last.ending, last.beginning) == ((then,), ())
    assert not list(junctions(stops, "s"))  # one branch leads past `other`, so the start is at the same junction


@pytest.fixture
def plan():
    """Two branches that end alike with a bottle in the hand, the node where they meet, and its paths; all timed."""
    server = GeometricProcedures(GeometryServer(scene_of(BARTENDER)), (DOMAINS / BARTENDER).parent)
    context, start = server.server.context(), Situation.of(server.scene.start)
    picked = server.call(PICK, start)
    assert isinstance(picked, Success)
    held = start.replace(picked.changes)
    placed = server.call(PLACE, held)
    assert isinstance(placed, Success)
    root, goal = stop_of(start), stop_of(held.replace(placed.changes))
    picks = [stop_of(start, PICK, picked) for _ in range(2)]
    place = stop_of(held, PLACE, placed)
    linked((root, picks[0]), (root, picks[1]), (picks[0], place), (picks[1], place), (place, goal))
    stops = [root, *picks, place, goal]
    paths = {stop: stop.answer for stop in stops}
    for stop in (*picks, place):
        stop.keep(stop.situation, replace(stop.answer, motion=timed(context, stop.situation, stop.answer.motion)))
    known = freedoms([*server.stages(PICK), *server.stages(PLACE)], [server.scene.bodies["bottle_3"]])
    return SimpleNamespace(stops=stops, picks=picks, place=place, paths=paths, context=context, known=known)


def test_the_rest_of_a_lift_moves_across_branches_that_meet(plan) -> None:
    before = {stop: seconds_of(stop) for stop in plan.stops}
    lift = plan.picks[0].answer.motion[-1].waypoints
    move_rests(plan.stops, plan.paths, plan.context, dict.fromkeys(plan.stops, plan.known))
    for stop in plan.picks:
        assert seconds_of(stop) < before[stop] - 1e-3
        assert stop.answer.motion[-1].waypoints[-1] != lift[-1]
        assert stop.situation.replace(stop.answer.changes).key == plan.place.situation.key
        assert seconds_of(stop) + seconds_of(plan.place) < before[stop] + before[plan.place]
    for stop in (*plan.picks, plan.place):
        assert proven(plan.context, stop.situation, stop.answer.motion)
        assert proven(plan.context, stop.situation, plan.paths[stop].motion)


def test_nothing_moves_if_one_of_the_nodes_has_to_keep_its_end(plan) -> None:
    answers = [stop.answer for stop in plan.stops]
    known = {**dict.fromkeys(plan.stops, plan.known), plan.picks[1]: NONE}
    move_rests(plan.stops, plan.paths, plan.context, known)
    assert [stop.answer for stop in plan.stops[:-2]] == answers[:-2]


def test_nothing_moves_past_a_node_whose_call_may_read_where_the_robot_is(plan) -> None:
    reads = stop_of(plan.place.situation, PLACE, Success((), {}))
    for stop in plan.picks:
        stop.following = (reads,)
    linked((reads, plan.place))
    plan.paths[reads] = reads.answer
    stops = [*plan.stops[:3], reads, *plan.stops[3:]]
    answers = [stop.answer for stop in plan.picks]
    move_rests(stops, plan.paths, plan.context, dict.fromkeys(stops, plan.known))
    assert [stop.answer for stop in plan.picks] == answers
