"""PKS effects as kabo's updates: databases, conditions of knowledge, quantifiers, assignments of numbers."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import cast

from kabo.language import formulas as f
from kabo.language.connectives import conjunction
from kabo.language.foreign_vocabulary import NUMBER, Bound
from kabo.language.pks.expressions import Expression
from kabo.language.pks.formulas import read_formula
from kabo.language.pks.terms import COMPARISONS, Context, bind, read_atom, read_claim, read_number, read_term
from kabo.language.tree_algebra import rebound

_DATABASES = ("Kf", "Kw", "Kv", "Kx", "LCW")


@dataclass(frozen=True)
class _Piece:
    """One update, with the variables and conditions around it."""

    variables: tuple[f.Variable, ...]
    condition: f.Formula
    change: f.Change
    place: f.Place


def read_effects(context: Context, node: Expression, *, conditional: bool = True) -> list[f.Effect]:
    """The updates of an expression, as kabo writes them: `forall(…) (query => updates)`.

    Args:
        context: names and scope; what is wrong is reported and left out.
        node: the expression.
        conditional: whether `query => …` may stand here.
    """
    updates: list[f.Effect] = []
    pieces = _pieces(context, node, (), f.Truth(True), conditional)
    for group in _groups(pieces):
        first = group[0]
        effects: tuple[f.Effect, ...] = tuple(each.change for each in group)
        if first.condition != f.Truth(True):
            effects = (f.Conditional(first.condition, effects, first.place),)
        if first.variables:
            effects = (f.ForEach(first.variables, effects, first.place),)
        updates += effects
    return updates


def _groups(pieces: Iterable[_Piece]) -> Iterator[list[_Piece]]:
    """Neighbours under the same variables and condition."""
    group: list[_Piece] = []
    for piece in pieces:
        if group and (group[0].variables, group[0].condition) != (piece.variables, piece.condition):
            yield group
            group = []
        group.append(piece)
    if group:
        yield group


def _pieces(
    context: Context,
    node: Expression,
    variables: tuple[f.Variable, ...],
    condition: f.Formula,
    conditional: bool,
) -> Iterator[_Piece]:
    if node.kind in ("and", "group"):
        for part in node.parts:
            yield from _pieces(context, part, variables, condition, conditional)
    elif node.kind == "=>":
        if not conditional:
            context.report(node, f"an effect {context.where} cannot be conditional: nothing is known before")
        own = read_formula(context, node.parts[0])
        both = f.Truth(False) if own is None else conjunction([condition, own], context.place(node))
        pieces = list(_pieces(context, node.parts[1], variables, both, conditional))
        yield from pieces if own is not None else ()
    elif node.kind == "forall":
        bound = bind(context, node.variables)
        more = tuple(each.variable for each in bound.values())
        before = rebound(condition, {variable.name for variable in more})
        yield from _pieces(context.inside(bound), node.parts[0], variables + more, before, conditional)
    else:
        change = _change(context, node)
        if change is not None:
            yield _Piece(variables, condition, change, context.place(node))


def _change(context: Context, node: Expression) -> f.Change | None:
    """add(…), del(…), or `f(c) = expression`, which is short for add(Kf, …)."""
    place = context.place(node)
    if node.kind == "=":
        fact = _comparison(context, node)
        return None if fact is None else f.Change("add", "Kf", (fact,), place)
    if node.kind != "call" or node.text not in ("add", "del"):
        context.report(node, f'unexpected "{context.text(node)}" {context.where}, expected add(…) or del(…)')
        return None
    database = node.parts[0] if node.parts else None
    if database is None or database.kind != "name" or database.text not in _DATABASES:
        shown = "nothing" if database is None else f'"{context.text(database)}"'
        context.report(database or node, f"unknown database {shown}, expected {', '.join(_DATABASES)}")
        return None
    if len(node.parts) < 2:
        context.report(node, f"{node.text}({database.text}) names no fact")
        return None
    facts = _facts(context, database.text, node.parts[1:])
    name = cast(f.Database, database.text)
    return f.Change("add" if node.text == "add" else "del", name, tuple(facts), place) if facts else None


def _facts(context: Context, database: str, nodes: list[Expression]) -> list[f.Fact]:
    """The facts of an update; none if one of them is wrong."""
    if database == "Kx":
        nodes = [part for node in nodes for part in (node.parts if node.kind in ("or", "xor") else [node])]
    elif database in ("Kf", "Kv"):
        nodes = [part for node in nodes for part in (node.parts if node.kind == "and" else [node])]
    facts = [_fact(context, database, node) for node in nodes]
    return [] if None in facts else [fact for fact in facts if fact is not None]


def _fact(context: Context, database: str, node: Expression) -> f.Fact | None:
    place = context.place(node)
    if database == "LCW":
        return _complete(context, node)
    if node.kind == "forall" and database in ("Kf", "Kw"):
        bound = bind(context, node.variables)
        body = _fact(context.inside(bound), database, node.parts[0])
        variables = tuple(each.variable for each in bound.values())
        return body if body is None or not variables else f.FactForall(variables, body, place)
    if node.kind == "exists" and database == "Kx":
        bound = bind(context, node.variables)
        body = _fact(context.inside(bound), database, node.parts[0])
        return None if body is None else f.ExactlyOne(tuple(each.variable for each in bound.values()), body, place)
    if node.kind == "and" and database in ("Kw", "Kf"):
        return _conjunction(context, node)
    if database == "Kv":
        return _term(context, node)
    if database == "Kw":
        atom = read_atom(context, node.parts[0] if node.kind == "!" else node)
        return None if atom is None else f.Literal(atom, True, place)
    return _claim(context, node, ("=", "!=") if database == "Kf" else ("=",))


def _conjunction(context: Context, node: Expression) -> f.Fact | None:
    parts = [_claim(context, part, ("=",)) for part in node.parts]
    whole = tuple(part for part in parts if part is not None)
    return f.FactAll(whole, context.place(node)) if len(whole) == len(parts) else None


def _complete(context: Context, node: Expression) -> f.Fact | None:
    """A formula of LCW: its variables that nobody binds stand for all instances."""
    if node.kind == "forall":
        bound = bind(context, node.variables)
        body = _complete(context.inside(bound), node.parts[0])
        return None if body is None else f.FactForall(tuple(each.variable for each in bound.values()), body)
    free: dict[str, Bound] = {}
    inner = replace(context, free=free)
    fact = _conjunction(inner, node) if node.kind == "and" else _claim(inner, node, ("=",))
    if fact is None or not free:
        return fact
    return f.FactForall(tuple(each.variable for each in free.values()), fact, context.place(node))


def _term(context: Context, node: Expression) -> f.Fact | None:
    found = read_term(context, node)
    if found is None:
        return None
    if isinstance(found[0], f.Application):
        return f.TermFact(found[0], context.place(node))
    context.report(node, f'Kv takes a function, "{context.text(node)}" is none')
    return None


def _claim(context: Context, node: Expression, operators: tuple[str, ...]) -> f.Literal | f.Comparison | None:
    """A literal, or a function and a value that it can take."""
    if node.kind == "!" and node.parts[0].kind == "=":
        node = Expression("!=", "!=", node.start, node.end, node.parts[0].parts)
    if node.kind in COMPARISONS:
        if node.kind not in operators:
            context.report(node, f"a fact here has the form {' or '.join(f'f {o} v' for o in operators)}")
            return None
        return _comparison(context, node)
    claim = read_claim(context, node)
    return claim if isinstance(claim, f.Literal) else None


def _comparison(context: Context, node: Expression) -> f.Comparison | None:
    left = read_term(context, node.parts[0])
    if left is None:
        return None
    term, kinds = left
    if not isinstance(term, f.Application):
        message = f'"{context.text(node.parts[0])}" is no function, expected one on the left of a fact'
        context.report(node.parts[0], message)
        return None
    if kinds == (NUMBER,):
        value = read_number(context, node.parts[1])
    else:
        found = read_term(context, node.parts[1], kinds)
        value = None if found is None else found[0]
        if found is not None and not context.vocabulary.types.fits(found[1], kinds):
            context.report(node.parts[1], f"the value must be of type {' or '.join(kinds)}")
            return None
    if value is None:
        return None
    return f.Comparison("!=" if node.kind == "!=" else "=", term, value, context.place(node))
