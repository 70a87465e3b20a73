"""Formulas as text as the language writes them, for explanations and messages."""

from collections.abc import Iterable

from kabo.knowledge.binding import Binding, ground_call
from kabo.language.formulas import (
    And,
    Application,
    Arithmetic,
    Atom,
    Claim,
    Comparison,
    Constant,
    Exists,
    External,
    Forall,
    Formula,
    Know,
    KnowValue,
    KnowWhether,
    Literal,
    Not,
    Number,
    Or,
    ProcedureCall,
    Temporal,
    Term,
    Test,
    Truth,
    Variable,
    Xor,
)


def formula_text(formula: Formula, binding: Binding) -> str:
    """The text of a formula with its bound variables replaced; compound parts stand in parentheses."""
    match formula:
        case Truth(value=value):
            return "true" if value else "false"
        case Know(claim=claim):
            return f"K({claim_text(claim, binding)})"
        case KnowWhether(atom=atom):
            return f"Kw({claim_text(Literal(atom), binding)})"
        case KnowValue(term=term):
            return f"Kv({term_text(term, binding)})"
        case Test(call=call):
            return _called(call, binding)
        case Not(body=body):
            return f"not {_part(body, binding)}"
        case And(parts=parts):
            return " and ".join(_part(part, binding) for part in parts)
        case Or(parts=parts):
            return " or ".join(_part(part, binding) for part in parts)
        case Xor(first=first, second=second):
            return f"{_part(first, binding)} xor {_part(second, binding)}"
        case Forall(variables=variables, body=body):
            return f"forall({_variables(variables)}) {_part(body, binding)}"
        case Exists(variables=variables, body=body):
            return f"exists({_variables(variables)}) {_part(body, binding)}"
        case Temporal(kind=kind, body=body):
            return f"{kind}({formula_text(body, binding)})"


def _called(call: ProcedureCall | External, binding: Binding) -> str:
    if isinstance(call, ProcedureCall):
        return str(ground_call(call, _OwnName(binding)))
    return _applied(call, binding) if call.arguments else f"{call.procedure}()"


class _OwnName(dict[str, str]):
    """A binding in which variables that are not bound stand for themselves."""

    def __missing__(self, name: str) -> str:
        return name


def _part(formula: Formula, binding: Binding) -> str:
    text = formula_text(formula, binding)
    return f"({text})" if isinstance(formula, And | Or | Xor) else text


def _variables(variables: Iterable[Variable]) -> str:
    return ", ".join(f"{variable.type} {variable.name}" for variable in variables)


def claim_text(claim: Claim, binding: Binding) -> str:
    """The text of a literal or comparison."""
    if isinstance(claim, Comparison):
        return f"{term_text(claim.left, binding)} {claim.operator} {term_text(claim.right, binding)}"
    return ("" if claim.positive else "not ") + _applied(claim.atom, binding)


def term_text(term: Term, binding: Binding) -> str:
    """The text of a term."""
    match term:
        case Constant(name=name):
            return name
        case Variable(name=name):
            return binding.get(name, name)
        case Number(value=value):
            return str(int(value)) if value.is_integer() else repr(value)
        case Application() | External():
            return _applied(term, binding)
        case Arithmetic(operator=operator, left=left, right=right):
            return f"({term_text(left, binding)} {operator} {term_text(right, binding)})"


def _applied(thing: Atom | Application | External, binding: Binding) -> str:
    match thing:
        case Atom(predicate=name) | Application(function=name) | External(procedure=name):
            pass
    arguments = ", ".join(term_text(argument, binding) for argument in thing.arguments)
    return f"{name}({arguments})" if arguments else name
