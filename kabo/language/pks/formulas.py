"""PKS queries as kabo's: K, Kw, Kv and their negations, connectives, quantifiers, marks of time in goals."""

from collections.abc import Callable

from kabo.language import formulas as f
from kabo.language.connectives import conjunction, disjunction
from kabo.language.pks.expressions import Expression
from kabo.language.pks.terms import COMPARISONS, Context, bind, read_atom, read_claim, read_term

_TEMPORAL = {"K0": "initially", "K*": "always", "Kn": None}


def read_formula(context: Context, node: Expression, *, goal: bool = False) -> f.Formula | None:
    """The query of an expression; with `goal`, K0(…), K*(…) and Kn(…) may stand in it. None after a report."""
    place = context.place(node)
    if node.kind in ("and", "group"):
        parts = _all(context, node, goal)
        return None if parts is None else conjunction(parts, place)
    if node.kind == "or":
        parts = _all(context, node, goal)
        return None if parts is None else disjunction(parts, place)
    if node.kind in ("xor", "=>"):
        parts = _all(context, node, goal)
        if parts is None:
            return None
        return f.Xor(parts[0], parts[1], place) if node.kind == "xor" else _implication(parts[0], parts[1], place)
    if node.kind == "!":
        body = read_formula(context, node.parts[0], goal=goal)
        return None if body is None else denial(body, place)
    if node.kind in ("forall", "exists"):
        return _quantified(context, node, goal)
    if node.kind in COMPARISONS:  # without K: a comparison of what is known
        return _known(context, node)
    if node.kind == "call" and node.text in _TEMPORAL:
        return _temporal(context, node, goal)
    if node.kind == "call" and node.text in _QUERIES:
        return _QUERIES[node.text](context, node)
    if node.kind == "name" and node.text in ("true", "false"):
        return f.Truth(node.text == "true", place)
    _report_no_query(context, node)
    return None


def denial(body: f.Formula, place: f.Place | None) -> f.Formula:
    """Not the body."""
    return f.Truth(not body.value, place) if isinstance(body, f.Truth) else f.Not(body, place)


def _all(context: Context, node: Expression, goal: bool) -> list[f.Formula] | None:
    parts = [read_formula(context, part, goal=goal) for part in node.parts]
    whole = [part for part in parts if part is not None]
    return whole if len(whole) == len(parts) else None


def _implication(first: f.Formula, second: f.Formula, place: f.Place) -> f.Formula:
    return disjunction([denial(first, first.place), second], place)


def _quantified(context: Context, node: Expression, goal: bool) -> f.Formula | None:
    bound = bind(context, node.variables)
    body = read_formula(context.inside(bound), node.parts[0], goal=goal)
    variables = tuple(each.variable for each in bound.values())
    if body is None or not variables:
        return body
    return (f.Forall if node.kind == "forall" else f.Exists)(variables, body, context.place(node))


def _only(context: Context, node: Expression) -> Expression | None:
    if len(node.parts) == 1:
        return node.parts[0]
    context.report(node, f"{node.text}(…) takes one claim, not {len(node.parts) or 'none'}")
    return None


def _know(context: Context, node: Expression) -> f.Formula | None:
    inner = _only(context, node)
    return None if inner is None else _known(context, inner)


def _known(context: Context, inner: Expression) -> f.Formula | None:
    """K of a claim; of a conjunction, K of each part. K of anything else is more than K of its parts."""
    place = context.place(inner)
    if inner.kind == "and":
        parts = [_known(context, part) for part in inner.parts]
        return None if None in parts else conjunction([each for each in parts if each is not None], place)
    if inner.kind in ("or", "xor", "=>", "forall", "exists") or (inner.kind == "!" and inner.parts[0].parts):
        nested = inner.parts[0].kind if inner.kind == "!" else inner.kind
        if nested in ("or", "xor", "=>", "forall", "exists", "and", "!"):
            hint = "K takes one literal or comparison: write K(a) | K(b), which asks for more"
            context.report(inner, f'K of "{context.text(inner)}" is not supported {context.where}', hint)
            return None
    claim = read_claim(context, inner)
    return claim if claim is None or isinstance(claim, f.Truth) else f.Know(claim, place)


def _whether(context: Context, node: Expression) -> f.Formula | None:
    inner = _only(context, node)
    if inner is None:
        return None
    atom = read_atom(context, inner.parts[0] if inner.kind == "!" else inner)
    return None if atom is None else f.KnowWhether(atom, context.place(node))


def _value(context: Context, node: Expression) -> f.Formula | None:
    inner = _only(context, node)
    found = None if inner is None else read_term(context, inner)
    if found is None:
        return None
    term, place = found[0], context.place(node)
    if isinstance(term, f.Application):
        return f.KnowValue(term, place)
    if isinstance(term, f.Constant | f.Variable | f.Number):  # a name is its own value
        return f.Truth(True, place)
    context.report(node, f"Kv takes a function, not a sum {context.where}")
    return None


def _temporal(context: Context, node: Expression, goal: bool) -> f.Formula | None:
    body = _know(context, node)
    if body is None:
        return None
    if not goal:
        context.report(node, f"{node.text}(…) may stand only in a goal, not {context.where}")
        return None
    kind = _TEMPORAL[node.text]
    if kind is None:
        return body
    return f.Temporal("initially" if kind == "initially" else "always", body, context.place(node))


_QUERIES: dict[str, Callable[[Context, Expression], f.Formula | None]] = {
    "K": _know, "Kw": _whether, "Kv": _value,
}  # fmt: skip


def _report_no_query(context: Context, node: Expression) -> None:
    written = context.text(node)
    if node.kind in ("name", "call") and node.text in context.vocabulary.predicates:
        context.report(node, f'"{written}" is a claim, and a query is about knowledge', f"write K({written})")
    elif node.kind == "call" and node.text in ("add", "del"):
        context.report(node, f"an update stands where a query is expected {context.where}")
    elif node.kind == "call":
        message = f'the external procedure "{node.text}" is not supported in imported files'
        hint = context.vocabulary.near(node.text, [*context.vocabulary.predicates, *_QUERIES], all_if_few=False)
        context.report(node, message, hint)
    else:
        context.report(node, f'unexpected "{written}" {context.where}, expected a query such as K(…)')
