"""The plan room: a plan as data, its canonical file, its statistics, and its views as policy, as tree and as text.

It knows the format `kabo-plan/1` (docs/plans.md) and nothing else: not who made a plan, nor whether it is right.
Searches build plans with `PlanBuilder`, which makes equal continuations one node.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
