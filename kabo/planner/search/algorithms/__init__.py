"""Weak search: one way to an end, assuming the outcomes of sensing; one file for each search [K 6.2].

Each takes a start and a graph and returns the path to an end, or None with everything that it visited when there is
none. All are deterministic: successors are taken in the order in which the graph gives them.
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
