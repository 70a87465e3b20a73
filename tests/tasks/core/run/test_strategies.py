"""Strategies: depth first for the first solution, then round robin; which solutions there are stays the same."""

from collections import Counter

import pytest

from kabo.tasks.core import Failure, Merger, Result, Serial, Task, connector, forward, generator, monitor, wrapper
from tests.support.random_tasks import Trees, canonical


@generator()
def grasps(scene, properties, seed):
    yield from (Result(("grasp", value)) for value in range(8))


@connector()
def carry(start, end, properties, seed):
    return Result() if start[1] == end[1] else Failure("held another way")


@monitor()
def places(scene, properties, seed):
    yield from (Result(("place", scene[1], turn)) for turn in range(8))


@wrapper(most=int)
def configurations(solution, properties, seed):
    for _ in range(properties["most"]):
        yield Result()


def pouring(good, most, **how):
    """Of eight grasps one can be poured with; each place is for one grasp."""

    @forward()
    def pour(scene, properties, seed):
        return Result(scene) if scene[1] == good else Failure("spilt")

    place = configurations("place", places("poses", monitors="../grasp"), most=most)
    return Task("t", grasps("grasp"), pour("pour"), carry("carry"), place, **how)


@pytest.mark.parametrize("most", [1, 16])
def test_nothing_is_sampled_for_a_grasp_that_is_of_no_use(most):
    task = pouring(5, most, depth_first=100)
    assert len(task.plan(max_solutions=1)) == 1
    calls = {path: figures.calls for path, figures in task.statistics.items()}
    assert calls["grasp"] == calls["pour"] == 6
    assert calls["place/poses"] <= 2, "places were sampled for grasps that cannot be poured with"
    rounds = pouring(5, most)
    rounds.plan(max_solutions=1)
    assert sum(calls.values()) < sum(figures.calls for figures in rounds.statistics.values())


def test_after_so_many_jobs_rounds_go_on_with_what_was_found():
    task = pouring(5, 2, depth_first=5)
    assert len(task.plan()) == len(pouring(5, 2).plan()) == 16


def test_another_target_comes_before_another_configuration_for_the_same():
    task = Task("t", configurations("inverse", grasps("poses"), most=16), depth_first=100)
    task.plan(jobs=2)
    assert [s.end.scene for s in task.plan(jobs=0)] == [("grasp", 0)]

    @forward()
    def last(scene, properties, seed):
        return Result(scene) if scene[1] == 7 else Failure("not this one")

    task = Task("t", configurations("inverse", grasps("poses"), most=16), last("last"), depth_first=100)
    task.plan(max_solutions=1)
    assert task.statistics["inverse"].calls == 8


@pytest.mark.parametrize("monitors", [False, True])
def test_any_depth_finds_the_same_in_the_end(monitors):
    compared = 0
    for seed in range(120):
        found = []
        for depth in (0, 7, 10_000):
            task = Trees(seed, monitors=monitors).task()
            task.depth_first = depth
            solutions = Counter(map(canonical, task.plan(jobs=600)))
            found.append(solutions if task.exhausted else None)
        if None not in found:
            compared += bool(found[0])
            assert found[0] == found[1] == found[2], seed
    assert compared > 5


@connector()
def join(start, end, properties, seed):
    return Result()


@generator()
def here(scene, properties, seed):
    yield Result(0)


class Both(Merger):
    """Where both children end."""

    def merge(self, scene, solutions, properties, seed):
        return Result(tuple(solution.end.scene for solution in solutions))


def test_all_children_of_a_merger_vary_in_the_first_solutions():
    def child(name):
        return Serial(name, join("go"), grasps("grasp"))

    task = Task("t", here("start"), Both("at once", child("one"), child("other")), depth_first=100)
    first, second = zip(*(solution.end.scene for solution in task.plan(max_solutions=9)), strict=True)
    assert len(set(first)) == len(set(second)) == 3
