"""Robot stages: on kabo's geometry server, with every motion proven free by the bounded sweep check [T 3.2].

A stage sees a `TaskScene` and gives motion as `Stretch`es. Streams of grasps and places are keyed by what is sampled,
so the same candidates come in the same order wherever the robot starts [docs/plans.md#sharing].
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
