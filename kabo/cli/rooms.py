"""What commands call of the rooms below, each loaded when it is first used: `--help` loads none of them.

The names stand in the stub beside this file, a line each.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
