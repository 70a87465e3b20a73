"""Blends are as large as their proofs allow."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.motion import Blended
from kabo.tasks.robots.motion.smoothing import MIN_TRIM_SHARE, TRIM_RESOLUTION, _largest, _rounded

CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0]])
DEVIATION = 0.05


@dataclass(frozen=True)
class Narrow:
    """A route with things near its corners: blends longer than `room` (m,) are refused."""

    room: np.ndarray

    @property
    def corners(self) -> np.ndarray:
        return CORNERS

    def refused(self, path: Blended) -> list[int]:
        return [i for i in (1, 2) if path.trims[i] > self.room[i]]


@given(shares=st.lists(st.sampled_from([0.01, 0.1, 0.3, 0.49, 0.7, 0.97, 2.0]), min_size=2, max_size=2))
def test_a_blend_is_the_largest_that_is_proven_but_for_a_sixteenth(shares: list[float]) -> None:
    """Whatever is in the way of the other one."""
    whole = _rounded(Narrow(np.full(4, 9.0)), DEVIATION, np.ones(4)).trims  # type: ignore[arg-type]
    room = whole * [1.0, *shares, 1.0]
    found = _largest(Narrow(room), DEVIATION, np.ones(4))  # type: ignore[arg-type]
    trims = _rounded(Narrow(room), DEVIATION, found).trims  # type: ignore[arg-type]
    for i in (1, 2):
        assert trims[i] <= room[i]
        reachable = min(1.0, room[i] / whole[i])
        assert found[i] >= reachable - TRIM_RESOLUTION - 1e-9 or (found[i] == 0.0 and reachable < MIN_TRIM_SHARE)


def test_without_anything_in_the_way_nothing_shrinks() -> None:
    assert _largest(Narrow(np.full(4, 9.0)), DEVIATION, np.ones(4)) == pytest.approx(np.ones(4))  # type: ignore[arg-type]
