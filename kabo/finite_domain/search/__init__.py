"""Searches in finite-domain tasks, one file each: breadth-first, novelty-guided, A*.

Its names are slow to import: each search begins in plain Python, and starts over compiled for larger tasks.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
