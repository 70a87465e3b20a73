"""The geometry room: bodies as enclosing convex parts, bounded predicates on them, one collision kernel.

The package works with arrays, metres and epsilon only, and does not depend on robots, scenes or formulas. Names
that need compiled kernels or mesh libraries are imported when they are first used.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
