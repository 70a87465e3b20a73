"""PDDL effects as a flat list of pieces: for all variables, if a condition holds, one outcome.

What becomes of a piece in kabo depends on what may be unknown; that is decided once all of them have been read.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from kabo.language import formulas as f
from kabo.language.connectives import conjunction
from kabo.language.foreign_vocabulary import NUMBER, Kinds
from kabo.language.pddl.conditions import quantified_variables, read_condition
from kabo.language.pddl.forms import Form, Node
from kabo.language.pddl.terms import Context, read_atom, read_number, read_term
from kabo.language.tree_algebra import rebound

_CHANGES = {"increase": "+", "decrease": "-", "scale-up": "*", "scale-down": "/"}
_REFUSED = {
    "oneof": "an effect by chance (oneof …)", "probabilistic": "a probabilistic effect",
    "at": "an effect with a time", "or": "an effect with a choice (or …)", "imply": "(imply …)",
    "exists": "(exists …)", "unknown": "forgetting (unknown …)",
}  # fmt: skip

Outcome = f.Literal | f.Comparison


@dataclass(frozen=True)
class Piece:
    """One outcome of an action.

    Attributes:
        variables: the outcome and its condition hold for every instance of them.
        condition: what must hold before.
        outcome: a literal, or `f = v`.
        changes: the outcome is `f = f + v`, f - v, f * v or f / v.
        place: where it stands.
    """

    variables: tuple[f.Variable, ...]
    condition: f.Formula
    outcome: Outcome
    changes: bool = False
    place: f.Place | None = field(default=None, compare=False)

    @property
    def symbol(self) -> str:
        """The predicate or function that it changes."""
        if isinstance(self.outcome, f.Literal):
            return self.outcome.atom.predicate
        assert isinstance(self.outcome.left, f.Application)
        return self.outcome.left.function

    @property
    def arguments(self) -> tuple[f.Term, ...]:
        """The arguments of what it changes."""
        if isinstance(self.outcome, f.Literal):
            return self.outcome.atom.arguments
        assert isinstance(self.outcome.left, f.Application)
        return self.outcome.left.arguments


def read_effects(context: Context, node: Node) -> list[Piece]:
    """All pieces of an effect; those that are wrong are reported and left out."""
    return list(_pieces(context, node, (), f.Truth(True)))


def _pieces(
    context: Context, node: Node, variables: tuple[f.Variable, ...], condition: f.Formula
) -> Iterator[Piece]:
    head = node.head if isinstance(node, Form) else ""
    if isinstance(node, Form) and head not in context.vocabulary.predicates:
        if head == "and" or not node.items:
            for part in node.rest:
                yield from _pieces(context, part, variables, condition)
            return
        if head == "forall":
            for bound in quantified_variables(context, node):
                more = tuple(each.variable for each in bound.values())
                before = rebound(condition, {variable.name for variable in more})
                yield from _pieces(context.inside(bound), node.items[2], variables + more, before)
            return
        if head == "when":
            yield from _conditional(context, node, variables, condition)
            return
        if head == "assign" or head in _CHANGES:
            yield from _assignment(context, node, variables, condition)
            return
        if head in _REFUSED:
            context.report(node, f"{_REFUSED[head]} is not supported {context.where}")
            return
        if head == "=":
            context.report(node, f'"=" is no effect {context.where}', "write (assign (f …) value)")
            return
    yield from _literal(context, node, variables, condition)


def _conditional(
    context: Context, form: Form, variables: tuple[f.Variable, ...], condition: f.Formula
) -> Iterator[Piece]:
    if len(form.items) != 3:
        context.report(form, 'expected "(when condition effect)"')
        return
    inner = read_condition(context, form.items[1])
    both = f.Truth(True) if inner is None else conjunction([condition, inner], context.place(form))
    pieces = list(_pieces(context, form.items[2], variables, both))
    if inner is not None:
        yield from (replace(piece, place=piece.place) for piece in pieces)


def _literal(
    context: Context, node: Node, variables: tuple[f.Variable, ...], condition: f.Formula
) -> Iterator[Piece]:
    positive = not (
        isinstance(node, Form) and node.head == "not" and node.head not in context.vocabulary.predicates
    )
    inner = node
    if isinstance(node, Form) and not positive:
        if len(node.items) != 2:
            context.report(node, f'"not" takes one atom, not {len(node.items) - 1}')
            return
        inner = node.items[1]
    atom = read_atom(context, inner)
    if atom is not None:
        place = context.place(node)
        yield Piece(variables, condition, f.Literal(atom, positive, place), False, place)


def _assignment(
    context: Context, form: Form, variables: tuple[f.Variable, ...], condition: f.Formula
) -> Iterator[Piece]:
    if len(form.items) != 3:
        context.report(form, f'expected "({form.head} (f …) value)"')
        return
    left = read_term(context, form.items[1])
    place = context.place(form)
    if left is None:
        return
    term, kinds = left
    if not isinstance(term, f.Application):
        context.report(form.items[1], f'"{form.head}" changes the value of a function, expected one')
        return
    right = _value(context, form, kinds)
    if right is None:
        return
    changes = form.head in _CHANGES
    if changes:
        right = f.Arithmetic(_CHANGES[form.head], term, right, place)  # type: ignore[arg-type]
    yield Piece(variables, condition, f.Comparison("=", term, right, place), changes, place)


def _value(context: Context, form: Form, kinds: Kinds) -> f.Term | None:
    """The right side of an assignment, of a type that the function's value may have."""
    node = form.items[2]
    if kinds == (NUMBER,):
        return read_number(context, node)
    if form.head in _CHANGES:
        context.report(form, f'"{form.head}" changes numbers, "{context.document.text(form.items[1])}" is none')
        return None
    if node.head == "undefined" if isinstance(node, Form) else node.text == "undefined":
        context.report(node, "a function without a value (undefined) is not supported")
        return None
    found = read_term(context, node)
    if found is None:
        return None
    if not context.vocabulary.types.fits(found[1], kinds):
        wanted = " or ".join(kinds)
        context.report(node, f'the value must be of type {wanted}, "{context.document.text(node)}" is not')
        return None
    return found[0]
