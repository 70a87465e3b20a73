from time import process_time

import pytest

from kabo.tasks.core import Failure, Result, Task, Wrapper, connector, generator

SECTIONS = 13


@generator()
def three(scene, properties, seed):
    for _ in range(3):
        yield Result(0)


@generator()
def sixty(scene, properties, seed):
    for value in range(60):
        yield Result(value)


class Last(Wrapper):
    """Lets the last of sixty through: by then all that comes before is joined."""

    def transform(self, solution, properties, seed):
        return Result(0) if solution.end.scene == 59 else Failure("not yet")


@pytest.mark.parametrize("cost", [0.0, 0.1])
def test_paths_of_equal_cost_are_not_all_walked_before_the_first_is_found(cost):
    """3^13 paths are complete at once; breadth first, this took half a minute."""

    @connector()
    def free(start, end, properties, seed):
        return Result(cost=cost)

    stages = [stage for i in range(SECTIONS) for stage in (three(f"g{i}"), free(f"c{i}"))]
    task = Task("t", *stages, Last("last", sixty("s")))
    began = process_time()
    assert len(task.plan(max_solutions=100)) == 100
    assert process_time() - began < 3.0
    assert {round(solution.cost, 6) for solution in task.solutions} == {round(SECTIONS * cost, 6)}
