"""Robot stages: they plan with kabo's geometry server and prove every motion free by the bounded sweep check [T 3.2].

A stage is given a `TaskScene` and returns motion as `Stretch`es. Random streams of grasps and placements are keyed by
what is sampled, so the same candidates come in the same order wherever the robot starts.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
