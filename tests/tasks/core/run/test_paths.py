from heapq import heappush

import pytest

from kabo.tasks.core import Failure, Result, Task, Wrapper, connector, generator
from kabo.tasks.core.run import paths

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
def test_paths_of_equal_cost_are_not_all_walked_before_the_first_is_found(cost, monkeypatch):
    """3^13 paths are complete at once; breadth first, this took half a minute."""
    pushed = []
    monkeypatch.setattr(paths, "heappush", lambda heap, item: pushed.append(None) or heappush(heap, item))

    @connector()
    def free(start, end, properties, seed):
        return Result(cost=cost)

    stages = [stage for i in range(SECTIONS) for stage in (three(f"g{i}"), free(f"c{i}"))]
    task = Task("t", *stages, Last("last", sixty("s")))
    assert len(task.plan(max_solutions=100)) == 100
    assert 100 <= len(pushed) < 3 * 100 * 2 * SECTIONS
    assert {round(solution.cost, 6) for solution in task.solutions} == {round(SECTIONS * cost, 6)}
