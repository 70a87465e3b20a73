"""What a number and a text of an exploration is, and how messages show what is neither."""

import reprlib
from numbers import Integral, Real
from typing import Any

import numpy as np

LARGEST = 1e100  # of all numbers: their squares are finite
A_SEED = "a whole number of 64 bits"
A_NUMBER = f"a finite number up to {LARGEST:g}"


def finite(value: Any) -> float | None:
    """The value as a number, or None if it is no finite number up to LARGEST."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Real):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if abs(number) <= LARGEST else None


def is_seed(value: Any) -> bool:
    """Whether the value is a whole number of 64 bits."""
    return isinstance(value, Integral) and not isinstance(value, bool) and -(2**63) <= int(value) < 2**63


def is_text(value: Any) -> bool:
    """Whether the value is a text that a file can hold."""
    if not isinstance(value, str):
        return False
    try:
        value.encode()
    except UnicodeEncodeError:  # half of a pair of surrogates
        return False
    return True


def shown(value: Any) -> str:
    """The value as messages show it: short, however long or deeply nested it is."""
    try:
        return reprlib.repr(value)
    except ValueError:  # Python writes no number of more than 4,300 digits
        return "a very long number"
