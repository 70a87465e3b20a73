"""With any number of worker processes a task has the same solutions in the same order; they only come sooner."""

import multiprocessing
import os
import time

import pytest

from kabo.tasks.core import Result, Task, connector, forward, generator
from kabo.tasks.core.run.workers import StageWorkers
from tests.support.random_tasks import Rich, Trees, canonical


@pytest.fixture(autouse=True)
def all_jobs_are_sent(monkeypatch):
    """Jobs of stages that take no time are sent as well."""
    monkeypatch.setattr("kabo.tasks.core.run.workers.MIN_SECONDS_TO_SEND", 0.0)


@pytest.fixture(autouse=True)
def nobody_is_left():
    yield
    for child in multiprocessing.active_children():
        child.join(5)
    assert multiprocessing.active_children() == []


def planned(kind, seed, workers, **how):
    task = kind(seed, monitors=True, depth=3).task()
    for name, value in how.items():
        setattr(task, name, value)
    try:
        found = [(canonical(s), s.number) for s in task.plan(jobs=300, workers=workers)]
        return found, task.exhausted, {path: figures.calls for path, figures in task.statistics.items()}
    finally:
        task.close()


@pytest.mark.parametrize("how", [{}, {"lazy": True}, {"depth_first": 20}], ids=["rounds", "lazily", "depth first"])
@pytest.mark.parametrize(("kind", "seed"), [(Trees, 3), (Trees, 14), (Trees, 22), (Rich, 118), (Rich, 192)])
def test_any_number_of_workers_finds_the_same_in_the_same_order(kind, seed, how):
    alone = planned(kind, seed, None, **how)
    assert planned(kind, seed, 2, **how) == alone
    assert planned(kind, seed, 4, **how) == alone


@generator()
def naturals(scene, properties, seed):
    yield from (Result(value) for value in range(12))


@forward()
def twice(scene, properties, seed):
    yield Result(2 * scene, comment=str(os.getpid()))


def test_turns_with_and_without_workers_neither_skip_nor_repeat_anything():
    task = Task("t", naturals("g"))
    for wanted, workers in ((3, None), (6, 2), (9, None), (12, 3)):
        task.plan(max_solutions=wanted, workers=workers)
    assert [s.end.scene for s in task.solutions] == list(range(12))
    task.close()


def test_a_call_executes_no_more_jobs_than_it_may():
    task = Task("t", naturals("g"), twice("a"), twice("b"), twice("c"))
    done = []
    for most in (1, 3, 1, 1, 2, 60):
        task.plan(jobs=most, workers=2)
        done.append(sum(figures.calls for figures in task.statistics.values()))
    assert [b - a for a, b in zip([0, *done], done, strict=False)][:-1] == [1, 3, 1, 1, 2]
    assert [s.end.scene for s in task.plan(workers=2)] == [8 * value for value in range(12)]
    task.close()


def test_workers_live_as_long_as_the_task_and_work():
    @connector()
    def join(start, end, properties, seed):
        return Result(comment=str(os.getpid()))

    task = Task("t", naturals("from"), join("j"), naturals("to"))
    seen = set()
    for wanted in range(1, 60):
        task.plan(max_solutions=wanted, workers=2)
        seen |= {child.pid for child in multiprocessing.active_children()}
    assert len(seen) == 1
    assert {part.comment for s in task.solutions for part in s.parts} >= {str(pid) for pid in seen}
    task.reset()
    assert multiprocessing.active_children() == []


def test_an_error_in_a_worker_names_the_stage_and_ends_all_processes():
    @forward()
    def broken(scene, properties, seed):
        if scene > 3:
            raise ZeroDivisionError("inside")
        return Result(scene)

    @connector()
    def join(start, end, properties, seed):
        return Result()

    task = Task("t", naturals("g"), broken("s"), join("j"), naturals("to"))
    for _ in range(2):  # it was put back
        with pytest.raises(ZeroDivisionError, match="inside") as caught:
            task.plan(workers=2)
        assert "in stage 's'" in getattr(caught.value, "__notes__", ["in stage 's'"])  # from 3.11
        assert multiprocessing.active_children() == []


def test_scenes_that_cannot_travel_stay_here():
    @generator()
    def unsendable(scene, properties, seed):
        for _ in range(4):
            yield Result(lambda: 0)

    @connector()
    def join(start, end, properties, seed):
        return Result()

    task = Task("t", unsendable("g"), join("j"), naturals("to"))
    assert len(task.plan(lambda: 0, workers=2)) == 48
    task.close()


def test_a_worker_that_has_died_is_done_without():
    @connector()
    def join(start, end, properties, seed):
        return Result(cost=abs(start - end))

    def costs(workers):
        task = Task("t", naturals("g"), join("j"), naturals("to"))
        for wanted in range(1, 145):
            task.plan(max_solutions=wanted, workers=workers)
            for child in multiprocessing.active_children() if wanted == 40 else ():
                child.kill()
                child.join()
        task.close()
        return [s.cost for s in task.solutions]

    assert costs(2) == costs(None)


def test_a_stage_may_plan_a_task_with_workers_of_its_own_in_a_worker():
    @forward()
    def nested(scene, properties, seed):
        inner = Task("inner", naturals("g"), twice("t"))
        found = len(inner.plan(workers=2, max_solutions=2)) + scene
        inner.close()
        return Result(found)

    task = Task("t", naturals("g"), nested("n"))
    assert [s.end.scene for s in task.plan(workers=2, max_solutions=3)] == [2, 3, 4]
    task.close()


def test_only_stages_whose_jobs_take_long_are_sent():
    @forward()
    def quick(scene, properties, seed):
        return Result(scene, comment=str(os.getpid()))

    @forward()
    def slow(scene, properties, seed):
        time.sleep(0.004)
        return Result(scene, comment=str(os.getpid()))

    @connector()
    def join(start, end, properties, seed):
        return Result()

    task = Task("t", naturals("g"), quick("q"), slow("s"), join("j"), naturals("to"))
    task._workers = StageWorkers(task._run(None), 2, min_seconds=0.003)
    task.plan(workers=2, max_solutions=100)
    where = {name: {s.comment for s in task.found(task.find(name))[0]} for name in "qs"}
    assert where["q"] == {str(os.getpid())} and len(where["s"]) >= 1
    task.close()
