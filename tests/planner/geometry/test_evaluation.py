"""Evaluation: branches meet where they may, procedures answer for all values, refusals name their traces."""

from types import SimpleNamespace

from kabo.geometry_server import Refusal, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.evaluation import Evaluation, Evaluator, in_order
from kabo.planner.geometry.refusals import RefusalTable
from kabo.planner.search.skeleton import SkeletonNode
from tests.planner.scripted import Script, ScriptedServer, at, moved

GOAL = SkeletonNode()


def act(name: str, *arguments: str, then: SkeletonNode = GOAL) -> SkeletonNode:
    action = SimpleNamespace(name=name, call=GroundCall(name, arguments))
    return SkeletonNode(action, next=then)  # type: ignore[arg-type]


def sense(false: SkeletonNode, true: SkeletonNode) -> SkeletonNode:
    action = SimpleNamespace(name="look", call=None)
    return SkeletonNode(action, on="p", outcomes=(("false", false), ("true", true)))  # type: ignore[arg-type]


def evaluate(root: SkeletonNode, script: Script, share: bool = True) -> tuple[Evaluation, ScriptedServer]:
    server = ScriptedServer(script, {"r": (0.0,), "s": (0.0,)}, {"a": at(0.0), "b": at(1.0)})
    book = RefusalTable(server)  # type: ignore[arg-type]
    evaluator = Evaluator(server, book.record_success, 0, lambda: False, share)  # type: ignore[arg-type]
    return evaluator.evaluate(root, book.start), server


def put(x: float) -> Success:
    return moved(r=(1.0,), a=at(x))


def by_name(evaluation: Evaluation, name: str) -> list[Situation]:
    return [v.situation for v in evaluation.variants if v.node.action is not None and v.node.action.name == name]


def test_branches_meet_with_several_values_of_what_nobody_moves_any_more() -> None:
    last = act("last", "r", "b")
    root = sense(act("left", "r", "a", then=last), act("right", "r", "a", then=last))

    def script(call: GroundCall, situation: Situation, attempt: int) -> Success:
        return (
            put({"left": 0.3, "right": 0.7}.get(call.procedure, 0.0))
            if call.procedure != "last"
            else moved(r=(2.0,))
        )

    evaluation, server = evaluate(root, script)
    (met,) = by_name(evaluation, "last")
    assert met.values("a") == (at(0.3), at(0.7))
    assert met.values("r") == ((1.0,),)
    assert [call for call, _ in server.asked].count("last(r, b)") == 1


def test_branches_do_not_meet_while_what_differs_is_still_to_be_moved() -> None:
    last = act("idle", "s", "b", then=act("last", "r", "a"))
    root = sense(act("left", "r", "a", then=last), act("right", "r", "a", then=last))

    def script(call: GroundCall, situation: Situation, attempt: int) -> Success:
        return put({"left": 0.3, "right": 0.7}[call.procedure]) if call.procedure in ("left", "right") else moved()

    evaluation, _ = evaluate(root, script)
    assert [s.values("a") for s in by_name(evaluation, "last")] == [(at(0.3),), (at(0.7),)]
    assert len(by_name(evaluation, "idle")) == 2


def test_what_is_refused_for_all_values_at_once_is_asked_for_each_way_alone() -> None:
    last = act("last", "r", "b")
    root = sense(act("left", "r", "a", then=last), act("right", "r", "a", then=last))

    def script(call: GroundCall, situation: Situation, attempt: int) -> Success | Refusal:
        if call.procedure != "last":
            return put({"left": 0.3, "right": 0.7}[call.procedure])
        many = len(situation.values("a")) > 1
        return Refusal("collision", "both at once", frozenset({"a"})) if many else moved(r=(2.0,))

    evaluation, server = evaluate(root, script)
    assert not evaluation.refused
    assert [s.values("a") for s in by_name(evaluation, "last")] == [(at(0.3),), (at(0.7),)]


def test_a_refusal_names_the_call_and_where_it_was_asked_and_nothing_after_it_is() -> None:
    root = act("first", "r", "a", then=act("second", "r", "a", then=act("third", "r", "b")))

    def script(call: GroundCall, situation: Situation, attempt: int) -> Success | Refusal:
        return Refusal("no_path", "walled in", frozenset({"a"})) if call.procedure == "second" else put(0.5)

    evaluation, server = evaluate(root, script)
    (refused,) = evaluation.refused
    book = RefusalTable(server)  # type: ignore[arg-type]
    assert str(refused.call) == "second(r, a)"
    assert refused.traces == {book.after(GroundCall("first", ("r", "a")), 0, book.start)}
    assert [call for call, _ in server.asked] == ["first(r, a)", "second(r, a)"]


def test_what_follows_other_outcomes_is_asked_although_one_was_refused() -> None:
    root = sense(act("bad", "r", "a"), act("good", "r", "b"))

    def script(call: GroundCall, situation: Situation, attempt: int) -> Success | Refusal:
        return Refusal("no_path", "walled in") if call.procedure == "bad" else moved()

    evaluation, server = evaluate(root, script)
    assert len(evaluation.refused) == 1
    assert ("good(r, b)", 0) in server.asked


def test_every_variant_leads_to_a_variant_of_each_successor() -> None:
    last = act("last", "r", "b")
    root = sense(act("left", "r", "a", then=last), last)
    evaluation, _ = evaluate(root, lambda call, *_: put(0.2) if call.procedure == "left" else moved())
    for variant in evaluation.variants:
        assert set(variant.following) == ({None} if variant.node.next else {o for o, _ in variant.node.outcomes})
    assert len(by_name(evaluation, "last")) == 2, "the robot stands elsewhere"


def test_nodes_come_before_all_that_follow_them() -> None:
    shared = act("shared", "r", "a")
    root = sense(shared, act("before", "r", "b", then=shared))
    order = in_order(root)
    assert [node.action.name if node.action else "goal" for node in order] == ["look", "before", "shared", "goal"]
