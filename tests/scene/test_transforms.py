"""Transforms and quaternions: round trips, and one form for each rotation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.scene.transforms import flat, inverse, quaternion, rotation, rounded, transform, unflat

NUMBERS = st.floats(-1.0, 1.0)
QUATERNIONS = st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS).filter(lambda q: np.linalg.norm(q) > 1e-3)


@given(q=QUATERNIONS)
def test_a_rotation_keeps_its_quaternion(q: tuple[float, float, float, float]) -> None:
    turned = rotation(q)
    assert turned @ turned.T == pytest.approx(np.eye(3), abs=1e-12)
    assert rotation(quaternion(turned)) == pytest.approx(turned, abs=1e-12)


@given(q=QUATERNIONS)
def test_a_quaternion_and_its_opposite_have_one_form(q: tuple[float, float, float, float]) -> None:
    opposite = tuple(-x for x in q)
    assert quaternion(rotation(q)) == pytest.approx(quaternion(rotation(opposite)), abs=1e-9)


@given(q=QUATERNIONS, p=st.tuples(NUMBERS, NUMBERS, NUMBERS))
def test_inverse_and_flat_undo_themselves(q: tuple[float, ...], p: tuple[float, ...]) -> None:
    pose = transform(p, q)
    assert pose @ inverse(pose) == pytest.approx(np.eye(4), abs=1e-12)
    assert np.array_equal(unflat(flat(pose)), pose)


def test_rounded_numbers_have_no_negative_zero() -> None:
    assert str(rounded([-1e-12, -0.25], 9)) == "(0.0, -0.25)"
