"""Bindings of variables to objects, and terms and procedure calls with their variables bound."""

from collections.abc import Mapping

from kabo.knowledge.runtime import RunTimeValue
from kabo.language.formulas import Constant, GroundCall, Number, ProcedureCall, Term, Variable

Binding = Mapping[str, str]  # variable -> object


def object_of(term: Variable | Constant, binding: Binding) -> str:
    """The object that a variable or a constant stands for."""
    return binding[term.name] if isinstance(term, Variable) else term.name


def plain(term: Term) -> Term:
    """The term, without the mark that its value is taken at run time."""
    return term.term if isinstance(term, RunTimeValue) else term


def ground_call(call: ProcedureCall, binding: Binding) -> GroundCall:
    """The procedure call with its variables bound and its options sorted by name."""

    def value(argument: Variable | Constant | Number) -> str | float:
        if isinstance(argument, Variable):
            return binding[argument.name]
        return argument.name if isinstance(argument, Constant) else argument.value

    positional = tuple(value(argument.value) for argument in call.arguments if argument.name is None)
    named = sorted(
        (argument.name, value(argument.value)) for argument in call.arguments if argument.name is not None
    )
    return GroundCall(call.procedure, positional, tuple(named))
