"""Fallbacks go on wherever the child before gave nothing, however deep inside and for whatever reason."""

from itertools import count

import pytest

from kabo.tasks.core import (
    Alternatives,
    Failure,
    Fallbacks,
    Limit,
    Merger,
    Result,
    Serial,
    Task,
    connector,
    forward,
    generator,
    monitor,
    wrapper,
)
from tests.support.counted_calls import calls_made

INFINITE = float("inf")


@generator(values=(1,))
def offer(scene, properties, seed):
    for value in properties["values"]:
        yield Result(value)


@generator()
def naturals(scene, properties, seed):
    for value in count():
        yield Result(value)


@forward(step=1)
def step(scene, properties, seed):
    return Result(scene + properties["step"])


@connector()
def join(start, end, properties, seed):
    return Result()


@wrapper()
def refuse(solution, properties, seed):
    return Failure("no")


@monitor()
def nothing(scene, properties, seed):
    return Failure("nothing")


class First(Merger):
    def merge(self, scene, solutions, properties, seed):
        return Result(solutions[0].end.scene)


def too_dear(solution):
    return INFINITE


def scenes(solutions):
    return [solution.end.scene for solution in solutions]


REFUSED = {
    "a wrapper": lambda: refuse("w", step("a")),
    "a serial container": lambda: Serial("s", step("a"), step("b"), cost=too_dear),
    "alternatives": lambda: Alternatives("o", step("a"), cost=too_dear),
    "alternatives around a container": lambda: Alternatives("o", Serial("s", step("a")), cost=too_dear),
    "a merger": lambda: First("m", step("a"), cost=too_dear),
    "a merger of containers": lambda: First("m", Serial("s", step("a")), step("b"), cost=too_dear),
    "a stage": lambda: step("a", cost=too_dear),
    "fallbacks": lambda: Fallbacks("g", step("a"), step("b"), cost=too_dear),
}


@pytest.mark.parametrize("what", REFUSED)
@pytest.mark.parametrize("lazy", [False, True])
def test_a_state_whose_solutions_were_all_refused_goes_to_the_next_child(what, lazy):
    task = Task("t", offer("g", values=[1, 2]), Fallbacks("f", REFUSED[what](), step("c", step=10)), lazy=lazy)
    assert scenes(task.plan()) == [11, 12]


JOINING = {
    "a wrapper": lambda: refuse("w", join("a")),
    "a serial container": lambda: Serial("s", step("a"), join("b"), cost=too_dear),
    "alternatives": lambda: Alternatives("o", refuse("w", join("a")), refuse("v", join("b"))),
    "fallbacks": lambda: Fallbacks("g", refuse("w", join("a")), refuse("v", join("b"))),
    "a generator between": lambda: Serial("s", join("a"), offer("x"), join("b"), cost=too_dear),
}


@pytest.mark.parametrize("what", JOINING)
def test_a_pair_whose_solutions_were_all_refused_goes_to_the_next_child(what):
    ends = offer("a", values=[1, 2]), offer("b", values=[3, 4])
    task = Task("t", ends[0], Fallbacks("f", JOINING[what](), join("c")), ends[1])
    assert len(task.plan()) == 4


def test_pairs_that_a_container_solved_do_not_hold_up_those_that_fall_back():
    @wrapper()
    def small(solution, properties, seed):
        return Result() if solution.start.scene + solution.end.scene < 5 else Failure("large")

    ends = offer("a", values=[1, 2]), offer("b", values=[3, 4])
    task = Task("t", ends[0], Fallbacks("f", small("w", join("j")), join("c")), ends[1])
    assert len(task.plan()) == 4
    assert task.statistics["f/c"].successes == 3


def test_fallbacks_in_fallbacks_of_generators_wait_for_their_turn():
    task = Task("t", Fallbacks("f", offer("a"), Fallbacks("g", offer("b"), offer("c"))))
    assert len(task.plan()) == 1
    assert task.statistics["f/g/b"].calls == task.statistics["f/g/c"].calls == 0


def test_a_limit_that_is_reached_hands_what_comes_later_to_the_next_child():
    for limited in (Limit("l", step("a")), Serial("s", step("z", step=0), Limit("l", step("a")))):
        task = Task("t", offer("g", values=[1, 2, 3]), Fallbacks("f", limited, step("c", step=10)))
        assert sorted(scenes(task.plan())) == [2, 12, 13]
        assert task.exhausted


def test_a_limit_that_is_reached_hands_other_pairs_to_the_next_child():
    ends = offer("a", values=[1, 2]), offer("b", values=[3])
    task = Task("t", ends[0], Fallbacks("f", Limit("l", join("j")), join("c")), ends[1])
    assert len(task.plan()) == 2


def test_a_monitor_of_what_a_limit_has_closed_gives_way():
    watching = Fallbacks("f", nothing("m", "../l/g"), offer("o", values=[7]))
    task = Task("t", Limit("l", naturals("g"), max_solutions=2), join("j"), watching)
    assert scenes(task.plan(jobs=100)) == [7, 7]
    assert task.exhausted


def test_a_limit_of_none_asks_nothing():
    task = Task("t", Limit("l", naturals("g"), max_solutions=0))
    assert task.plan(jobs=5) == [] and task.exhausted
    assert task.statistics["l/g"].calls == 0


@monitor()
def after(scene, properties, seed):
    yield Result(scene)


def test_a_monitor_inside_a_child_does_not_wait_for_the_state_that_the_child_has() -> None:
    inner = Serial("inner", step("first"), join("join"), refuse("never", after("after", "../first")))
    task = Task("t", offer("offer"), Fallbacks("f", inner, step("instead", step=7)))
    assert [solution.end.scene for solution in task.plan()] == [8]


def test_connecting_costs_the_same_for_each_pair_however_many_there_are():
    """Of every state all pairs are lanes of their own: what looks through all of them for each job is cubic."""

    @generator(count=int)
    def numbers(scene, properties, seed):
        yield from (Result(value) for value in range(properties["count"]))

    @connector()
    def odd(start, end, properties, seed):
        return Result() if (start + end) % 2 else Failure("even")

    @connector()
    def any_pair(start, end, properties, seed):
        return Result()

    def function_calls(count):
        ways = Fallbacks("f", odd("odd"), any_pair("any"))
        task = Task("t", numbers("from", count=count), ways, numbers("to", count=count))
        solutions: list = []
        calls = calls_made(lambda: solutions.extend(task.plan()))
        assert len(solutions) == count**2
        return calls / count**2

    assert function_calls(40) < 1.1 * function_calls(20)


@pytest.mark.parametrize("kind", [Fallbacks, Alternatives])
@pytest.mark.parametrize("flow", ["generate", "forward", "connect"])
@pytest.mark.parametrize("first", [True, False])
def test_a_child_that_is_refuted_before_planning_is_left_out_whatever_its_flow(kind, flow, first):
    made = {"generate": offer, "forward": step, "connect": join}[flow]
    deep = made("in vain")
    never, way = Serial("never", deep), made("way")
    choice = kind("choice", *((never, way) if first else (way, never)))
    around = {"generate": (), "forward": (offer("start"),), "connect": (offer("start"),)}[flow]
    task = Task("choices", *around, choice, *((offer("end"),) if flow == "connect" else ()))
    task.refuted = {deep: Failure("proven")}
    assert len(task.plan()) == 1 and task.exhausted
    assert task.figures(deep).calls == 0 and task.figures(deep).failures == {"proven": 1}


def test_a_task_whose_every_child_is_refuted_runs_nothing():
    first, second = step("first"), step("second")
    task = Task("none", offer("start"), Fallbacks("choice", first, second))
    task.refuted = {first: Failure("proven"), second: Failure("proven, too")}
    assert task.plan() == [] and task.exhausted
    assert all(figures.calls == 0 for figures in task.statistics.values())
