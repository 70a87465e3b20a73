"""Bindings of variables to objects, and terms with their variables bound."""

from collections.abc import Mapping

from kabo.knowledge.runtime import RunTimeValue
from kabo.language.formulas import Constant, Term, Variable

Binding = Mapping[str, str]  # variable -> object


def object_of(term: Variable | Constant, binding: Binding) -> str:
    """The object to which a variable is bound, or that a constant names."""
    return binding[term.name] if isinstance(term, Variable) else term.name


def plain(term: Term) -> Term:
    """The term without the mark that its value is taken at run time."""
    return term.term if isinstance(term, RunTimeValue) else term
