"""Formula trees as text in the language's spelling: for plans, messages and round trips.

`spell(parse(text))` parses to an equal tree. Blanks are as in `f(a, b)`, `x = y`, `not p`.
"""

from collections.abc import Iterable
from functools import singledispatch

from kabo.language import formulas as f


def spell(tree: object) -> str:
    """A term, claim, formula, fact, effect or procedure call as text.

    Raises:
        TypeError: `tree` is none of them.
    """
    return _spell(tree)


def spell_number(value: float) -> str:
    """A number as people write it: `2` for 2.0, else Python's `repr`."""
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


@singledispatch
def _spell(tree: object) -> str:
    raise TypeError(f"{type(tree).__name__} is no formula, term, effect or procedure call")


def _list(parts: Iterable[object]) -> str:
    return ", ".join(map(_spell, parts))


def _call(name: str, arguments: tuple[object, ...]) -> str:
    return f"{name}({_list(arguments)})" if arguments else name


# --------------------------------------------------------------------------------------------- terms and claims
@_spell.register(f.Constant)
@_spell.register(f.Variable)
def _(tree: f.Constant | f.Variable) -> str:
    return tree.name


@_spell.register
def _(tree: f.Number) -> str:
    return spell_number(tree.value)


@_spell.register
def _(tree: f.Application) -> str:
    return _call(tree.function, tree.arguments)


@_spell.register
def _(tree: f.External) -> str:
    return _call(tree.procedure, tree.arguments)


@_spell.register
def _(tree: f.Atom) -> str:
    return _call(tree.predicate, tree.arguments)


@_spell.register
def _(tree: f.Arithmetic) -> str:
    product = tree.operator in "*/"
    left, right = _spell(tree.left), _spell(tree.right)
    if product and isinstance(tree.left, f.Arithmetic) and tree.left.operator in "+-":
        left = f"({left})"
    if isinstance(tree.right, f.Arithmetic) and (product or tree.right.operator in "+-"):
        right = f"({right})"
    return f"{left} {tree.operator} {right}"


@_spell.register
def _(tree: f.Literal) -> str:
    return _spell(tree.atom) if tree.positive else f"not {_spell(tree.atom)}"


@_spell.register
def _(tree: f.Comparison) -> str:
    return f"{_spell(tree.left)} {tree.operator} {_spell(tree.right)}"


# ------------------------------------------------------------------------------------------------------ formulas
@_spell.register
def _(tree: f.Know) -> str:
    return f"K({_spell(tree.claim)})"


@_spell.register
def _(tree: f.KnowWhether) -> str:
    return f"Kw({_spell(tree.atom)})"


@_spell.register
def _(tree: f.KnowValue) -> str:
    return f"Kv({_spell(tree.term)})"


@_spell.register
def _(tree: f.Truth) -> str:
    return "true" if tree.value else "false"


@_spell.register
def _(tree: f.Test) -> str:
    text = _spell(tree.call)
    return text if text.endswith(")") else f"{text}()"


@_spell.register
def _(tree: f.Not) -> str:
    return f"not {_tight(tree.body)}"


@_spell.register
def _(tree: f.And) -> str:
    return " and ".join(map(_tight, tree.parts))


@_spell.register
def _(tree: f.Or) -> str:
    return " or ".join(map(_conjunction, tree.parts))


@_spell.register
def _(tree: f.Xor) -> str:
    return f"{_conjunction(tree.first)} xor {_conjunction(tree.second)}"


@_spell.register
def _(tree: f.Forall) -> str:
    return f"forall({_bound(tree.variables)}) {_tight(tree.body)}"


@_spell.register
def _(tree: f.Exists) -> str:
    return f"exists({_bound(tree.variables)}) {_tight(tree.body)}"


@_spell.register
def _(tree: f.Temporal) -> str:
    return f"{tree.kind}({_spell(tree.body)})"


def _tight(tree: f.Formula) -> str:
    return f"({_spell(tree)})" if isinstance(tree, f.And | f.Or | f.Xor) else _spell(tree)


def _conjunction(tree: f.Formula) -> str:
    return f"({_spell(tree)})" if isinstance(tree, f.Or | f.Xor) else _spell(tree)


def _bound(variables: tuple[f.Variable, ...]) -> str:
    return ", ".join(f"{variable.type} {variable.name}" for variable in variables)


# ------------------------------------------------------------------------------------------------------- effects
@_spell.register
def _(tree: f.FactAll) -> str:
    return " and ".join(map(_spell, tree.parts))


@_spell.register
def _(tree: f.FactForall) -> str:
    return f"forall({_bound(tree.variables)}) {_fact_body(tree.body)}"


@_spell.register
def _(tree: f.ExactlyOne) -> str:
    return f"exactly_one({_bound(tree.variables)}) {_fact_body(tree.body)}"


def _fact_body(tree: f.Fact) -> str:
    return f"({_spell(tree)})" if isinstance(tree, f.FactAll) else _spell(tree)


@_spell.register
def _(tree: f.TermFact) -> str:
    return _spell(tree.term)


@_spell.register
def _(tree: f.Change) -> str:
    return f"{tree.operation}({tree.database}, {_list(tree.facts)})"


@_spell.register
def _(tree: f.WorldEffect) -> str:
    return f"when {' and '.join(map(_spell, tree.conditions))} then {' and '.join(map(_spell, tree.outcomes))}"


@_spell.register
def _(tree: f.Conditional) -> str:
    return f"{_spell(tree.condition)} => {_list(tree.updates)}"


@_spell.register
def _(tree: f.ForEach) -> str:
    effects = _list(tree.effects)
    simple = len(tree.effects) == 1 and isinstance(tree.effects[0], f.Change | f.WorldEffect)
    return f"forall({_bound(tree.variables)}) {effects if simple else f'({effects})'}"


# ---------------------------------------------------------------------------------------------------- procedures
@_spell.register
def _(tree: f.Argument) -> str:
    value = _spell(tree.value)
    return value if tree.name is None else f"{tree.name} = {value}"


@_spell.register
def _(tree: f.ProcedureCall) -> str:
    return f"{tree.procedure}({_list(tree.arguments)})"
