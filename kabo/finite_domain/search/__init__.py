"""Searches in finite-domain tasks, one file each: breadth-first, novelty-guided, A*.

The names of this package are imported on first use, since importing them is slow. Each search begins in plain
Python; for larger tasks it starts over in compiled code.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
