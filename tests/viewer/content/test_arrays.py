"""Arrays of a view document: what is added is found again, aligned, and once."""

import numpy as np
import pytest

from kabo.viewer.content.arrays import Arrays


def test_arrays_come_back_from_the_block_at_eight_bytes():
    arrays, given = Arrays(), [np.array([1, 2, 3], np.uint16), np.array([[0.5, -1e300]]), np.array([7], np.uint32)]
    references = [arrays.add(each) for each in given]
    types = {"u16": "<u2", "f64": "<f8", "u32": "<u4"}
    for reference, each in zip(references, given, strict=True):
        row = arrays.table[reference["array"]]
        assert row["offset"] % 8 == 0
        assert np.array_equal(
            np.frombuffer(arrays.block, types[row["type"]], row["length"], row["offset"]), each.ravel()
        )


def test_equal_arrays_are_kept_once_but_not_those_of_another_type():
    arrays = Arrays()
    assert arrays.add(np.arange(3, dtype=np.uint16)) == arrays.add(np.arange(3, dtype=np.uint16))
    assert arrays.add(np.arange(3, dtype=np.uint32)) != arrays.add(np.arange(3, dtype=np.uint16))


def test_elements_of_other_types_are_refused():
    with pytest.raises(KeyError):
        Arrays().add(np.arange(3))
