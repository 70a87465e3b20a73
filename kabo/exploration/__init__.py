"""Exploration of parameters by trying: which are valid, which outcomes they have, what to try next [T ch. 4]."""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
