"""Types of arguments: functions that convert the text of an argument, or raise an error with what was expected."""

import argparse
import math
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from kabo.errors import Diagnostic, InputError
from kabo.given import LARGEST_WHOLE, shown


def _number(
    kind: Callable[[str], float], least: float, wanted: str, *, most: float = math.inf
) -> Callable[[str], Any]:
    """A reader of finite numbers of `kind` from `least` to `most`; a float must also differ from 0."""

    def parsed(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if kind is int and LARGEST_WHOLE < value <= most:
            raise argparse.ArgumentTypeError(f"{shown(text)} is not {wanted}: {LARGEST_WHOLE} is the largest")
        if not (least <= value <= most and math.isfinite(value)) or (kind is float and value == 0):
            raise argparse.ArgumentTypeError(f"{shown(text)} is not {wanted}")
        return value

    return parsed


def output_file(text: str) -> Path:
    """The path of a file to write; its folder must exist, which is checked before the work begins."""
    path = Path(text)
    if text == "-":
        raise argparse.ArgumentTypeError("'-' is no file; name one, or /dev/stdout")
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
    if path.exists() and not path.is_file():
        return  # a pipe or a device is written to, and has no neighbours
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", suffix=".part" + 16 * "0"):
            pass
    except OSError as error:
        hint = "name another file to write"
        raise InputError([Diagnostic(str(path), 1, 1, f"cannot be written: {error.strerror}", hint)]) from None


def require_apart(options: argparse.Namespace, outputs: Iterable[str]) -> None:
    """Checks that no file that a command writes is another one that it reads or writes.

    Args:
        options: all options of the command.
        outputs: the names of those that are files to write.

    Raises:
        InputError: names the file.
    """
    named = {name: _paths(value) for name, value in vars(options).items() if name != "log"}
    for output in outputs:
        others = [path.resolve() for name, paths in named.items() if name != output for path in paths]
        for path in named.get(output, []):
            if path.is_file() and path.resolve() in others:
                message = "the command reads or writes this file already: it would be overwritten"
                raise InputError([Diagnostic(str(path), 1, 1, message, "name another file to write")])


def _paths(value: object) -> list[Path]:
    """The paths in the value of an option."""
    return [each for each in (value if isinstance(value, list) else [value]) if isinstance(each, Path)]


def whole(least: int) -> Callable[[str], Any]:
    """A function that converts text to a whole number, and rejects numbers below `least`."""
    return _number(int, least, f"a whole number from {least} on")


natural = whole(0)
port = _number(int, 0, "a port from 0 to 65535", most=65535)
positive = _number(float, 0.0, "a number above 0")


LENGTHS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}  # units of lengths; longer names first


def bounded(least: float, most: float, unit: str) -> Callable[[str], float]:
    """A function that converts text to a number, and rejects numbers below `least` or above `most`; lengths may be 0."""

    def parsed(text: str) -> float:
        value = _metres(text) if unit == "m" else float(positive(text))
        if not least <= value <= most:
            wanted = "a length" if unit == "m" else "a number"
            end = "on" if most == math.inf else f"to {most:g} {unit}".rstrip()
            raise argparse.ArgumentTypeError(f"{text!r} is not {wanted} from {least:g} {end}")
        return value

    return parsed


def _metres(text: str) -> float:
    """A length in metres, or in the unit that follows the number: `0.003` and `3mm` are the same."""
    number = text.strip()
    unit = next((unit for unit in LENGTHS if number.endswith(unit)), "")
    factor = LENGTHS.get(unit, 1.0)
    try:
        value = float(number.removesuffix(unit))
        return value if factor == 1.0 else round(value * factor, 12)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a length: write metres or millimetres, 0.003 or 3mm"
        ) from None
