"""The robot stages, one phase of a manipulation each: grasps, placements, motions, filters."""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
