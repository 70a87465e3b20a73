"""The language room: from files to a Problem.

YAML, PDDL, contingent PDDL and PKS XML are all converted to a `Problem`, with every name resolved and every type
checked. All errors and warnings are reported at once, as diagnostics with places. A construct that kabo does not
support is reported by name and place, never dropped. Nothing is evaluated here, and no mesh is opened.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
