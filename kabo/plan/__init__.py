"""The plan room: a plan as data, its canonical file, its statistics, its views as policy, as tree and for people.

It knows the format `kabo-plan/1` (docs/plans.md) and nothing else: not who made a plan, nor if it is right.
Plans that a search makes go through `PlanBuilder`, which gives equal continuations one node.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
