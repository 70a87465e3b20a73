"""The geometry room: bodies as enclosing convex parts, bounded predicates on them, one collision kernel.

Arrays, metres and epsilon; it knows nothing of robots, names of objects or formulas. Names that need compiled
kernels or mesh libraries load when they are first used.
"""

from importlib import import_module
from typing import Any

_HOMES = {
    "Budget": "budget",
    "CollisionView": "views",
    "Counters": "views",
    "Enclosure": "parts",
    "ExactView": "exact",
    "FixedGroup": "parts",
    "MovingGroup": "parts",
    "contains": "inclusion",
    "enclosing_parts": "enclosure",
    "write_parts": "enclosure",
}

__all__ = sorted(_HOMES)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
