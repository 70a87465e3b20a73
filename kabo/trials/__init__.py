"""Trials of parameters: runs explorations with functions, with planned tasks, or by asking and being told."""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
