"""Translates PKS queries into kabo's: K, Kw, Kv and negations, connectives, quantifiers, temporal operators."""

from collections.abc import Callable

from kabo.language import formulas as f
from kabo.language.connectives import conjunction, disjunction
from kabo.language.expressions import COMPARISONS, Expression
from kabo.language.pks.dialect import bind
from kabo.language.resolver import NameResolver

_TEMPORAL = {"K0": "initially", "K*": "always", "Kn": None}


def read_formula(here: NameResolver, node: Expression, *, goal: bool = False) -> f.Formula | None:
    """The query of an expression; None after an error. With `goal`, K0(…), K*(…) and Kn(…) are allowed."""
    place = here.place(node)
    if node.kind in ("and", "group"):
        parts = _all(here, node, goal)
        return None if parts is None else conjunction(parts, place)
    if node.kind == "or":
        parts = _all(here, node, goal)
        return None if parts is None else disjunction(parts, place)
    if node.kind in ("xor", "=>"):
        parts = _all(here, node, goal)
        if parts is None:
            return None
        return f.Xor(parts[0], parts[1], place) if node.kind == "xor" else _implication(parts[0], parts[1], place)
    if node.kind == "!":
        body = read_formula(here, node.parts[0], goal=goal)
        return None if body is None else denial(body, place)
    if node.kind in ("forall", "exists"):
        return _quantified(here, node, goal)
    if node.kind in COMPARISONS:  # without K: a comparison of what is known
        return _known(here, node)
    if node.kind == "call" and node.text in _TEMPORAL:
        return _temporal(here, node, goal)
    if node.kind == "call" and node.text in _QUERIES:
        return _QUERIES[node.text](here, node)
    if node.kind == "name" and node.text in ("true", "false"):
        return f.Truth(node.text == "true", place)
    _report_no_query(here, node)
    return None


def denial(body: f.Formula, place: f.Place | None) -> f.Formula:
    """The negation of a formula; the negation of `true` or `false` is simplified."""
    return f.Truth(not body.value, place) if isinstance(body, f.Truth) else f.Not(body, place)


def _all(here: NameResolver, node: Expression, goal: bool) -> list[f.Formula] | None:
    parts = [read_formula(here, part, goal=goal) for part in node.parts]
    whole = [part for part in parts if part is not None]
    return whole if len(whole) == len(parts) else None


def _implication(first: f.Formula, second: f.Formula, place: f.Place) -> f.Formula:
    return disjunction([denial(first, first.place), second], place)


def _quantified(here: NameResolver, node: Expression, goal: bool) -> f.Formula | None:
    bound = bind(here, node.variables)
    body = read_formula(here.inside(bound), node.parts[0], goal=goal)
    variables = tuple(each.variable for each in bound.values())
    if body is None or not variables:
        return body
    return (f.Forall if node.kind == "forall" else f.Exists)(variables, body, here.place(node))


def _only(here: NameResolver, node: Expression) -> Expression | None:
    if len(node.parts) == 1:
        return node.parts[0]
    here.report(node, f"{node.text}(…) takes one claim, not {len(node.parts) or 'none'}")
    return None


def _know(here: NameResolver, node: Expression) -> f.Formula | None:
    inner = _only(here, node)
    return None if inner is None else _known(here, inner)


def _known(here: NameResolver, inner: Expression) -> f.Formula | None:
    """K of a claim; of a conjunction, K of each part. K of anything else is more than K of its parts."""
    place = here.place(inner)
    if inner.kind == "and":
        parts = [_known(here, part) for part in inner.parts]
        return None if None in parts else conjunction([each for each in parts if each is not None], place)
    if inner.kind in ("or", "xor", "=>", "forall", "exists") or (inner.kind == "!" and inner.parts[0].parts):
        nested = inner.parts[0].kind if inner.kind == "!" else inner.kind
        if nested in ("or", "xor", "=>", "forall", "exists", "and", "!"):
            hint = "K takes one literal or comparison: write K(a) | K(b), which asks for more"
            here.report(inner, f'K of "{here.quote(inner)}" is not supported {here.where}', hint)
            return None
    claim = here.claim(inner)
    return claim if claim is None or isinstance(claim, f.Truth) else f.Know(claim, place)


def _whether(here: NameResolver, node: Expression) -> f.Formula | None:
    inner = _only(here, node)
    if inner is None:
        return None
    atom = here.atom(inner.parts[0] if inner.kind == "!" else inner)
    return None if atom is None else f.KnowWhether(atom, here.place(node))


def _value(here: NameResolver, node: Expression) -> f.Formula | None:
    inner = _only(here, node)
    found = None if inner is None else here.term(inner)
    if found is None:
        return None
    term, place = found[0], here.place(node)
    if isinstance(term, f.Application):
        return f.KnowValue(term, place)
    if isinstance(term, f.Constant | f.Variable | f.Number):  # a name is its own value
        return f.Truth(True, place)
    here.report(node, f"Kv takes a function, not a sum {here.where}")
    return None


def _temporal(here: NameResolver, node: Expression, goal: bool) -> f.Formula | None:
    body = _know(here, node)
    if body is None:
        return None
    if not goal:
        here.report(node, f"{node.text}(…) may stand only in a goal, not {here.where}")
        return None
    kind = _TEMPORAL[node.text]
    if kind is None:
        return body
    return f.Temporal("initially" if kind == "initially" else "always", body, here.place(node))


_QUERIES: dict[str, Callable[[NameResolver, Expression], f.Formula | None]] = {
    "K": _know, "Kw": _whether, "Kv": _value,
}  # fmt: skip


def _report_no_query(here: NameResolver, node: Expression) -> None:
    written = here.quote(node)
    if node.kind in ("name", "call") and here.vocabulary.is_predicate(node.text):
        here.report(node, f'"{written}" is a claim, and a query is about knowledge', f"write K({written})")
    elif node.kind == "call" and node.text in ("add", "del"):
        here.report(node, f"an update stands where a query is expected {here.where}")
    elif node.kind == "call":
        message = f'the external procedure "{node.text}" is not supported in imported files'
        hint = here.vocabulary.near(
            node.text, [*here.vocabulary.written("predicate"), *_QUERIES], all_if_few=False
        )
        here.report(node, message, hint)
    else:
        here.report(node, f'unexpected "{written}" {here.where}, expected a query such as K(…)')
