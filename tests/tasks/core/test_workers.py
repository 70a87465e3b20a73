import pytest

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
