"""The language room: from files to a Problem.

YAML, PDDL, contingent PDDL and PKS XML become the one kind of problem that kabo plans for, every name resolved and
every type checked; all findings at once, as diagnostics with places. What kabo cannot say is refused by name and place,
never dropped. It reads text and makes values: it evaluates nothing and opens no mesh.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
