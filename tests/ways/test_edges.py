"""Pieces of a path: in which order they are looked at, and how far a step goes."""

import numpy as np

from kabo.ways.edges import FreeSpace, dyadic_levels, stepped


def test_the_end_comes_first_then_the_middle_then_the_quarters():
    assert [list(level) for level in dyadic_levels(1)] == [[1.0]]
    assert [list(level) for level in dyadic_levels(4)] == [[1.0], [0.5], [0.25, 0.75]]


def test_no_gap_is_wider_than_the_pieces_asked_for():
    for pieces in range(1, 40):
        shares = np.sort(np.concatenate([[0.0], *dyadic_levels(pieces)]))
        assert np.diff(shares).max() <= 1.0 / pieces + 1e-12


def test_a_step_ends_at_the_target_or_at_its_reach():
    target = np.array([3.0, 4.0])
    assert stepped(np.zeros(2), target, 5.0) is target
    assert np.allclose(stepped(np.zeros(2), target, 1.0), [0.6, 0.8])


def test_a_configuration_that_is_hit_spares_the_proof():
    def never(q0, q1):
        raise AssertionError("the proof was asked")

    space = FreeSpace(never, lambda Q: np.array([4 if q[0] > 0.4 else -1 for q in Q]))
    assert not space.is_free(np.zeros(1), np.ones(1))
    assert dict(space.hits) == {4: 1}
