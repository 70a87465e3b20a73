"""Reads queries of knowledge from expressions that were parsed with the start symbol `formula`."""

from collections.abc import Callable
from dataclasses import replace

from kabo.language import formulas as f
from kabo.language.expressions import Expression
from kabo.language.names import NAME, proper_name
from kabo.language.resolver import NameResolver
from kabo.language.types import ANY
from kabo.language.vocabulary import Symbol
from kabo.language.yaml.calls import read_call, read_test


def read_formula(here: NameResolver, node: Expression, *, temporal: bool = False) -> f.Formula | None:
    """The formula of an expression; with `temporal`, as in goals, initially(…) and always(…) are allowed.

    Returns None if an error was reported; the other parts of the expression are checked even so.
    """
    place = here.place(node)
    if node.kind in ("true", "false"):
        return f.Truth(node.kind == "true", place)
    if node.kind in ("any_of", "all_of", "either"):
        return _junction(here, node, temporal)
    if node.kind in ("forall", "exists"):
        variables, inner = read_variables(here, node)
        body = read_formula(inner, node.parts[0], temporal=temporal)
        quantifier = f.Forall if node.kind == "forall" else f.Exists
        return None if body is None else quantifier(variables, body, place)
    if node.kind == "not":
        body = read_formula(here, node.parts[0], temporal=temporal)
        return None if body is None else f.Not(body, place)
    if node.kind == "temporal":
        return _temporal(here, node, temporal)
    return _PRIMITIVES[node.kind](here, node)


def read_variables(here: NameResolver, node: Expression) -> tuple[tuple[f.Variable, ...], NameResolver]:
    """The variables of a quantifier, and a resolver that has these variables in scope."""
    found: dict[str, Symbol] = {}
    variables: list[f.Variable] = []
    for name, kind in node.variables:
        assert kind is not None
        known = here.vocabulary.check_type(kind.text, here.place(kind), here.where)
        if not NAME.fullmatch(name.text):
            message = f'"{name.text}" cannot be the name of a variable'
            here.report(name, message, f'write "{proper_name(name.text)}"')
        place = here.place(name)
        symbol = Symbol(
            "variable", name.text, place, (kind.text,) if known else ANY, type=kind.text if known else ""
        )
        if name.text in found:
            here.vocabulary.report_taken(symbol, found[name.text])
        found[name.text] = symbol
        variables.append(f.Variable(name.text, kind.text, place))
    for symbol in found.values():
        earlier = here.find(symbol.name)
        if earlier is not None:
            here.vocabulary.report_taken(symbol, earlier)
    return tuple(variables), here.inside(found)


def _junction(here: NameResolver, node: Expression, temporal: bool) -> f.Formula | None:
    hints = _ended_before(node)
    after = replace(here, hints={**hints, **here.hints}) if hints else here
    parts = [read_formula(after, part, temporal=temporal) for part in node.parts]
    whole = tuple(part for part in parts if part is not None)
    place = here.place(node)
    if len(whole) < len(parts):
        return None
    if node.kind == "either":
        return f.Xor(whole[0], whole[1], place)
    return f.And(whole, place) if node.kind == "all_of" else f.Or(whole, place)


def _ended_before(node: Expression) -> dict[str, str]:
    """The remedies for variables of quantifiers that end before the next `and`, `or` or `xor`, by their names."""
    found: dict[str, str] = {}
    for part in node.parts:
        while part.kind == "not":
            part = part.parts[0]  # noqa: PLW2901 - what is denied ends where its denial ends
        if part.kind in ("forall", "exists"):
            word = _WORDS[node.kind]
            end = (
                f'this {part.kind} ends before "{word}"; put parentheses around all that it is about: {part.kind}('
            )
            written = ", ".join(f"{kind.text} {name.text}" for name, kind in part.variables if kind is not None)
            found |= {name.text: f"{end}{written}) (… {word} …)" for name, _ in part.variables}
        elif part.kind in _WORDS:
            found |= _ended_before(part)
    return found


_WORDS = {"any_of": "or", "all_of": "and", "either": "xor"}


def _temporal(here: NameResolver, node: Expression, allowed: bool) -> f.Formula | None:
    body = read_formula(here, node.parts[0], temporal=allowed)
    if not allowed:
        here.report(node, f"{node.text}(…) may stand only in a goal")
        return None
    if body is None:
        return None
    return f.Temporal("initially" if node.text == "initially" else "always", body, here.place(node))


def _test(here: NameResolver, node: Expression) -> f.Formula | None:
    name, place = node.text, here.place(node)
    symbol = here.find(name)
    if symbol is not None and symbol.role == "predicate":
        source = here.source.text[node.end - place.length : node.end]
        written = source if source.startswith(name) else f"{name}(…)"
        here.report(node, f'"{name}" is a predicate, and a formula is about knowledge', f"write K({written})")
        return None
    if symbol is not None and symbol.role == "procedure":
        asked = read_test(here, node, symbol)
        return None if asked is None else f.Test(asked, place)
    procedures = here.vocabulary.procedures
    if name not in procedures:
        known = {**here.visible("predicate", "procedure"), **dict.fromkeys(procedures, ("", None))}
        hint = here.findings.near(name, known.keys(), known)
        here.report(node.name, f'unknown geometric test "{name}" {here.where}', hint)
        return None
    call = read_call(here, node)
    return None if call is None else f.Test(call, place)


def _know(here: NameResolver, node: Expression) -> f.Formula | None:
    claim = here.claim(node.parts[0])
    return claim if claim is None or isinstance(claim, f.Truth) else f.Know(claim, here.place(node))


def _know_whether(here: NameResolver, node: Expression) -> f.Formula | None:
    atom = here.atom(node.parts[0])
    return None if atom is None else f.KnowWhether(atom, here.place(node))


def _know_value(here: NameResolver, node: Expression) -> f.Formula | None:
    term = here.application(node.parts[0])
    return None if term is None else f.KnowValue(term, here.place(node))


_PRIMITIVES: dict[str, Callable[[NameResolver, Expression], f.Formula | None]] = {
    "call": _test, "know": _know, "know_whether": _know_whether, "know_value": _know_value,
}  # fmt: skip
