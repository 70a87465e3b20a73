"""The geometry server room: procedures over geometric states, bounded predicates, the symbolic-geometric map.

It knows scenes, motion, kinematics and geometry; it knows nothing of knowledge, search, files or plans beyond the
segments of motion that it makes.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "Answer": "answers",
    "Failure": "answers",
    "Statistics": "answers",
    "Success": "answers",
    "GeometryServer": "server",
    "MAX_EFFORT": "answers",
    "IdentifierMap": "identifiers",
    "ScenePredicates": "predicates",
    "PROCEDURES": "procedures",
    "Situation": "situation",
}
__all__ = sorted(_HOME)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Public names load when first used: kernels cost half a second to import."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
