"""Search in finite-domain tasks: operators on variables with finitely many values, packed into machine words.

It knows numbers only: no knowledge, no geometry, no files. Small tasks are answered in plain Python, so that they never
wait for compiled code; the answers are the same.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "astar": "search.optimal_search",
    "bfws": "search.novelty_search",
    "breadth_first": "search.blind_search",
    "Budget": "compiled_task",
    "CompiledTask": "compiled_task",
    "Effect": "task",
    "FiniteTask": "task",
    "Operator": "task",
    "SearchResult": "result",
    "Variable": "task",
    "validate": "task",
    "Estimate": "heuristics.relaxation",
    "RelaxedOperator": "heuristics.relaxation",
    "RelaxedTask": "heuristics.relaxation",
}
__all__ = sorted(_HOME)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Public names load when first used: kernels cost half a second to import."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
