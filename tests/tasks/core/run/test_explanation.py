"""The first stage without successes is found wherever it is; what others made up for is not blamed."""

import pytest

from kabo.tasks.core import (
    Alternatives,
    Failure,
    Fallbacks,
    InitialisationError,
    Limit,
    Merger,
    Result,
    Serial,
    Task,
    TaskError,
    Wrapper,
    connector,
    forward,
    generator,
    monitor,
)


@generator(values=(1, 2))
def offer(scene, properties, seed):
    return [Result(value) for value in properties["values"]]


@forward(among=())
def keep(scene, properties, seed):
    return Result(scene) if scene in properties["among"] else Failure("not wanted")


@connector()
def equal(start, end, properties, seed):
    return Result() if start == end else Failure("differ")


@monitor()
def watch(scene, properties, seed):
    return Result(scene)


def told(*stages):
    task = Task("t", *stages)
    assert task.plan() == []
    return task.explain().text


@pytest.mark.parametrize("kind", [Alternatives, Fallbacks])
def test_a_child_that_others_made_up_for_is_not_to_blame(kind):
    inside = kind("a", keep("never"), Serial("s", keep("always", among=[1, 2])))
    assert told(offer("g"), inside, keep("filter")) == "'filter' found nothing; failed: not wanted 2"


@pytest.mark.parametrize("kind", [Alternatives, Fallbacks])
def test_where_every_child_failed_each_is_told(kind):
    text = told(offer("g"), kind("a", keep("b"), Serial("s", keep("c"))))
    assert text == "'a/b' found nothing; failed: not wanted 2; 'a/s/c' found nothing; failed: not wanted 2"


def test_a_stage_deep_inside_is_named_by_its_path():
    inside = Serial("s", Wrapper("w", Serial("u", keep("fine", among=[1]), keep("never"))))
    assert told(offer("g"), inside) == "'s/w/u/never' found nothing; failed: not wanted 1"


def test_parts_that_never_come_together_are_told_of_their_container():
    text = told(offer("g"), Merger("m", keep("one", among=[1]), keep("two", among=[2])))
    assert text == "'m' found nothing; what its stages found never came together"


def test_monitors_that_were_never_triggered_name_what_they_waited_for():
    text = told(watch("a", "b"), equal("j"), Limit("l", offer("b", values=()), max_solutions=1), keep("b"))
    assert text == "'l/b' found nothing; it gave no answers at all"
    text = told(watch("a", "b"), equal("j"), watch("b", "a"))
    assert text == (
        "'a' monitors 'b', which monitors 'a': none of them can begin; "
        "let 'a' monitor a stage that needs none of these"
    )


def test_a_monitor_of_a_container_that_holds_it_can_never_be_triggered():
    with pytest.raises(InitialisationError, match="monitors 's', which waits for it"):
        Task("t", Serial("s", watch("m", "../s"))).plan()


def test_stages_may_not_come_or_go_while_a_task_is_planned():
    task = Task("t", offer("g"))
    task.plan()
    late = task.add(keep("late"))
    assert task.figures(late).calls == 0 and task.found(late) == ([], [])
    with pytest.raises(TaskError, match=r"added or removed since planning began; reset\(\) it first"):
        task.plan()
    task.reset()
    assert task.plan() == []
