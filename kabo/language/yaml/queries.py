"""Formulas of knowledge: parse trees of the start symbol `formula`, resolved into queries."""

from collections.abc import Callable

from kabo.language import formulas as f
from kabo.language.yaml.calls import read_call, read_test
from kabo.language.yaml.syntax import Tree
from kabo.language.yaml.terms import (
    Context,
    read_atom,
    read_claim,
    read_function_term,
    read_variables,
)


def read_formula(context: Context, tree: Tree, *, temporal: bool = False) -> f.Formula | None:
    """The formula of a parse tree; with `temporal`, initially(…) and always(…) may stand in it (goals).

    Returns None after reporting what is wrong; parts beside a wrong one are still checked.
    """
    place = context.parsed.place(tree)
    if tree.data in ("true", "false"):
        return f.Truth(tree.data == "true", place)
    if tree.data in ("any_of", "all_of", "either"):
        return _junction(context, tree, temporal)
    if tree.data in ("forall", "exists"):
        variables, inner = read_variables(context, tree.children[0])
        body = read_formula(inner, tree.children[1], temporal=temporal)
        quantifier = f.Forall if tree.data == "forall" else f.Exists
        return None if body is None else quantifier(variables, body, place)
    if tree.data == "negation":
        body = read_formula(context, tree.children[0], temporal=temporal)
        return None if body is None else f.Not(body, place)
    if tree.data == "temporal":
        return _temporal(context, tree, temporal)
    if tree.data == "call":
        return _test(context, tree)
    return _PRIMITIVES[str(tree.data)](context, tree)


def _junction(context: Context, tree: Tree, temporal: bool) -> f.Formula | None:
    parts = [read_formula(context, part, temporal=temporal) for part in tree.children]
    whole = tuple(part for part in parts if part is not None)
    place = context.parsed.place(tree)
    if len(whole) < len(parts):
        return None
    if tree.data == "either":
        return f.Xor(whole[0], whole[1], place)
    return f.And(whole, place) if tree.data == "all_of" else f.Or(whole, place)


def _temporal(context: Context, tree: Tree, allowed: bool) -> f.Formula | None:
    kind, inner = tree.children
    body = read_formula(context, inner, temporal=allowed)
    if not allowed:
        context.report(tree, f"{kind}(…) may stand only in a goal")
        return None
    if body is None:
        return None
    return f.Temporal("initially" if kind == "initially" else "always", body, context.parsed.place(tree))


def _test(context: Context, tree: Tree) -> f.Formula | None:
    name = str(tree.children[0])
    symbol = context.scope.find(name)
    if symbol is not None and symbol.role == "predicate":
        end = context.parsed.scalar.start + (tree.meta.end_pos if not tree.meta.empty else 0)
        place = context.parsed.place(tree)
        source = context.parsed.scalar.source.text[end - place.length : end]
        written = source if source.startswith(name) else f"{name}(…)"
        context.report(tree, f'"{name}" is a predicate, and a formula is about knowledge', f"write K({written})")
        return None
    if symbol is not None and symbol.role == "procedure":
        asked = read_test(context, tree, symbol)
        return None if asked is None else f.Test(asked, context.parsed.place(tree))
    if name not in context.procedures:
        known = {**context.scope.names("predicate", "procedure"), **dict.fromkeys(context.procedures, ("", None))}
        hint = context.findings.near(name, known.keys(), known)
        context.report(tree.children[0], f'unknown geometric test "{name}" {context.where}', hint)
        return None
    call = read_call(context, tree)
    return None if call is None else f.Test(call, context.parsed.place(tree))


def _know(context: Context, tree: Tree) -> f.Formula | None:
    claim = read_claim(context, tree.children[0])
    return None if claim is None else f.Know(claim, context.parsed.place(tree))


def _know_whether(context: Context, tree: Tree) -> f.Formula | None:
    atom = read_atom(context, tree.children[0])
    return None if atom is None else f.KnowWhether(atom, context.parsed.place(tree))


def _know_value(context: Context, tree: Tree) -> f.Formula | None:
    term = read_function_term(context, tree.children[0])
    return None if term is None else f.KnowValue(term, context.parsed.place(tree))


_PRIMITIVES: dict[str, Callable[[Context, Tree], f.Formula | None]] = {
    "know": _know,
    "know_whether": _know_whether,
    "know_value": _know_value,
}
