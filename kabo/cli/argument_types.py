"""The values of arguments: what reads a text from the command line, and says what it should have been."""

import argparse
import math
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from kabo.errors import Diagnostic, InputError


def _number(kind: Callable[[str], float], least: float, wanted: str) -> Callable[[str], Any]:
    """Reads a finite number of a kind, from `least` on; a float 0 is refused."""

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
    """A file to write, in a folder that exists: checked before the work, not after it."""
    path = Path(text)
    try:
        fits = path.parent.is_dir() and not path.is_dir()
    except (OSError, ValueError):  # too long a name, or a null byte in it
        fits = False
    if not fits:
        raise argparse.ArgumentTypeError(f"{text!r} is no file in a folder that exists")
    return path


def require_writable(path: Path) -> None:
    """Checks that a file can be written, by writing an empty one beside it and removing that again.

    Raises:
        InputError: it cannot be written; says why.
    """
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", suffix=".part" + 16 * "0"):
            pass
    except OSError as error:
        hint = "name another file to write"
        raise InputError([Diagnostic(str(path), 1, 1, f"cannot be written: {error.strerror}", hint)]) from None


def whole(least: int) -> Callable[[str], Any]:
    """Reads a whole number from a least one on."""
    return _number(int, least, f"a whole number from {least} on")


natural = whole(0)
positive = _number(float, 0.0, "a number above 0")


def bounded(least: float, most: float, unit: str) -> Callable[[str], float]:
    """Reads a number above 0 within two bounds."""

    def parsed(text: str) -> float:
        value = float(positive(text))
        if not least <= value <= most:
            wanted = "a length" if unit == "m" else "a number"
            end = "on" if most == math.inf else f"to {most:g} {unit}".rstrip()
            raise argparse.ArgumentTypeError(f"{text!r} is not {wanted} from {least:g} {end}")
        return value

    return parsed
