"""Motion: joint paths from one configuration to another, shortened and timed.

Callers pass a function that says what is free, and a key that all random numbers follow from: the room knows no
robots, meshes or goals.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
