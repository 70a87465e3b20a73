"""Translates PKS effects into kabo's updates: databases, conditions, quantifiers, numeric assignments."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from operator import attrgetter
from typing import cast

from kabo.language import formulas as f
from kabo.language.connectives import conjunction
from kabo.language.expressions import COMPARISONS, Expression
from kabo.language.pks.dialect import bind
from kabo.language.pks.formulas import read_formula
from kabo.language.resolver import NameResolver, one_of
from kabo.language.tree_algebra import rebound
from kabo.language.types import NUMBERS
from kabo.language.vocabulary import Symbol

_DATABASES = ("Kf", "Kw", "Kv", "Kx", "LCW")


@dataclass(frozen=True)
class _GuardedUpdate:
    """An update with the variables and the condition around it."""

    variables: tuple[f.Variable, ...]
    condition: f.Formula
    change: f.Change
    place: f.Place


def read_effects(here: NameResolver, node: Expression, *, conditional: bool = True) -> list[f.Effect]:
    """The updates of an expression, as kabo writes them: `forall(…) (query => updates)`.

    Args:
        here: the resolver of names in scope; wrong parts are reported and left out.
        node: the expression.
        conditional: whether a conditional update `query => …` is permitted here.
    """
    updates: list[f.Effect] = []
    pieces = _pieces(here, node, (), f.Truth(True), conditional)
    for _, same in groupby(pieces, attrgetter("variables", "condition")):
        group = list(same)
        first = group[0]
        effects: tuple[f.Effect, ...] = tuple(each.change for each in group)
        if first.condition != f.Truth(True):
            effects = (f.Conditional(first.condition, effects, first.place),)
        if first.variables:
            effects = (f.ForEach(first.variables, effects, first.place),)
        updates += effects
    return updates


def _pieces(
    here: NameResolver,
    node: Expression,
    variables: tuple[f.Variable, ...],
    condition: f.Formula,
    conditional: bool,
) -> Iterator[_GuardedUpdate]:
    if node.kind in ("and", "group"):
        for part in node.parts:
            yield from _pieces(here, part, variables, condition, conditional)
    elif node.kind == "=>":
        if not conditional:
            here.report(node, f"an effect {here.where} cannot be conditional: nothing is known before")
        own = read_formula(here, node.parts[0])
        both = f.Truth(False) if own is None else conjunction([condition, own], here.place(node))
        pieces = list(_pieces(here, node.parts[1], variables, both, conditional))
        yield from pieces if own is not None else ()
    elif node.kind == "forall":
        bound = bind(here, node.variables)
        more = tuple(each.variable for each in bound.values())
        before = rebound(condition, {variable.name for variable in more})
        yield from _pieces(here.inside(bound), node.parts[0], variables + more, before, conditional)
    else:
        change = _change(here, node)
        if change is not None:
            yield _GuardedUpdate(variables, condition, change, here.place(node))


def _change(here: NameResolver, node: Expression) -> f.Change | None:
    """add(…), del(…), or `f(c) = expression`, which is short for add(Kf, …)."""
    place = here.place(node)
    if node.kind == "=":
        fact = _comparison(here, node)
        return None if fact is None else f.Change("add", "Kf", (fact,), place)
    if node.kind != "call" or node.text not in ("add", "del"):
        here.report(node, f'unexpected "{here.quote(node)}" {here.where}, expected add(…) or del(…)')
        return None
    database = node.parts[0] if node.parts else None
    if database is None or database.kind != "name" or database.text not in _DATABASES:
        shown = "nothing" if database is None else f'"{here.quote(database)}"'
        here.report(database or node, f"unknown database {shown}, expected {', '.join(_DATABASES)}")
        return None
    if len(node.parts) < 2:
        here.report(node, f"{node.text}({database.text}) names no fact")
        return None
    facts = _facts(here, database.text, node.parts[1:])
    name = cast(f.Database, database.text)
    return f.Change("add" if node.text == "add" else "del", name, tuple(facts), place) if facts else None


def _facts(here: NameResolver, database: str, nodes: Sequence[Expression]) -> list[f.Fact]:
    """The facts of an update; none if one of them is wrong."""
    if database == "Kx":
        nodes = [part for node in nodes for part in (node.parts if node.kind in ("or", "xor") else [node])]
    elif database in ("Kf", "Kv"):
        nodes = [part for node in nodes for part in (node.parts if node.kind == "and" else [node])]
    facts = [_fact(here, database, node) for node in nodes]
    return [] if None in facts else [fact for fact in facts if fact is not None]


def _fact(here: NameResolver, database: str, node: Expression) -> f.Fact | None:
    place = here.place(node)
    if database == "LCW":
        return _complete(here, node)
    if node.kind == "forall" and database in ("Kf", "Kw"):
        bound = bind(here, node.variables)
        body = _fact(here.inside(bound), database, node.parts[0])
        variables = tuple(each.variable for each in bound.values())
        return body if body is None or not variables else f.FactForall(variables, body, place)
    if node.kind == "exists" and database == "Kx":
        bound = bind(here, node.variables)
        body = _fact(here.inside(bound), database, node.parts[0])
        return None if body is None else f.ExactlyOne(tuple(each.variable for each in bound.values()), body, place)
    if node.kind == "and" and database in ("Kw", "Kf"):
        return _conjunction(here, node)
    if database == "Kv":
        return _term(here, node)
    if database == "Kw":
        atom = here.atom(node.parts[0] if node.kind == "!" else node)
        return None if atom is None else f.Literal(atom, True, place)
    return _claim(here, node, ("=", "!=") if database == "Kf" else ("=",))


def _conjunction(here: NameResolver, node: Expression) -> f.Fact | None:
    parts = [_claim(here, part, ("=",)) for part in node.parts]
    whole = tuple(part for part in parts if part is not None)
    return f.FactAll(whole, here.place(node)) if len(whole) == len(parts) else None


def _complete(here: NameResolver, node: Expression) -> f.Fact | None:
    """A formula of LCW: its variables that nobody binds stand for all instances."""
    if node.kind == "forall":
        bound = bind(here, node.variables)
        body = _complete(here.inside(bound), node.parts[0])
        return None if body is None else f.FactForall(tuple(each.variable for each in bound.values()), body)
    free: dict[str, Symbol] = {}
    inner = replace(here, free=free)
    fact = _conjunction(inner, node) if node.kind == "and" else _claim(inner, node, ("=",))
    if fact is None or not free:
        return fact
    return f.FactForall(tuple(each.variable for each in free.values()), fact, here.place(node))


def _term(here: NameResolver, node: Expression) -> f.Fact | None:
    found = here.term(node)
    if found is None:
        return None
    if isinstance(found[0], f.Application):
        return f.TermFact(found[0], here.place(node))
    here.report(node, f'Kv takes a function, "{here.quote(node)}" is none')
    return None


def _claim(here: NameResolver, node: Expression, operators: tuple[str, ...]) -> f.Literal | f.Comparison | None:
    """A literal, or a function and a value that it can take."""
    if node.kind == "!" and node.parts[0].kind == "=":
        node = Expression("!=", "!=", node.start, node.end, node.parts[0].parts)
    if node.kind in COMPARISONS:
        if node.kind not in operators:
            here.report(node, f"a fact here has the form {' or '.join(f'f {o} v' for o in operators)}")
            return None
        return _comparison(here, node)
    claim = here.claim(node)
    return claim if isinstance(claim, f.Literal) else None


def _comparison(here: NameResolver, node: Expression) -> f.Comparison | None:
    left = here.term(node.parts[0])
    if left is None:
        return None
    term, kind = left
    if not isinstance(term, f.Application):
        message = f'"{here.quote(node.parts[0])}" is no function, expected one on the left of a fact'
        here.report(node.parts[0], message)
        return None
    if kind == NUMBERS:
        value = here.number(node.parts[1])
    else:
        found = here.term(node.parts[1], kind)
        value = None if found is None else found[0]
        if found is not None and not here.vocabulary.types.fits(found[1], kind):
            here.report(node.parts[1], f"the value must be of type {one_of(kind)}")
            return None
    if value is None:
        return None
    return f.Comparison("!=" if node.kind == "!=" else "=", term, value, here.place(node))
