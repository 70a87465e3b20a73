"""The geometry server room: bounded predicates, streams of candidates, proven motions, the symbolic-geometric map.

It knows scenes, motion, kinematics and geometry; it knows nothing of knowledge, search, files or plans beyond the
segments of motion that it makes.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
