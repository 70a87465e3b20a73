"""Pairs of facts that are never true together."""

import pytest

from kabo.finite_domain import CompiledTask
from kabo.finite_domain.mutexes import compiled_mutexes, plain_mutexes, variables_alone
from tests.finite_domain.stacked import stacked


@pytest.mark.parametrize("twin", [plain_mutexes, compiled_mutexes])
def test_a_thing_that_carries_a_block_is_not_highest(twin):
    n = 4
    compiled = CompiledTask(stacked(n))
    offset = compiled.relaxed.offset
    found = twin(compiled.fact_task, compiled.relaxed.of(compiled.task.initial))
    for b in range(n):
        for x in range(n + 3):
            if x != b:
                assert found.exclude(offset[b] + x, offset[n + x] + 1)
                assert not found.exclude(offset[b] + x, offset[n + x])
            for c in range(n):
                if c != b:
                    assert found.exclude(offset[b] + x, offset[c] + x)
    assert found.allow(compiled.relaxed.of(compiled.task.initial))
    assert not found.allow([offset[0], offset[1], *offset[2:]])


def test_without_work_only_values_of_one_variable_exclude_each_other():
    compiled = CompiledTask(stacked(2))
    alone = variables_alone(compiled.fact_task)
    assert alone.exclude(0, 1)
    assert not alone.exclude(0, 0)
    assert not alone.exclude(0, 5)
