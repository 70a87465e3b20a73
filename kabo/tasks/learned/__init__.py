"""Learned parameters in tasks: a stage that infers them from a model, and a cost term for the risk that they are invalid.

A model is the file of an exploration. Neither needs a robot, and both work with any scene [T ch. 4].
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
