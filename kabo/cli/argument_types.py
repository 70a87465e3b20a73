"""Types of arguments: functions that convert the text of an argument, or raise an error with what was expected."""

import argparse
import math
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from kabo.errors import Diagnostic, InputError


def _number(kind: Callable[[str], float], least: float, wanted: str) -> Callable[[str], Any]:
    """A reader of finite numbers of `kind` that are at least `least`; a float must also differ from 0."""

    def parsed(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value >= least) or (kind is float and value == 0):
            raise argparse.ArgumentTypeError(f"{text!r} is not {wanted}")
        return value

    return parsed


def output_file(text: str) -> Path:
    """The path of a file to write; its folder must exist, which is checked before the work begins."""
    path = Path(text)
    try:
        fits = path.parent.is_dir() and not path.is_dir()
    except (OSError, ValueError):  # too long a name, or a null byte in it
        fits = False
    if not fits:
        raise argparse.ArgumentTypeError(f"{text!r} is no file in a folder that exists")
    return path


def require_writable(path: Path) -> None:
    """Checks that a file can be written: creates an empty file in the same folder and removes it again.

    Raises:
        InputError: the file cannot be written; the message gives the reason.
    """
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", suffix=".part" + 16 * "0"):
            pass
    except OSError as error:
        hint = "name another file to write"
        raise InputError([Diagnostic(str(path), 1, 1, f"cannot be written: {error.strerror}", hint)]) from None


def whole(least: int) -> Callable[[str], Any]:
    """A function that converts text to a whole number, and rejects numbers below `least`."""
    return _number(int, least, f"a whole number from {least} on")


natural = whole(0)
positive = _number(float, 0.0, "a number above 0")


def bounded(least: float, most: float, unit: str) -> Callable[[str], float]:
    """A function that converts text to a number above 0, and rejects numbers below `least` or above `most`."""

    def parsed(text: str) -> float:
        value = float(positive(text))
        if not least <= value <= most:
            wanted = "a length" if unit == "m" else "a number"
            end = "on" if most == math.inf else f"to {most:g} {unit}".rstrip()
            raise argparse.ArgumentTypeError(f"{text!r} is not {wanted} from {least:g} {end}")
        return value

    return parsed
