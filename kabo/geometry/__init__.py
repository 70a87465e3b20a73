"""The geometry room: bodies as enclosing convex parts, bounded predicates on them, one collision kernel.

Arrays, metres and epsilon; it knows nothing of robots, names of objects or formulas. Names that need compiled
kernels or mesh libraries load when they are first used.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
