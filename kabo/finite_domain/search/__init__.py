"""Searches in finite-domain tasks, one file each: breadth-first, novelty-guided, A*.

This face offers what is slow to load: each search in plain Python goes on in compiled code once the task outgrows it.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
