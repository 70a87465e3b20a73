"""The imports room: problems written in other planning languages, read into the one kind that kabo plans for.

PDDL, contingent PDDL and PKS XML become formula trees as the language room makes them; what kabo cannot say is
refused by name and place, never dropped. It reads text and makes values: it grounds nothing and evaluates nothing.
"""

from kabo.imports.loading import check_files, is_imported, load_problem

__all__ = ["check_files", "is_imported", "load_problem"]
