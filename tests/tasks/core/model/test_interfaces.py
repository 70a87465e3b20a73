import pytest

from kabo.tasks.core import (
    Alternatives,
    Connector,
    Fallbacks,
    Flow,
    Generator,
    InitialisationError,
    Merger,
    Monitor,
    Propagator,
    Result,
    Serial,
    Task,
    TaskError,
    Wrapper,
)


class Begin(Generator):
    def generate(self, scene, properties, seed):
        return Result(0)


class Go(Propagator):
    def forward(self, scene, properties, seed):
        return Result(scene + 1)

    def backward(self, scene, properties, seed):
        return Result(scene - 1)


class OnlyForward(Propagator):
    def forward(self, scene, properties, seed):
        return Result(scene + 1)


class Join(Connector):
    def connect(self, start, end, properties, seed):
        return Result()


class Watch(Monitor):
    def generate(self, scene, properties, seed):
        return Result(scene)


def flows(task):
    task.initialise()
    return {stage.path: flow for stage, flow in task.directions.items()}


def errors(task):
    with pytest.raises(InitialisationError) as caught:
        task.initialise()
    return caught.value.errors


def test_what_stands_before_a_generator_runs_backward_and_what_follows_forward():
    found = flows(Task("t", Go("a"), Begin("g"), Go("b"), Join("c"), Go("d"), Begin("h")))
    assert found["a"] is found["d"] is Flow.BACKWARD
    assert found["b"] is Flow.FORWARD
    assert found["c"] is Flow.CONNECT


def test_containers_are_inferred_from_what_they_hold():
    assert Serial("s", Go("a"), Go("b")).flows == {Flow.FORWARD, Flow.BACKWARD}
    assert Serial("s", Go("a"), OnlyForward("b")).flows == {Flow.FORWARD}
    assert Serial("s", Go("a"), Begin("g")).flows == {Flow.GENERATE}
    assert Serial("s", Go("a"), Join("c"), Go("b")).flows == {Flow.CONNECT}
    assert Serial("s", Go("a"), Join("c"), Begin("g")).flows == {Flow.FORWARD}
    assert Alternatives("s", Go("a"), OnlyForward("b")).flows == {Flow.FORWARD}
    assert Wrapper("w", Begin("g")).flows == {Flow.GENERATE}
    assert Merger("m", Begin("g")).flows == frozenset()


def test_two_generators_and_two_connectors_side_by_side_never_fit():
    assert any("both generate" in e for e in errors(Task("t", Begin("a"), Begin("b"))))
    found = errors(Task("t", Begin("a"), Join("c"), Join("d"), Begin("b")))
    assert any("two connectors (→ ←) meet" in e for e in found)


def test_every_error_is_collected_with_arrows_and_a_hint_in_the_tree_of_the_whole_task():
    task = Task("t", OnlyForward("x"), Begin("g"), Join("c"), OnlyForward("move to"))
    task.add(Watch("w", "nowhere"))
    with pytest.raises(InitialisationError) as caught:
        task.initialise()
    text = str(caught.value)
    assert len(caught.value.errors) == 3
    assert "'x' (→ →) would have to run backward (← ←) here" in text
    assert "'move to' (→ →) would have to run backward" in text
    assert "monitors 'nowhere', but there is no such stage" in text
    assert "generator" in text and "[Begin]" in text


def test_a_monitor_of_a_path_that_fits_two_stages_is_told_to_have_the_stage_itself():
    first, second = Go("move"), Go("move")
    (error,) = errors(Task("t", Begin("g"), first, second, Join("c"), Watch("w", "move")))
    assert error == (
        "stage 'w' monitors 'move', but there are 2 stages of that name; rename one, or give the stage itself"
    )
    first, second = Go("move"), Go("move")
    Task("t", Begin("g"), first, second, Join("c"), Watch("w", second)).initialise()


def test_a_stage_after_a_connector_without_a_generator_is_told_to_have_one():
    (error,) = errors(Task("t", Begin("g"), Join("c"), Go("move to")))
    assert error.startswith("'move to'") and "add a generator beside it" in error


def test_empty_containers_and_wrappers_of_nothing_are_refused():
    assert errors(Task("t")) == ("container 't' is empty",)
    assert "holds 0 stages, not one" in errors(Task("t", Begin("g"), Wrapper("w")))[0]


def test_a_failed_initialisation_changes_nothing_and_the_other_direction_may_follow():
    task = Task("t", Begin("g"), Go("a"))
    task.initialise()
    before = dict(task.directions)
    wrong = task.add(Begin("h"))
    with pytest.raises(InitialisationError):
        task.initialise()
    assert task.directions == before
    task.remove(wrong)
    go = task.remove(task.children[1])
    task.add(go, 0)
    assert flows(task)["a"] is Flow.BACKWARD


def test_a_direction_may_be_ruled_out():
    assert "'a' (→ →) would have to run backward" in errors(Task("t", Go("a", only=Flow.FORWARD), Begin("g")))[0]


def test_children_are_put_in_at_an_index_and_found_by_path():
    inner = Serial("inner", Go("x"))
    task = Task("t", Begin("a"), inner)
    task.add(Go("b"), -1)
    assert [child.name for child in task.children] == ["a", "b", "inner"]
    assert task.find("inner/x") is inner.children[0]
    assert task.find("x") is None
    first = task.add(Go("b"), 0)
    assert task.find("b") is first


def test_a_stage_has_one_parent_and_no_container_holds_itself():
    stage = Go("x")
    Serial("a", stage)
    with pytest.raises(TaskError, match="one parent"):
        Serial("b", stage)
    with pytest.raises(TaskError, match="'c' holds stages, and 'pick' is none"):
        Serial("c", "pick")
    outer = Serial("outer", inner := Serial("inner"))
    with pytest.raises(TaskError, match="cannot contain itself"):
        inner.add(outer)


def test_fallbacks_whose_children_differ_in_kind_do_not_fit():
    found = errors(Task("t", Begin("g"), Fallbacks("f", Go("a"), Begin("h"))))
    assert any("'f/h'" in e or "'f'" in e for e in found)
