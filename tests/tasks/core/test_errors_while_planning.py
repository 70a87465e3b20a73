"""What stage functions, cost terms and mismatches raise reaches the caller, and the task knows where it stands."""

import pytest

from kabo.tasks.core import Result, Serial, Task, TaskError, connector, forward, generator


@generator(values=(1,))
def offer(scene, properties, seed):
    for value in properties["values"]:
        yield Result(value)


class Once:
    """Raises at the call of that number, and never again."""

    def __init__(self, error, number=2):
        self.error, self.left = error, number

    def __call__(self):
        self.left -= 1
        if self.left == 0:
            raise self.error


def stages(once):
    @forward()
    def fragile(scene, properties, seed):
        once()
        return Result(scene)

    @generator()
    def piecemeal(scene, properties, seed):
        for value in (1, 2, 3):
            once()
            yield Result(value)

    return [offer("g", values=[1, 2, 3]), fragile("s")], [piecemeal("s")]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
@pytest.mark.parametrize("lazy", [False, True])
@pytest.mark.parametrize("which", [0, 1])
def test_a_job_that_was_broken_off_is_asked_again_and_nothing_is_lost_or_found_twice(error, lazy, which):
    task = Task("t", *stages(Once(error()))[which], lazy=lazy)
    with pytest.raises(error) as caught:
        task.plan()
    assert getattr(caught.value, "__notes__", ["in stage 's'"]) == ["in stage 's'"]  # from 3.11
    assert sorted(s.end.scene for s in task.plan()) == [1, 2, 3]
    assert task.exhausted


def test_a_stage_that_always_raises_does_so_again_and_leaves_the_solutions_that_are_there():
    @forward()
    def refuse_two(scene, properties, seed):
        if scene == 2:
            raise ZeroDivisionError
        return Result(scene)

    task = Task("t", offer("g", values=[1, 2]), refuse_two("s"))
    for _ in range(3):
        with pytest.raises(ZeroDivisionError):
            task.plan()
        assert [s.end.scene for s in task.solutions] == [1]


@pytest.mark.parametrize("inner", [False, True])
def test_after_an_error_of_a_cost_term_the_task_asks_to_be_reset(inner):
    once = Once(RuntimeError("no cost"), 1)

    def cost(solution):
        once()
        return 1.0

    task = Task("t", Serial("s", offer("g"), cost=cost) if inner else offer("g"), cost=None if inner else cost)
    with pytest.raises(RuntimeError, match="no cost"):
        task.plan()
    with pytest.raises(TaskError, match=r"reset\(\) the task to plan again"):
        task.plan()
    task.reset()
    assert len(task.plan()) == 1


def test_a_mismatch_that_raises_is_told_as_well():
    @connector()
    def join(start, end, properties, seed):
        return Result()

    class Join(join):
        def mismatch(self, start, end, properties):
            raise LookupError("no such joint")

    task = Task("t", offer("a"), Join("j"), offer("b"))
    with pytest.raises(LookupError):
        task.plan()
    with pytest.raises(TaskError, match="broke planning off"):
        task.plan()


def test_a_stage_function_may_not_change_the_properties_that_other_jobs_share():
    @forward(count=1)
    def counting(scene, properties, seed):
        properties["count"] += 1
        return Result(scene)

    with pytest.raises(TypeError, match="does not support item assignment"):
        Task("t", offer("g"), counting("s")).plan()


def test_a_cost_that_is_no_number_is_a_failure():
    task = Task("t", offer("g", cost=lambda solution: float("nan")))
    assert task.plan() == [] and task.exhausted
    assert task.found(task.children[0])[1][0].comment == "the cost is no number"
