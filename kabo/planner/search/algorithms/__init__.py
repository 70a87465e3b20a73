"""Algorithms of weak search: each finds one path to an end node, assuming sensing outcomes [K 6.2].

Each module has a function that takes a start node and a graph. It returns the path to an end node, or, if there is
none, the keys of all nodes that it visited. All algorithms are deterministic: they take successors in the order in
which the graph generates them.
"""

from importlib import import_module
from typing import Any

from kabo.options import SEARCHES, Search
from kabo.planner.search.algorithms.graph import Algorithm


def _algorithm(search: Search) -> "Algorithm[Any, Any]":
    """The function of a search, which has the name of its file: `breadth_first` of breadth_first.py."""
    name = search.replace("-", "_")
    found: Algorithm[Any, Any] = getattr(import_module(f"{__name__}.{name}"), name)
    return found


ALGORITHMS = {search: _algorithm(search) for search in SEARCHES}
