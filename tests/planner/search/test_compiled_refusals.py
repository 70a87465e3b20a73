"""What a ledger has learnt, compiled: the packed task allows exactly what the ledger's own options allow."""

from types import SimpleNamespace

import pytest

from kabo.finite_domain import FiniteTask, Operator, StateVariable, astar, breadth_first
from kabo.geometry_server import Refusal
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.refusals import RefusalTable
from kabo.planner.search.compiled_refusals import LearntTask, learnt_task
from kabo.tuning import ACTION_PRICE, REFUSAL_PRICE, RETRY_PRICE, SUSPICION_PRICE
from tests.planner.scripted import ScriptedServer, at, moved

PICK, PLACE, ASIDE = (GroundCall(name, ("r", "a")) for name in ("pick", "place", "aside"))
CLEAR = GroundCall("clear", ("r", "b"))
ACTIONS = [SimpleNamespace(call=call) for call in (PICK, PLACE, ASIDE, CLEAR)]


def base() -> FiniteTask:
    """Where a is: 0 first, 1 in the hand, 2 placed, 3 aside; b may be cleared at any time."""
    operators = (
        Operator("pick", ((0, (0, 3)),), (_to(1),), 1, 0),
        Operator("place", ((0, (1,)),), (_to(2),), 1, 1),
        Operator("aside", ((0, (1,)),), (_to(3),), 1, 2),
        Operator("clear", (), (), 1, 3),
    )
    return FiniteTask((StateVariable("a", 4),), (0,), operators, ((0, (2,)),))


def _to(value: int):  # noqa: ANN202
    from kabo.finite_domain import Effect

    return Effect((), 0, value)


def ledger() -> RefusalTable:
    server = ScriptedServer(lambda *_: moved(), {"r": (0.0,)}, {"a": at(0.0), "b": at(1.0)})
    return RefusalTable(server)  # type: ignore[arg-type]


def failure(*reads: str, between: tuple[str, str] | None = None, reason: str = "collision") -> Refusal:
    pairs = () if between is None else ((between, 9),)
    return Refusal(reason, "in the way", frozenset(reads), pairs)


def plan(learnt: LearntTask) -> list[str]:
    found = astar(learnt.compiled)
    assert found.plan is not None
    task = learnt.compiled.task
    return [f"{task.operators[o].name} {learnt.attempts[o]}" for o in found.plan]


def test_without_refusals_the_task_is_the_same_but_for_the_scale_of_its_costs() -> None:
    learnt = learnt_task(base(), ACTIONS, ledger().learnt())
    assert plan(learnt) == ["pick 0", "place 0"]
    assert astar(learnt.compiled).cost == 2 * ACTION_PRICE
    assert len(learnt.compiled.task.variables) == 1


def test_what_was_in_the_way_is_moved_before_another_grasp_is_tried() -> None:
    book = ledger()
    held = book.after(PICK, 0, book.start)
    book.record_refusal(PLACE, 0, failure("a", "b", between=("a", "b")), [held])
    learnt = learnt_task(base(), ACTIONS, book.learnt())  # type: ignore[arg-type]
    assert sorted(plan(learnt)) == ["clear 0", "pick 0", "place 0"]
    assert astar(learnt.compiled).cost == 3 * ACTION_PRICE + REFUSAL_PRICE


def test_another_grasp_is_tried_where_nothing_movable_was_in_the_way() -> None:
    book = ledger()
    held = book.after(PICK, 0, book.start)
    book.record_refusal(PLACE, 0, failure("a"), [held])
    learnt = learnt_task(base(), ACTIONS, book.learnt())  # type: ignore[arg-type]
    assert plan(learnt) == ["pick 1", "place 0"]
    assert astar(learnt.compiled).cost == 2 * ACTION_PRICE + RETRY_PRICE + REFUSAL_PRICE


def test_what_is_doubtful_is_done_where_there_is_no_other_way() -> None:
    book = ledger()
    held = book.after(PICK, 0, book.start)
    book.record_refusal(PLACE, 0, failure("a", reason="out_of_reach"), [held])
    learnt = learnt_task(base(), ACTIONS, book.learnt())  # type: ignore[arg-type]
    assert astar(learnt.compiled).cost == 2 * ACTION_PRICE + RETRY_PRICE + SUSPICION_PRICE + REFUSAL_PRICE


def test_a_refusal_of_everything_leaves_nothing() -> None:
    book = ledger()
    book.record_refusal(PLACE, 0, failure(), [book.start])
    learnt = learnt_task(base(), ACTIONS, book.learnt())  # type: ignore[arg-type]
    assert learnt.whole
    assert astar(learnt.compiled).status == "unsolvable"


def test_attempts_end_where_they_were_refused() -> None:
    book = ledger()
    for attempt in (0, 1):
        book.record_refusal(PLACE, 0, failure("a"), [book.after(PICK, attempt, book.start)])
    book.record_refusal(PICK, 2, failure("a"), [book.start])
    learnt = learnt_task(base(), ACTIONS, book.learnt())  # type: ignore[arg-type]
    assert plan(learnt) == ["pick 0", "aside 0", "pick 0", "place 0"], "from elsewhere it is another grasp"


@pytest.mark.parametrize("seed", range(6))
def test_every_plan_of_the_compiled_task_is_one_that_the_ledger_allows(seed: int) -> None:
    """Refusals are thrown in along the plans that come out; each plan is allowed by the ledger, and ends come."""
    book, calls = ledger(), {"pick": PICK, "place": PLACE, "aside": ASIDE, "clear": CLEAR}
    for number in range(40):
        found = breadth_first(learnt_task(base(), ACTIONS, book.learnt()).compiled)
        learnt = learnt_task(base(), ACTIONS, book.learnt())
        if found.plan is None:
            assert not learnt.whole or found.status == "unsolvable"
            break
        trace, traces = book.start, []
        for o in found.plan:
            call, attempt = calls[learnt.compiled.task.operators[o].name], learnt.attempts[o]
            traces.append((call, attempt, trace))
            allowed = dict(book.options(call, trace))
            assert attempt in allowed
            trace = allowed[attempt]
        call, attempt, where = traces[(seed * 7 + number * 3) % len(traces)]
        reads = [name for k, name in enumerate(("r", "a", "b")) if (seed + number) >> k & 1]
        book.record_refusal(call, attempt, failure(*reads, between=("a", "b") if seed % 2 else None), [where])
    else:
        pytest.fail("refusals never come to an end")
