"""PDDL conditions as queries of knowledge: negations pushed inwards to the claims, then K around each claim.

For atoms that are always known, K(p) means p and K(not p) means (not p), so the translation is exact. For unknown
atoms it is stronger than the condition in PDDL: `(or a b)` becomes "a is known to be true or b is known to be
true".
"""

from collections.abc import Callable, Iterable

from kabo.language import formulas as f
from kabo.language.connectives import OPPOSITE, conjunction, denied, disjunction
from kabo.language.pddl.declarations import read_variables
from kabo.language.pddl.dialect import read_atom, read_comparison
from kabo.language.pddl.forms import Form, Node
from kabo.language.resolver import NameResolver
from kabo.language.vocabulary import Symbol

_REFUSED = {
    "preference": "a preference",
    **dict.fromkeys(
        ("always", "sometime", "within", "at-most-once", "sometime-after", "sometime-before", "always-within",
         "hold-during", "hold-after"), "a constraint on the whole plan",
    ),
    **dict.fromkeys(("over", "at"), "a condition with a time"),
    "oneof": "a choice (oneof …) outside of :init", "unknown": "(unknown …) outside of :init",
    "when": "an effect (when …)",
}  # fmt: skip


def read_condition(here: NameResolver, node: Node, *, positive: bool = True) -> f.Formula | None:
    """The query for a condition, or for its negation if not `positive`; None if an error was reported."""
    head = node.head if isinstance(node, Form) else ""
    if isinstance(node, Form) and not here.vocabulary.is_predicate(head):
        if not node.items:  # an empty condition is true
            return f.Truth(positive, here.place(node))
        read = _CONNECTIVES.get(head)
        if read is not None:
            return read(here, node, positive)
        if head in OPPOSITE:
            return _comparison(here, node, positive)
        if head in _REFUSED:
            here.report(node, f"{_REFUSED[head]} is not supported {here.where}")
            return None
    atom = read_atom(here, node)
    return None if atom is None else f.Know(f.Literal(atom, positive, atom.place), atom.place)


def _comparison(here: NameResolver, form: Form, positive: bool) -> f.Formula | None:
    claim = read_comparison(here, form)
    if claim is None:
        return None
    if isinstance(claim, f.Truth):
        return f.Truth(claim.value == positive, claim.place)
    return f.Know(claim if positive else denied(claim), here.place(form))


def _all(here: NameResolver, nodes: Iterable[Node], positive: bool) -> list[f.Formula] | None:
    parts = [read_condition(here, node, positive=positive) for node in nodes]
    whole = [part for part in parts if part is not None]
    return whole if len(whole) == len(parts) else None


def _and(here: NameResolver, form: Form, positive: bool) -> f.Formula | None:
    parts = _all(here, form.rest, positive)
    if parts is None:
        return None
    return (conjunction if positive else disjunction)(parts, here.place(form))


def _or(here: NameResolver, form: Form, positive: bool) -> f.Formula | None:
    parts = _all(here, form.rest, positive)
    if parts is None:
        return None
    return (disjunction if positive else conjunction)(parts, here.place(form))


def _not(here: NameResolver, form: Form, positive: bool) -> f.Formula | None:
    if len(form.items) != 2:
        here.report(form, f'"not" takes one condition, not {len(form.items) - 1}')
        return None
    return read_condition(here, form.items[1], positive=not positive)


def _imply(here: NameResolver, form: Form, positive: bool) -> f.Formula | None:
    if len(form.items) != 3:
        here.report(form, f'"imply" takes two conditions, not {len(form.items) - 1}')
        return None
    first = read_condition(here, form.items[1], positive=not positive)
    second = read_condition(here, form.items[2], positive=positive)
    if first is None or second is None:
        return None
    return (disjunction if positive else conjunction)([first, second], here.place(form))


def _quantified(here: NameResolver, form: Form, positive: bool) -> f.Formula | None:
    universal = (form.head == "forall") == positive
    place = here.place(form)
    parts: list[f.Formula] = []
    for bound in quantified_variables(here, form):
        body = read_condition(here.inside(bound), form.items[2], positive=positive)
        if body is None:
            return None
        variables = tuple(each.variable for each in bound.values())
        settled = isinstance(body, f.Truth) and body.value == universal  # whatever the instances
        if variables and not settled:
            body = f.Forall(variables, body, place) if universal else f.Exists(variables, body, place)
        parts.append(body)
    if not parts:
        return None
    return (conjunction if universal else disjunction)(parts, place)


def quantified_variables(here: NameResolver, form: Form) -> list[dict[str, Symbol]]:
    """The variables of `(forall (?x - t) body)`, as from `read_variables`; empty if an error was reported."""
    variables = form.items[1] if len(form.items) == 3 else None
    if not isinstance(variables, Form):
        here.report(form, f'expected "({form.head} (?x - type …) …)"')
        return []
    return read_variables(here, variables.items)


_CONNECTIVES: dict[str, Callable[[NameResolver, Form, bool], f.Formula | None]] = {
    "and": _and, "or": _or, "not": _not, "imply": _imply, "forall": _quantified, "exists": _quantified,
}  # fmt: skip
