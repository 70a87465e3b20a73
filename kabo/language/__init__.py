"""The language room: from files to a Problem.

YAML with places, one grammar for formulas, every name resolved and every type checked; all findings at once, as
diagnostics. It reads text and makes values: it evaluates nothing and opens no mesh.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
