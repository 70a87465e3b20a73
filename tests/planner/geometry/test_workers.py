"""Workers: the same answers in the same order, whoever gives them, and whoever dies."""

import os
import time
from dataclasses import dataclass, field
from types import SimpleNamespace

import pytest

from kabo.geometry_server import Answer, GeometryStatistics, Refusal, Situation
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.evaluation import Evaluation, Evaluator
from kabo.planner.geometry.workers import ProcedureWorkers, SituatedCall
from kabo.planner.search.skeleton import SkeletonNode
from kabo.scene import GeometricState
from kabo.tasks.procedures import Elsewhere
from tests.planner.scripted import at, moved

START = Situation.of(GeometricState({"r": (0.0,), "s": (0.0,)}, {"a": at(0.0), "b": at(1.0)}))
PLANNER = os.getpid()


@dataclass
class ExternalProcedures:
    """Answers with a number made of call and attempt; some calls fail, die or sleep in a worker, or raise."""

    statistics: GeometryStatistics = field(default_factory=GeometryStatistics)
    elsewhere: Elsewhere | None = None
    here: list[str] = field(default_factory=list)
    scene: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(start=START.first, robots={"r": (), "s": ()}, movable=("a", "b"))
    )

    def bind(self, call: GroundCall) -> SimpleNamespace:
        return SimpleNamespace(moves=call.arguments[:2], reads=call.arguments[1:2])

    def knows(self, call: GroundCall, situation: Situation, attempt: int, effort: int) -> bool:
        return False

    def call(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> Answer:
        made = None if self.elsewhere is None else self.elsewhere(call, situation, attempt, effort)
        if made is not None:
            self.statistics.add(made[1])
            return made[0]
        self.here.append(call.procedure)
        if call.procedure == "dies" and os.getpid() != PLANNER:
            os._exit(1)
        if call.procedure == "sleeps" and os.getpid() != PLANNER:
            time.sleep(60.0)
        if call.procedure == "where":
            return Refusal("collision", str(os.getpid()))
        if call.procedure == "raises":
            raise ValueError("on purpose")
        self.statistics.count_samples(len(call.procedure))
        number = sum(map(ord, str(call))) + attempt
        answer = (
            Refusal("collision", f"{number}")
            if call.procedure == "fails"
            else moved(r=(float(number),), a=at(number))
        )
        self.statistics.record(call.procedure, answer)
        return answer


def act(name: str, then: SkeletonNode) -> SkeletonNode:
    return SkeletonNode(SimpleNamespace(name=name, call=GroundCall(name, ("r", "a"))), next=then)  # type: ignore[arg-type]


def branching(first: str, second: str) -> SkeletonNode:
    goal = SkeletonNode()
    action = SimpleNamespace(name="look", call=None)
    outcomes = (("false", act(first, act("after", goal))), ("true", act(second, act("behind", goal))))
    return SkeletonNode(action, on="p", outcomes=outcomes)  # type: ignore[arg-type]


def evaluated(root: SkeletonNode, size: int) -> tuple[Evaluation, ExternalProcedures]:
    procedures = ExternalProcedures()
    with ProcedureWorkers(procedures, size, lambda: False) as workers:  # type: ignore[arg-type]
        evaluator = Evaluator(procedures, lambda _c, _a, trace, _s: trace, 0, lambda: False, expect=workers.expect)  # type: ignore[arg-type]
        return evaluator.evaluate(root, (0, 0, 0, 0)), procedures


def told(evaluation: Evaluation) -> list[tuple[object, ...]]:
    return [(v.node.action and v.node.action.name, v.situation.key, v.answer) for v in evaluation.variants]


@pytest.mark.parametrize(("first", "second"), [("left", "right"), ("fails", "right"), ("left", "dies")])
def test_any_number_of_workers_gives_the_same_variants_refusals_and_counts(first: str, second: str) -> None:
    alone, by_itself = evaluated(branching(first, second), 1)
    for size in (2, 4):
        together, asking = evaluated(branching(first, second), size)
        assert told(together) == told(alone)
        assert together.refused == alone.refused
        assert asking.statistics == by_itself.statistics


def test_what_comes_at_once_is_asked_of_workers_and_what_comes_alone_is_not() -> None:
    _, procedures = evaluated(branching("left", "right"), 2)
    assert not {"left", "right"} & set(procedures.here)
    _, procedures = evaluated(act("left", act("right", SkeletonNode())), 2)
    assert procedures.here == ["left", "right"]


def test_an_error_is_raised_where_the_planner_asks() -> None:
    with pytest.raises(ValueError, match="on purpose"):
        evaluated(branching("left", "raises"), 2)


def test_a_later_attempt_is_asked_of_whoever_made_the_first() -> None:
    procedures = ExternalProcedures()
    with ProcedureWorkers(procedures, 3, lambda: False) as workers:  # type: ignore[arg-type]
        calls = [GroundCall("where", arguments) for arguments in (("r", "a"), ("s", "b"))]
        workers.expect(SituatedCall(call, START, attempt) for attempt in (0, 1) for call in calls)
        answers = [[procedures.call(call, START, attempt) for attempt in (0, 1)] for call in calls]
    assert [first == later for first, later in answers] == [True, True]
    assert answers[0] != answers[1]


def test_who_must_stop_does_not_wait() -> None:
    procedures = ExternalProcedures()
    with ProcedureWorkers(procedures, 2, lambda: True) as workers:  # type: ignore[arg-type]
        calls = [GroundCall("sleeps", arguments) for arguments in (("r", "a"), ("s", "b"))]
        workers.expect(SituatedCall(call, START) for call in calls)
        assert [workers.take(call, START, 0, 0) for call in calls] == [None, None]
