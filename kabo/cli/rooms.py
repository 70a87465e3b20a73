"""Lazily imported names of the packages that commands call, so that `--help` imports none of them.

The names stand in the stub beside this file, a line each.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
