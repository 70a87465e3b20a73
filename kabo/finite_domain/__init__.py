"""Search in finite-domain tasks: operators on variables with finitely many values, packed into machine words.

This package works on numbers only: no knowledge, no geometry, no files. Small tasks are solved in plain Python, so
that they do not wait until compiled code is loaded.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
