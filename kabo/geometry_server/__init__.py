"""The geometry server room: bounded predicates, streams of candidates, proven motions, the symbolic-geometric map.

The package depends on scenes, motion, kinematics and geometry, but not on knowledge, search or files; of plans it
uses only the segments of motion that it makes.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
