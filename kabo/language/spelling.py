"""Writes formula trees as text in kabo's syntax, for plans and messages.

Parsing the text of a tree gives an equal tree. Blanks are placed as in `f(a, b)`, `x = y`, `not p`.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import singledispatch

from kabo.language import formulas as f


@dataclass(frozen=True)
class Manner:
    """Options for writing a tree as text.

    Attributes:
        names: the texts that replace variables, by the variables' names; other variables keep their names.
        explicit: whether every compound part gets parentheses, and calls have their options sorted by name.
    """

    names: Mapping[str, str]
    explicit: bool


_AS_WRITTEN = Manner({}, False)


def spell(tree: object) -> str:
    """A term, claim, formula, fact, effect or procedure call as text.

    Raises:
        TypeError: `tree` is of another type.
    """
    return spelling(tree, _AS_WRITTEN)


def spell_bound(tree: object, binding: Mapping[str, str]) -> str:
    """One instance of a tree as text: variables have the values in `binding`, all parts are in parentheses.

    Raises:
        TypeError: `tree` is not a term, claim, formula, fact, effect or procedure call.
    """
    return spelling(tree, Manner(binding, True))


def spell_number(value: float) -> str:
    """A number as text: `2` for 2.0, else Python's `repr`."""
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


@singledispatch
def spelling(tree: object, how: Manner) -> str:
    """The text of a tree; packages that define further types of trees register functions for them here.

    Raises:
        TypeError: no spelling is registered for this kind of tree.
    """
    raise TypeError(f"{type(tree).__name__} is no formula, term, effect or procedure call")


def _list(parts: Iterable[object], how: Manner, between: str = ", ") -> str:
    return between.join([spelling(part, how) for part in parts])


def _call(name: str, arguments: tuple[object, ...], how: Manner) -> str:
    return f"{name}({_list(arguments, how)})" if arguments else name


# --------------------------------------------------------------------------------------------- terms and claims
@spelling.register
def _(tree: f.Constant, how: Manner) -> str:
    return tree.name


@spelling.register
def _(tree: f.Variable, how: Manner) -> str:
    return how.names.get(tree.name, tree.name)


@spelling.register
def _(tree: f.Number, how: Manner) -> str:
    return spell_number(tree.value)


@spelling.register
def _(tree: f.Application, how: Manner) -> str:
    return _call(tree.function, tree.arguments, how)


@spelling.register
def _(tree: f.External, how: Manner) -> str:
    return _call(tree.procedure, tree.arguments, how)


@spelling.register
def _(tree: f.Atom, how: Manner) -> str:
    return _call(tree.predicate, tree.arguments, how)


@spelling.register
def _(tree: f.Arithmetic, how: Manner) -> str:
    product = tree.operator in "*/"
    left, right = spelling(tree.left, how), spelling(tree.right, how)
    if how.explicit:
        return f"({left} {tree.operator} {right})"
    if product and isinstance(tree.left, f.Arithmetic) and tree.left.operator in "+-":
        left = f"({left})"
    if isinstance(tree.right, f.Arithmetic) and (product or tree.right.operator in "+-"):
        right = f"({right})"
    return f"{left} {tree.operator} {right}"


@spelling.register
def _(tree: f.Literal, how: Manner) -> str:
    return spelling(tree.atom, how) if tree.positive else f"not {spelling(tree.atom, how)}"


@spelling.register
def _(tree: f.Comparison, how: Manner) -> str:
    return f"{spelling(tree.left, how)} {tree.operator} {spelling(tree.right, how)}"


# ------------------------------------------------------------------------------------------------------ formulas
@spelling.register
def _(tree: f.Know, how: Manner) -> str:
    return f"K({spelling(tree.claim, how)})"


@spelling.register
def _(tree: f.KnowWhether, how: Manner) -> str:
    return f"Kw({spelling(tree.atom, how)})"


@spelling.register
def _(tree: f.KnowValue, how: Manner) -> str:
    return f"Kv({spelling(tree.term, how)})"


@spelling.register
def _(tree: f.Truth, how: Manner) -> str:
    return "true" if tree.value else "false"


@spelling.register
def _(tree: f.Test, how: Manner) -> str:
    if how.explicit and isinstance(tree.call, f.ProcedureCall):
        return str(tree.call.ground(_OrItself(how.names)))
    text = spelling(tree.call, how)
    return text if text.endswith(")") else f"{text}()"


@spelling.register
def _(tree: f.Not, how: Manner) -> str:
    return f"not {_tight(tree.body, how)}"


@spelling.register
def _(tree: f.And, how: Manner) -> str:
    return " and ".join([_tight(part, how) for part in tree.parts])


@spelling.register
def _(tree: f.Or, how: Manner) -> str:
    return " or ".join([_conjunction(part, how) for part in tree.parts])


@spelling.register
def _(tree: f.Xor, how: Manner) -> str:
    return f"{_conjunction(tree.first, how)} xor {_conjunction(tree.second, how)}"


@spelling.register
def _(tree: f.Forall, how: Manner) -> str:
    return f"forall({_bound(tree.variables)}) {_tight(tree.body, how)}"


@spelling.register
def _(tree: f.Exists, how: Manner) -> str:
    return f"exists({_bound(tree.variables)}) {_tight(tree.body, how)}"


@spelling.register
def _(tree: f.Temporal, how: Manner) -> str:
    return f"{tree.kind}({spelling(tree.body, how)})"


def _tight(tree: f.Formula, how: Manner) -> str:
    text = spelling(tree, how)
    return f"({text})" if isinstance(tree, f.And | f.Or | f.Xor) else text


def _conjunction(tree: f.Formula, how: Manner) -> str:
    return spelling(tree, how) if isinstance(tree, f.And) and not how.explicit else _tight(tree, how)


def _bound(variables: tuple[f.Variable, ...]) -> str:
    return ", ".join(f"{variable.type} {variable.name}" for variable in variables)


# ------------------------------------------------------------------------------------------------------- effects
@spelling.register
def _(tree: f.FactAll, how: Manner) -> str:
    return _list(tree.parts, how, " and ")


@spelling.register
def _(tree: f.FactForall, how: Manner) -> str:
    return f"forall({_bound(tree.variables)}) {_fact_body(tree.body, how)}"


@spelling.register
def _(tree: f.ExactlyOne, how: Manner) -> str:
    return f"exactly_one({_bound(tree.variables)}) {_fact_body(tree.body, how)}"


def _fact_body(tree: f.Fact, how: Manner) -> str:
    return f"({spelling(tree, how)})" if isinstance(tree, f.FactAll) else spelling(tree, how)


@spelling.register
def _(tree: f.TermFact, how: Manner) -> str:
    return spelling(tree.term, how)


@spelling.register
def _(tree: f.Change, how: Manner) -> str:
    return f"{tree.operation}({tree.database}, {_list(tree.facts, how)})"


@spelling.register
def _(tree: f.WorldEffect, how: Manner) -> str:
    return f"when {_list(tree.conditions, how, ' and ')} then {_list(tree.outcomes, how, ' and ')}"


@spelling.register
def _(tree: f.Conditional, how: Manner) -> str:
    return f"{spelling(tree.condition, how)} => {_list(tree.updates, how)}"


@spelling.register
def _(tree: f.ForEach, how: Manner) -> str:
    effects = _list(tree.effects, how)
    simple = len(tree.effects) == 1 and isinstance(tree.effects[0], f.Change | f.WorldEffect)
    return f"forall({_bound(tree.variables)}) {effects if simple else f'({effects})'}"


# ---------------------------------------------------------------------------------------------------- procedures
@spelling.register
def _(tree: f.Argument, how: Manner) -> str:
    value = spelling(tree.value, how)
    return value if tree.name is None else f"{tree.name} = {value}"


@spelling.register
def _(tree: f.ProcedureCall, how: Manner) -> str:
    return f"{tree.procedure}({_list(tree.arguments, how)})"


class _OrItself(dict[str, str]):
    """A binding in which what is not bound stands for itself."""

    def __missing__(self, name: str) -> str:
        return name
