"""Repairs: the next attempt at what made the thing that a refused call was to move, in the same skeleton."""

from types import SimpleNamespace

from kabo import tuning
from kabo.geometry_server import Refusal
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.evaluation import RefusedCall
from kabo.planner.geometry.refusals import RefusalTable
from kabo.planner.geometry.repairing import repaired
from kabo.planner.search.skeleton import Skeleton, SkeletonNode
from tests.planner.scripted import ScriptedServer, at, moved

PLACE, RELEASE = GroundCall("place", ("r", "a")), GroundCall("release", ("r", "a"))
GOAL = SkeletonNode()


def act(call: GroundCall, then: SkeletonNode, attempt: int = 0) -> SkeletonNode:
    return SkeletonNode(SimpleNamespace(name=call.procedure, call=call), attempt, next=then)  # type: ignore[arg-type]


def ledger() -> RefusalTable:
    server = ScriptedServer(lambda *_: moved(), {"r": (0.0,)}, {"a": at(0.0), "b": at(1.0)})
    return RefusalTable(server)  # type: ignore[arg-type]


def refusal(book: RefusalTable, attempt: int, *reads: str) -> RefusedCall:
    failure = Refusal("collision", "", frozenset(reads))
    return RefusedCall(RELEASE, 0, failure, frozenset([book.after(PLACE, attempt, book.start)]))


def test_what_made_the_refused_thing_is_asked_again_wherever_it_stands_in_the_skeleton() -> None:
    book, shared = ledger(), act(PLACE, act(RELEASE, GOAL))
    look = SkeletonNode(
        SimpleNamespace(name="look", call=None), on="p", outcomes=(("false", shared), ("true", shared))
    )  # type: ignore[arg-type]
    found = repaired(Skeleton(look), [refusal(book, 0, "a")], book)
    assert found is not None
    (_, first), (_, second) = found.root.outcomes
    assert first is second, "what was shared stays shared"
    assert (first.attempt, first.next.attempt) == (1, 0)  # type: ignore[union-attr]


def test_where_nothing_that_was_sampled_is_to_blame_nothing_is_repaired() -> None:
    book, skeleton = ledger(), Skeleton(act(PLACE, act(RELEASE, GOAL)))
    at_start = RefusedCall(RELEASE, 0, Refusal("collision", "", frozenset({"a"})), frozenset([book.start]))
    assert repaired(skeleton, [at_start], book) is None
    assert repaired(skeleton, [refusal(book, 0, "b")], book) is None


def test_repairs_end_with_the_attempts() -> None:
    book = ledger()
    skeleton = Skeleton(act(PLACE, act(RELEASE, GOAL), tuning.ATTEMPTS_PER_EFFORT - 1))
    assert repaired(skeleton, [refusal(book, tuning.ATTEMPTS_PER_EFFORT - 1, "a")], book) is None


def test_what_has_no_other_answer_is_not_asked_for_one_but_what_came_before_it() -> None:
    """A place that was found by no sample, say: then another grasp may help."""
    book, pick = ledger(), GroundCall("pick", ("r", "a"))
    held = book.after(pick, 0, book.start)
    placed = book.after(PLACE, 0, held)
    book.record_refusal(PLACE, 1, Refusal("collision", "", frozenset({"a"})), [held])
    refused = RefusedCall(RELEASE, 0, Refusal("collision", "", frozenset({"a"})), frozenset([placed]))
    found = repaired(Skeleton(act(pick, act(PLACE, act(RELEASE, GOAL)))), [refused], book)
    assert found is not None
    assert [found.root.attempt, found.root.next.attempt] == [1, 0]  # type: ignore[union-attr]


def test_what_failed_at_a_later_attempt_begins_anew_with_what_it_is_given_now() -> None:
    book, pick = ledger(), GroundCall("pick", ("r", "a"))
    held = book.after(pick, 0, book.start)
    failure = Refusal("collision", "", frozenset({"a"}))
    book.record_refusal(PLACE, 1, failure, [held])
    found = repaired(
        Skeleton(act(pick, act(PLACE, act(RELEASE, GOAL), 1))),
        [RefusedCall(PLACE, 1, failure, frozenset([held]))],
        book,
    )
    assert found is not None
    assert [found.root.attempt, found.root.next.attempt] == [1, 0]  # type: ignore[union-attr]
