import multiprocessing

import pytest

from kabo.tasks.core import Result, Task, TaskError, forward, generator
from tests.random_tasks import Trees, canonical


def planned(seed, workers):
    task = Trees(seed, monitors=True).task()
    return [canonical(s) for s in task.plan(jobs=400, workers=workers)], task.exhausted


@pytest.mark.parametrize("seed", [3, 14, 22])
def test_any_number_of_workers_finds_the_same_in_the_same_order(seed):
    one, two = planned(seed, 1), planned(seed, 2)
    assert one == two
    alone, exhausted = planned(seed, None)
    if exhausted and one[1]:
        assert sorted(map(repr, alone)) == sorted(map(repr, one[0]))


@generator()
def naturals(scene, properties, seed):
    yield from (Result(value) for value in range(12))


def test_turns_with_and_without_workers_neither_skip_nor_repeat_anything():
    task = Task("t", naturals("g"))
    for wanted, workers in ((3, None), (6, 1), (9, None), (12, 2)):
        task.plan(max_solutions=wanted, workers=workers)
    assert [s.end.scene for s in task.solutions] == list(range(12))


def test_rounds_execute_no_more_jobs_than_the_call_may():
    @forward()
    def twice(scene, properties, seed):
        return Result(2 * scene)

    task = Task("t", naturals("g"), twice("a"), twice("b"), twice("c"))
    done = []
    for most in (1, 3, 1, 1, 2, 40):
        task.plan(jobs=most, workers=1)
        done.append(sum(figures.calls for figures in task.statistics.values()))
    assert [b - a for a, b in zip([0, *done], done, strict=False)][:-1] == [1, 3, 1, 1, 2]
    assert [s.end.scene for s in task.plan(workers=1)] == [8 * value for value in range(12)]


def test_a_round_cut_short_goes_on_behind_the_stage_where_it_ended():
    @generator()
    def endless(scene, properties, seed):
        value = 0
        while True:
            yield Result(value)
            value += 1

    @forward()
    def same(scene, properties, seed):
        return Result(scene)

    task = Task("t", endless("g"), same("a"), same("b"))
    for _ in range(12):
        task.plan(max_solutions=1, jobs=1, workers=1)
    assert len(task.solutions) == 1, "the generator took every call for itself"


def test_an_error_in_a_worker_names_the_stage_and_ends_all_processes():
    @forward()
    def broken(scene, properties, seed):
        raise ZeroDivisionError("inside")

    task = Task("t", naturals("g"), broken("s"))
    with pytest.raises(ZeroDivisionError, match="inside") as caught:
        task.plan(workers=2)
    assert "in stage 's'" in getattr(caught.value, "__notes__", ["in stage 's'"])  # from 3.11
    assert multiprocessing.active_children() == []
    with pytest.raises(ZeroDivisionError):
        task.plan(workers=2)  # it was put back


def test_scenes_that_cannot_travel_are_a_readable_error():
    @generator()
    def unsendable(scene, properties, seed):
        return Result(lambda: 0)

    with pytest.raises(TaskError, match=r"'g' is given, or gives, cannot be sent .* plan without workers"):
        Task("t", unsendable("g")).plan(workers=1)
    with pytest.raises(TaskError, match="'g' is given, or gives, cannot be sent"):
        Task("t", naturals("g")).plan(lambda: 0, workers=1)
    assert multiprocessing.active_children() == []


def test_a_stage_may_plan_a_task_with_workers_of_its_own_in_a_worker():
    @forward()
    def nested(scene, properties, seed):
        return Result(len(Task("inner", naturals("g")).plan(workers=1, max_solutions=2)) + scene)

    task = Task("t", naturals("g"), nested("n"))
    assert [s.end.scene for s in task.plan(workers=1, max_solutions=3)] == [2, 3, 4]
