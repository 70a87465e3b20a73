"""Motion: paths of joints from one configuration to another, shortened and timed.

Everything is told what is free by a function and derives every random number from a key: it knows no robots,
meshes or goals.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
