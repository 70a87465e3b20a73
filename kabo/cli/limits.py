"""The options `--timeout` and `--memory`, the same for every command (docs/reference/commands.md#limits)."""

import argparse
import re
from math import inf, isfinite

from kabo.cli.waiting.surrounding import Surrounding

UNITS = {"": 1, "k": 1 << 10, "m": 1 << 20, "g": 1 << 30, "t": 1 << 40}
NO_LIMIT = ("none", "0")


def add_limits(parser: argparse.ArgumentParser, default: str = "none") -> None:
    """Adds `--timeout` and `--memory`, the same for every command; `default` describes the timeout if none is given."""
    parser.add_argument(
        "--timeout",
        type=seconds,
        metavar="S",
        help=f"seconds after which the command ends, whatever it does; none: without limit (default: {default})",
    )
    parser.add_argument(
        "--memory",
        type=memory,
        metavar="SIZE",
        help="memory that the command may hold, as 500M or 4G; none: without limit (default: half of what there is)",
    )
    parser.set_defaults(surrounding=Surrounding())


def seconds(text: str) -> float:
    """Converts text to a number of seconds; `none` and 0 become infinity, and negative numbers are rejected."""
    value = inf if text in NO_LIMIT else _number(text)
    if value is None or value <= 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds above 0, or none")
    return value


def memory(text: str) -> float:
    """Converts text to a number of bytes; it may end with K, M, G or T; `none` and 0 become infinity."""
    if text in NO_LIMIT:
        return inf
    found = re.fullmatch(r"([\d.]+)\s*([kmgt]?)i?b?", text.strip(), re.IGNORECASE)
    value = None if found is None else _number(found[1])
    if found is None or value is None or value <= 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a size: write 500M, 4G or none")
    return value * UNITS[found[2].lower()]


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if isfinite(value) else None
