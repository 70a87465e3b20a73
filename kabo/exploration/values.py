"""Which numbers and texts explorations accept, and how messages show a value that they refuse."""

import reprlib
from numbers import Integral, Real
from typing import Any

from kabo.exploration.limits import LARGEST_NUMBER

A_SEED = "a whole number of 64 bits"
A_NUMBER = f"a finite number up to {LARGEST_NUMBER:g}"


def finite(value: Any) -> float | None:
    """The value as a number, or None if it is no finite number up to LARGEST_NUMBER."""
    if isinstance(value, bool) or not isinstance(value, Real):  # numpy's truth values are no Real
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if abs(number) <= LARGEST_NUMBER else None


def is_seed(value: Any) -> bool:
    """Whether the value is a whole number of 64 bits."""
    return isinstance(value, Integral) and not isinstance(value, bool) and -(2**63) <= int(value) < 2**63


def is_text(value: Any) -> bool:
    """Whether the value is a text that can be encoded in UTF-8."""
    if not isinstance(value, str):
        return False
    try:
        value.encode()
    except UnicodeEncodeError:  # a lone surrogate
        return False
    return True


def shown(value: Any) -> str:
    """The value as messages show it: short, however long or deeply nested it is."""
    try:
        return reprlib.repr(value)
    except ValueError:  # Python converts no whole number of more than 4,300 digits
        return "a very long number"
