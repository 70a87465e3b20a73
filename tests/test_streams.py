"""Streams of random numbers: the same numbers in numpy, and in compiled kernels."""

import numpy as np
import pytest

from kabo.kinematics import uniform
from kabo.streams import stream_key, uniforms

KEYS = [stream_key("a", 1), stream_key(2**70, 0.5, b"x"), np.uint64(0), np.uint64(2**64 - 1)]


@pytest.mark.parametrize("key", KEYS)
def test_numpy_draws_what_kernels_draw(key):
    drawn = uniforms(key, 3, 50, 4)
    assert drawn.tolist() == [[uniform(key, 3 + i, k) for k in range(4)] for i in range(50)]
    assert drawn.min() >= 0 and drawn.max() < 1


def test_samples_do_not_depend_on_where_drawing_begins():
    key = stream_key("begins")
    assert uniforms(key, 0, 40, 3)[17:].tolist() == uniforms(key, 17, 23, 3).tolist()


def test_keys_tell_types_and_boundaries_apart():
    parts = [("a", "b"), ("ab",), (b"ab",), (1,), (1.0,), ("1",), (), (1, 2), (12,)]
    assert len({int(stream_key(*p)) for p in parts}) == len(parts)
    assert stream_key("pick", 3, 0.5) == stream_key("pick", 3, 0.5)


def test_a_key_is_the_same_on_every_machine():
    assert int(stream_key("kabo", 1, 0.5, b"x")) == 1066468867295882465
