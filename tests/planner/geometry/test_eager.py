"""Eager geometry: a call is asked when the node behind it is about to be expanded, and never twice."""

from kabo.geometry_server import Refusal, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.eager import EagerGeometry
from tests.planner.scripted import ScriptedServer, at, moved

PICK, OTHER = GroundCall("pick", ("r", "a")), GroundCall("pick", ("r", "b"))


def refused(call: GroundCall, situation: Situation, attempt: int) -> Refusal:
    return Refusal("collision", "in the way", frozenset({"a"}))


def two_ways(call: GroundCall, situation: Situation, attempt: int) -> Success | Refusal:
    return moved(r=(1.0,), a=at(0.1 * attempt)) if attempt < 2 else refused(call, situation, attempt)


def interleaved(script=two_ways) -> tuple[EagerGeometry, ScriptedServer]:
    server = ScriptedServer(script, {"r": (0.0,)}, {"a": at(5.0), "b": at(1.0)})
    return EagerGeometry(server), server  # type: ignore[arg-type]


def test_nothing_is_asked_before_a_node_is_to_be_expanded() -> None:
    book, server = interleaved()
    ((_, after),) = book.options(PICK, book.start)
    ((_, elsewhere),) = book.options(OTHER, book.start)
    assert not server.asked
    assert book.key(after) != book.key(elsewhere) != book.key(book.start)
    assert book.confirm(after)
    assert server.asked == [("pick(r, a)", 0)]
    assert book.confirm(after)
    assert len(server.asked) == 1


def test_nodes_that_come_to_the_same_are_found_out_when_they_are_settled() -> None:
    book, _ = interleaved(lambda *_: moved(r=(1.0,)))
    ((_, one),), ((_, other),) = book.options(PICK, book.start), book.options(OTHER, book.start)
    assert book.confirm(one) and book.confirm(other)
    assert book.key(one) == book.key(other)


def test_what_was_refused_is_not_offered_again_and_leads_nowhere() -> None:
    book, server = interleaved(refused)
    ((_, after),) = book.options(PICK, book.start)
    assert not book.confirm(after)
    assert not book.options(PICK, book.start)
    assert not book.options(OTHER, after)
    assert len(server.asked) == 1


def test_another_answer_is_asked_for_after_trying_harder_until_there_are_no_more() -> None:
    book, _ = interleaved()
    assert [attempt for attempt, _ in book.options(PICK, book.start)] == [0]
    assert book.most_expansions("breadth-first") > book.most_expansions("best")
    assert book.try_harder()
    offered = book.options(PICK, book.start)
    assert [attempt for attempt, _ in offered] == [0, 1, 2]
    assert [book.confirm(after) for _, after in offered] == [True, True, False]
    assert [attempt for attempt, _ in book.options(PICK, book.start)] == [0, 1]
    assert not book.proved()
