"""Numbers and words as exports write them, so that every reader finds the same value."""

import re

import numpy as np

DECIMALS = 9  # of setpoints [rad, m or s]
_NUMBER = re.compile(r"-?[0-9]+\.[0-9]+")  # as `number` writes them


def number(value: float) -> str:
    """A number without an exponent, which YAML, URScript and tables all read: the shortest text of this value."""
    return str(np.format_float_positional(value + 0.0, trim="0"))


def rounded(value: float) -> str:
    """A number with nine decimals at most."""
    return number(round(float(value), DECIMALS))


def one_line(text: str) -> str:
    """Text without line breaks and control characters."""
    return "".join(each if each.isprintable() else " " for each in text)


def comparable(text: str) -> str:
    """The same text for the same number, however many zeros end it; all other text as it is."""
    return repr(float(text)) if _NUMBER.fullmatch(text) else text


def lines_of(text: str) -> list[str]:
    """The lines that say something, without indentation."""
    return [line for line in (each.strip(" \t\r") for each in text.split("\n")) if line]
