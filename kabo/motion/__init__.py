"""Motion: trajectories as a controller follows them, the smooth paths below them, and the fastest times along a path.

The room knows neither robots nor proofs: it computes with joint values, their limits and times.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
