"""Lazily imported names of the packages that commands call, so that `--help` imports none of them.

The names are listed in the stub file `rooms.pyi` beside this file, one per line.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
