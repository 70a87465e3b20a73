"""Monitoring generators that wait for themselves are told by the stages of the circle; others are not suspected."""

import pytest

from kabo.tasks.core import (
    Alternatives,
    Result,
    Serial,
    Stage,
    Task,
    Wrapper,
    backward,
    connector,
    forward,
    generator,
    monitor,
)
from kabo.tasks.core.model.circles import circle


@generator()
def offer(scene, properties, seed):
    return [Result(1)]


@forward()
def go(scene, properties, seed):
    return Result(scene)


@backward()
def come(scene, properties, seed):
    return Result(scene)


@connector()
def join(start, end, properties, seed):
    return Result()


@monitor()
def watch(scene, properties, seed):
    return Result(scene)


def told(*stages: Stage) -> str | None:
    task = Task("t", *stages)
    task.initialise()
    return circle(task, task.directions)


def test_a_monitor_of_what_comes_after_it_names_every_stage_between():
    grasp = Serial("grasp", come("approach"), Wrapper("pose IK", watch("pose", "../../lift")), go("close"))
    text = told(offer("start"), join("reach"), grasp, go("lift"))
    assert text == (
        "'grasp/pose IK/pose' monitors 'lift', which waits for 'grasp', which waits for 'grasp/approach', "
        "which waits for 'grasp/pose IK', which waits for 'grasp/pose IK/pose': none of them can begin; "
        "let 'grasp/pose IK/pose' monitor a stage that needs none of these"
    )


def test_a_stage_before_it_that_is_planned_backward_from_it_waits_for_it():
    assert "'pose' monitors 'approach', which waits for 'pose'" in str(
        told(offer("start"), join("reach"), come("approach"), watch("pose", "approach"))
    )


def test_a_connector_beside_it_waits_for_it():
    assert "'pose' monitors 'reach', which waits for 'pose'" in str(
        told(offer("start"), join("reach"), watch("pose", "reach"))
    )


def test_two_that_monitor_each_other_are_named_from_the_first_on():
    text = told(offer("start"), join("a"), watch("take", "put"), join("b"), watch("put", "take"))
    assert str(text).startswith("'take' monitors 'put', which monitors 'take': ")


@pytest.mark.parametrize("later", ["other", "then"])
def test_a_later_stage_that_needs_nothing_of_it_is_no_circle(later: str):
    assert told(watch("pose", later), join("reach"), offer("other"), go("then")) is None


def test_one_alternative_that_can_begin_is_enough():
    either = Alternatives("either", watch("again", "../pose"), offer("new"))
    assert told(watch("pose", "either"), join("reach"), either) is None
    never = Alternatives("either", watch("again", "../pose"))
    assert "waits for" in str(told(watch("pose", "either"), join("reach"), never))


def test_a_monitor_outside_the_circle_does_not_hide_it():
    text = told(watch("first", "take"), join("a"), watch("take", "put"), join("b"), watch("put", "take"))
    assert str(text).startswith("'take' monitors 'put'")
