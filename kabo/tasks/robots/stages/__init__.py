"""The stages that ask the geometry server, each under its name in task files."""

from kabo.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
