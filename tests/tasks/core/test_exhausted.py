"""`exhausted` means that no job can run; what once was lost, and what is complete when planning is told to stop."""

import pytest

from kabo.tasks.core import (
    Connector,
    Failure,
    Fallbacks,
    Flow,
    Generator,
    Propagator,
    Property,
    Result,
    Serial,
    Task,
    connector,
    forward,
    generator,
    monitor,
    propagator,
)

HOW = [{}, {"pruning": False}, {"lazy": True}, {"lazy": True, "pruning": False}, {"depth_first": 12}]


@generator(values=list)
def offer(scene, properties, seed):
    yield from (Result(value) for value in properties["values"])


@forward()
def mark(scene, properties, seed):
    yield Result(f"{scene}'")


class Move(Connector):
    PROPERTIES = {"fails": Property(list, []), "odd": Property(list, [])}

    def mismatch(self, start, end, properties):
        return "odd" if (start, end) in properties["odd"] else None

    def connect(self, start, end, properties, seed):
        either = [start, end, (start, end)]
        return [Failure("no path")] if any(each in properties["fails"] for each in either) else [Result()]


class Twice(Propagator):
    PROPERTIES = {"two": Property(bool, False)}

    def backward(self, scene, properties, seed):
        yield from (Result(scene + letter) for letter in ("ab" if properties["two"] else "a"))


@pytest.mark.parametrize("how", HOW)
def test_what_a_fallback_generated_for_one_state_serves_the_next(how):
    by_way = Serial("by way", mark("p"), Move("m", fails=["grasp1'", "grasp2'"]), offer("g", values=["x"]))
    either = Fallbacks("either", by_way, mark("direct"))
    grasps = Move("reach", fails=["grasp1"]), offer("grasps", values=["grasp1", "grasp2"])
    task = Task("t", offer("now", values=["s"]), Move("a"), offer("via", values=["v"]), *grasps, either, **how)
    assert [s.end.scene for s in task.plan()] == ["grasp2'"] and task.exhausted


@pytest.mark.parametrize("how", HOW)
def test_a_pair_that_is_refused_at_the_end_of_a_walk_lets_the_next_child_try(how):
    join = Move("m", fails=[(f"g{i}", "xaa") for i in (1, 2, 3)], odd=[(f"g{i}", "xab") for i in (1, 2, 3)])
    back = Twice("b1", only=Flow.BACKWARD, two=True), Twice("b2", only=Flow.BACKWARD)
    either = Fallbacks("either", Serial("by way", join, *back, offer("g", values=["x"])), mark("direct"))
    grasps = Move("reach", fails=["g1"]), offer("grasps", values=["g1", "g2", "g3"])
    task = Task("t", offer("now", values=["s"]), Move("a"), offer("via", values=["v"]), *grasps, either, **how)
    assert sorted(s.end.scene for s in task.plan()) == ["g2'", "g3'"] and task.exhausted


@pytest.mark.parametrize("how", HOW)
def test_a_monitor_of_what_only_itself_could_bring_about_is_not_waited_for(how):
    @monitor()
    def after(scene, properties, seed):
        yield Result(scene)

    circle = Serial("circle", Twice("b", only=Flow.BACKWARD), after("m", "b"))
    task = Task("t", Fallbacks("f", circle, offer("g", values=[7])), **how)
    assert [s.end.scene for s in task.plan()] == [7] and task.exhausted


@pytest.mark.parametrize("how", HOW)
def test_a_monitor_of_what_only_the_next_child_could_bring_about_gives_way(how):
    @monitor()
    def after(scene, properties, seed):
        yield Result(scene)

    join = Move("j", fails=["g"])
    task = Task(
        "t", offer("s", values=[1]), join, Fallbacks("f", after("m", "../j"), offer("g", values=["g"])), **how
    )
    assert task.plan() == [] and task.exhausted
    assert task.statistics["f/g"].successes == 1


@monitor()
def once_more(scene, properties, seed):
    if scene < 12:
        yield Result(scene + 10)


@propagator()
def keep(scene, properties, seed):
    yield Result(scene)


@pytest.mark.parametrize("how", HOW)
def test_a_monitor_of_pairs_whose_other_side_never_comes_is_not_waited_for(how):
    circle = Serial("circle", Fallbacks("in", once_more("m1", "../../back"), offer("none", values=[])), Move("j"))
    either = Fallbacks("either", once_more("m2", "../either back/circle/j"), offer("g", values=[1]))
    task = Task("t", Fallbacks("either back", keep("back"), circle), either, **how)
    assert [s.end.scene for s in task.plan()] == [1] and task.exhausted
    assert task.statistics["either/g"].successes == 1


@pytest.mark.parametrize("how", HOW)
def test_a_monitor_of_what_never_begins_is_not_waited_for(how):
    never = Serial("never", offer("n1", values=[1]), Move("j"), once_more("n2", "../../first"))
    by_way = Serial("by way", Move("j2"), once_more("m", "../../which/never"))
    which = Fallbacks("which", offer("g", values=[1]), never)
    task = Task("t", keep("first"), which, Fallbacks("f", by_way, keep("direct")), **how)
    assert [s.end.scene for s in task.plan()] == [1] and task.exhausted


@pytest.mark.parametrize("how", HOW)
def test_what_begins_with_a_later_child_may_feed_the_earlier_one_and_both_count(how):
    fed = once_more("m", "../after")
    task = Task("t", Fallbacks("f", fed, offer("g", values=[1])), keep("after"), **how)
    assert sorted(s.end.scene for s in task.plan()) == [1, 11, 21] and task.exhausted


@pytest.mark.parametrize("how", HOW)
def test_of_fallbacks_that_wait_in_a_circle_the_first_gives_way(how):
    first = Serial("one", Fallbacks("f", once_more("m", "../../two/after"), offer("g", values=[1])), keep("after"))
    second = Serial(
        "two", Fallbacks("f", once_more("m", "../../one/after"), offer("g", values=[2])), keep("after")
    )
    task = Task("t", first, Move("j"), second, **how)
    found = {(s.start.scene, s.end.scene) for s in task.plan()}
    assert found == {(1, 11), (21, 11)} and task.exhausted
    assert task.statistics["two/f/g"].calls == 0


@pytest.mark.parametrize("how", HOW)
def test_a_state_at_a_border_is_one_however_many_ways_lead_to_it(how):
    inside = Serial("inside", offer("a", values=[1]), Move("j"), offer("b", values=[2, 3]))
    task = Task("t", keep("back"), inside, Move("k"), once_more("m", "back"), **how)
    assert sorted(s["inside"].end.scene for s in task.plan()) == [2, 3] and task.exhausted
    assert task.statistics["back"].successes == 1 and task.statistics["m"].successes == 1


class Both(Generator):
    def generate(self, scene, properties, seed):
        return [Result(5, cost=5.0), Result(0, cost=0.0), Result(3, cost=3.0)]


@pytest.mark.parametrize("how", HOW)
def test_fallbacks_take_the_cheapest_state_first(how):
    task = Task("t", Both("g"), Fallbacks("f", mark("a"), mark("b")), **how)
    assert [s.cost for s in task.plan()] == [0.0, 3.0, 5.0]


@pytest.mark.parametrize("inside", [False, True])
def test_a_solution_that_is_complete_when_time_ends_is_returned(inside):
    done = []

    @forward()
    def slow(scene, properties, seed):
        done.append(scene)
        yield Result(scene)

    stages = offer("g", values=[1]), slow("slow")
    task = Task("t", Serial("s", *stages)) if inside else Task("t", *stages)
    assert len(task.plan(stop=lambda: bool(done))) == 1


def test_a_task_that_is_told_to_stop_gives_no_more_than_it_was_asked_for():
    done = []

    @connector()
    def join(start, end, properties, seed):
        done.append(start)
        return Result(), Result(), Result()

    task = Task("t", offer("a", values=[1]), join("j"), offer("b", values=[1]))
    assert len(task.plan(max_solutions=2, stop=lambda: bool(done))) == 2
