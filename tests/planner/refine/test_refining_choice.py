"""Other solutions along a stretch: the shortest of all ways through them, beside trying every combination."""

from itertools import product
from types import SimpleNamespace

from hypothesis import event, given
from hypothesis import strategies as st

from kabo.geometry_server import Refusal, Situation, Success
from kabo.plan import Segment
from kabo.planner.refine import refining_choice
from kabo.planner.refine.joining import segment_length
from kabo.planner.refine.refining_choice import AlternativeChoice, PlanDraft
from kabo.planner.refine.refining_stops import Stop

PLACES = st.integers(0, 6)
TABLES = st.lists(st.lists(PLACES, min_size=1, max_size=3), min_size=2, max_size=4)


def length(answer: Success | None) -> float:
    return 0.0 if answer is None else sum(map(segment_length, answer.motion))


def at(place: int) -> Situation:
    return Situation({"r": ((float(place),),)}, {})


class Server:
    """A robot on a line: the k-th solution of task i leads to its k-th place, with a detour over 0 where it is odd."""

    def __init__(self, table):
        self.table = table
        self.statistics = SimpleNamespace(samples=0)
        self.server = SimpleNamespace(context=lambda: None)
        self.stop = lambda: False

    def call(self, number, situation, attempt=0, effort=0):
        if attempt >= len(self.table[number]):
            return Refusal("no_path", "no more")
        return self.answer(situation, self.table[number][attempt])

    def answer(self, situation, place):
        (here,) = situation.configuration("r")
        way = ((here,), (0.0,), (float(place),)) if place % 2 else ((here,), (float(place),))
        return Success(
            (Segment("r", ("x",), way, tuple(map(float, range(len(way)))), "go"),), {"r": (float(place),)}
        )

    def single(self, number, situation):
        return ("r",)


def chain(server, count) -> tuple[list[Stop], PlanDraft]:
    """The stops of a plan in which every task gave its first solution, and the goal."""
    stops, answers, situations, situation = [], {}, {}, at(3)
    for number in range(count):
        node = SimpleNamespace(action=SimpleNamespace(call=number))
        stops.append(Stop([SimpleNamespace(node=node)], situation))  # type: ignore[list-item]
        answers[stops[-1]] = server.call(number, situation)
        situations[stops[-1]] = situation
        situation = situation.replace(answers[stops[-1]].changes)
    goal = Stop([SimpleNamespace(node=SimpleNamespace(action=None))], situation)  # type: ignore[list-item]
    answers[goal], situations[goal] = None, situation
    stops.append(goal)
    for stop, after in zip(stops, stops[1:], strict=False):
        stop.following = (after,)
    return stops, PlanDraft(answers, situations)


def shortest(server) -> float:
    """The least of all combinations."""
    found = []
    for places in product(*server.table):
        situation, total = at(3), 0.0
        for place in places:
            answer = server.answer(situation, place)
            total += length(answer)
            situation = situation.replace(answer.changes)
        found.append(total)
    return min(found)


@given(table=TABLES)
def test_a_stretch_takes_the_shortest_of_all_ways_through_its_solutions(table):
    server = Server(table)
    stops, draft = chain(server, len(table))
    beam, refining_choice.BEAM_WIDTH = refining_choice.BEAM_WIDTH, 100
    try:
        choice = AlternativeChoice(server, stops, draft, 1000, length)  # type: ignore[arg-type]
        choice.improve(stops[:-1])
    finally:
        refining_choice.BEAM_WIDTH = beam
    event("found the shortest at once" if choice.draft is draft else "shortened")
    assert choice.total(choice.draft) <= shortest(server) + refining_choice.LEAST_GAIN
    assert choice.total(choice.draft) <= choice.total(draft)


@given(table=TABLES)
def test_what_is_chosen_follows_from_one_situation_to_the_next(table):
    server = Server(table)
    stops, draft = chain(server, len(table))
    choice = AlternativeChoice(server, stops, draft, 1000, length)  # type: ignore[arg-type]
    choice.improve(stops[:-1])
    situation = at(3)
    for stop in stops:
        assert choice.draft.situations[stop].key == situation.key
        answer = choice.draft.answers[stop]
        if answer is not None:
            assert answer.motion[0].waypoints[0] == situation.configuration("r")
            situation = situation.replace(answer.changes)


def test_nothing_is_tried_when_the_samples_are_spent():
    server = Server([[6, 2], [3, 4]])
    stops, draft = chain(server, 2)
    server.statistics.samples = 0
    choice = AlternativeChoice(server, stops, draft, -1, length)  # type: ignore[arg-type]
    choice.improve(stops[:-1])
    assert choice.draft is draft


def test_what_an_answer_costs_is_computed_once():
    server = Server([[6, 2], [3, 4], [1, 5]])
    stops, draft = chain(server, 3)
    asked: list[Success] = []  # kept, so that no two have the same identity

    def counted(answer: Success | None) -> float:
        asked.extend([answer] if answer is not None else [])
        return length(answer)

    choice = AlternativeChoice(server, stops, draft, 1000, counted)  # type: ignore[arg-type]
    choice.improve(stops[:-1])
    assert choice.total(choice.draft) == sum(map(length, choice.draft.answers.values()))
    assert len({id(answer) for answer in asked}) == len(asked) > 3
