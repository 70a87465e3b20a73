"""Arguments of `kabo explore`: options with pairs `NAME=VALUE`, and findings about an option."""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from math import isfinite
from pathlib import Path

from kabo.cli import rooms
from kabo.errors import Diagnostic, InputError


def add_model(parser: argparse.ArgumentParser) -> None:
    """Adds the argument for the model file."""
    parser.add_argument("model", type=Path, metavar="MODEL", help="a model that `kabo explore run` has begun")


def add_pairs(parser: argparse.ArgumentParser, option: str, form: str, help: str, *, needed: bool = False) -> None:
    """Adds an option that takes pairs, as `--set P=X …`; it may be repeated."""
    parser.add_argument(
        option,
        nargs="+",
        action="extend",
        default=None if needed else [],
        metavar=form,
        required=needed,
        help=help,
    )


def pairs(given: list[str], option: str) -> dict[str, str]:
    """The values by name of an option with pairs.

    Raises:
        InputError: texts are no pairs, or a name is given two values; the message lists all of them.
    """
    found: dict[str, str] = {}
    faults = []
    for text in given:
        name, sign, value = text.partition("=")
        if not (sign and name and value):
            faults.append(finding(option, f"write {option} NAME=VALUE", text))
        elif found.setdefault(name, value) != value:
            faults.append(finding(option, f'"{name}" is given twice: {found[name]} and {value}', text))
    if faults:
        raise InputError(faults)
    return found


def numbers(given: list[str], option: str) -> dict[str, float]:
    """The numbers by name of an option with pairs.

    Raises:
        InputError: as `pairs`, or a value is no finite number.
    """
    found = {name: (number(value), value) for name, value in pairs(given, option).items()}
    faults = [
        finding(option, f'"{name}" must be a finite number, this is "{value}"', f"{name}={value}")
        for name, (read, value) in found.items()
        if read is None
    ]
    if faults:
        raise InputError(faults)
    return {name: read for name, (read, _) in found.items() if read is not None}


def number(text: str) -> float | None:
    """The finite number that a text stands for; None if it stands for none."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if isfinite(value) else None


def finding(option: str, message: str, text: str | None = None) -> Diagnostic:
    """A finding about an option; `text` is what was written there."""
    return Diagnostic(option, 1, 1, message, None, len(text or ""), "error", text)


@contextmanager
def findings_of(option: str) -> Iterator[None]:
    """A context that turns an ExplorationError into a finding about an option.

    Raises:
        InputError: instead of an ExplorationError. A NoParametersError is raised as it is: it is an answer.
    """
    try:
        yield
    except rooms.NoParametersError:
        raise
    except rooms.ExplorationError as error:
        raise InputError([finding(option, str(error))]) from error
