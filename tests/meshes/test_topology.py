"""Connectivity of meshes beside what a search finds that nobody could get wrong."""

import numpy as np
import pytest

from kabo.meshes.topology import labels


def searched(size: int, first: np.ndarray, second: np.ndarray) -> list[int]:
    """The component numbers by a search from each node in turn."""
    linked: list[set[int]] = [set() for _ in range(size)]
    for a, b in zip(first.tolist(), second.tolist(), strict=True):
        linked[a].add(b)
        linked[b].add(a)
    found, count = [-1] * size, 0
    for start in range(size):
        waiting = [start] if found[start] < 0 else []
        while waiting:
            node = waiting.pop()
            if found[node] < 0:
                found[node] = count
                waiting += linked[node]
        count += found[start] == count
    return found


@pytest.mark.parametrize("seed", range(200))
def test_components_are_those_of_a_search_in_the_order_of_their_first_nodes(seed: int) -> None:
    draw = np.random.default_rng(seed)
    size, links = int(draw.integers(1, 60)), int(draw.integers(0, 80))
    first, second = draw.integers(0, size, (2, links))
    assert labels(size, first, second).tolist() == searched(size, first, second)


@pytest.mark.parametrize("order", [1, -1])
def test_a_long_chain_is_one_component(order: int) -> None:
    nodes = np.arange(100_000)[::order]
    assert not labels(100_000, nodes[:-1], nodes[1:]).any()
