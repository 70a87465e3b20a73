"""Motion: paths of joints from one configuration to another, shortened and timed.

Everything is told what is free by a function and derives every random number from a key: it knows no robots,
meshes or goals.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "Blended": "blending",
    "blended": "blending",
    "thinned": "blending",
    "fastest": "time_optimal",
    "Blocked": "rrt_connect",
    "connect": "rrt_connect",
    "FreeConfigurations": "edges",
    "FreeSegment": "edges",
    "shortcut": "shortcuts",
    "retime": "timing",
    "passed": "ramps",
    "trapezoid": "ramps",
}
__all__ = sorted(_HOME)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Public names load when first used: kernels cost half a second to import."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
