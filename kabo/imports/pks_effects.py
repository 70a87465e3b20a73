"""PKS effects as kabo's updates: databases, conditions of knowledge, quantifiers, assignments of numbers."""

from collections.abc import Iterator
from dataclasses import replace
from typing import cast

from kabo.imports.pks_expressions import Expression
from kabo.imports.pks_formulas import read_formula
from kabo.imports.pks_terms import COMPARISONS, Context, bind, read_atom, read_claim, read_number, read_term
from kabo.imports.vocabulary import NUMBER, Bound
from kabo.language import formulas as f

_DATABASES = ("Kf", "Kw", "Kv", "Kx", "LCW")


def read_effects(context: Context, node: Expression, *, conditional: bool = True) -> list[f.Effect]:
    """The updates of an expression; what is wrong is reported and left out.

    Args:
        context: names and scope.
        node: the expression.
        conditional: whether `query => …` may stand here.
    """
    if node.kind in ("and", "group"):
        return [each for part in node.parts for each in read_effects(context, part, conditional=conditional)]
    if node.kind == "call" and node.text in ("add", "del"):
        return list(_changes(context, node))
    if node.kind == "=>":
        if not conditional:
            context.report(node, f"an effect {context.where} cannot be conditional: nothing is known before")
            return []
        condition = read_formula(context, node.parts[0])
        updates = read_effects(context, node.parts[1])
        return [f.Conditional(condition, tuple(updates), context.place(node))] if condition and updates else []
    if node.kind == "forall":
        bound = bind(context, node.variables)
        updates = read_effects(context.inside(bound), node.parts[0], conditional=conditional)
        variables = tuple(each.variable for each in bound.values())
        return [f.ForEach(variables, tuple(updates), context.place(node))] if variables and updates else updates
    if node.kind == "=":
        return list(_assignment(context, node))
    context.report(node, f'unexpected "{context.text(node)}" {context.where}, expected add(…) or del(…)')
    return []


def _assignment(context: Context, node: Expression) -> Iterator[f.Effect]:
    """`f(c) = expression`, short for add(Kf, …)."""
    fact = _comparison(context, node)
    if fact is not None:
        yield f.Change("add", "Kf", (fact,), context.place(node))


def _changes(context: Context, node: Expression) -> Iterator[f.Effect]:
    database = node.parts[0] if node.parts else None
    if database is None or database.kind != "name" or database.text not in _DATABASES:
        shown = "nothing" if database is None else f'"{context.text(database)}"'
        context.report(database or node, f"unknown database {shown}, expected {', '.join(_DATABASES)}")
        return
    if len(node.parts) < 2:
        context.report(node, f"{node.text}({database.text}) names no fact")
        return
    facts = _facts(context, database.text, node.parts[1:])
    if facts:
        operation = "add" if node.text == "add" else "del"
        yield f.Change(operation, cast(f.Database, database.text), tuple(facts), context.place(node))  # type: ignore[arg-type]


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
