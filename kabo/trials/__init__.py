"""Trials of an exploration: made by functions or by planning tasks, and what they show, as text, JSON and HTML."""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
