"""Formats counts and lists of defects for messages."""

from collections.abc import Sequence


def listed(parts: Sequence[str]) -> str:
    """A list as text: `a`, `a and b`, `a, b and c`."""
    return " and ".join([", ".join(parts[:-1]), parts[-1]]) if len(parts) > 1 else parts[0]
