"""PDDL effects as a flat list of conditional effects: for all variables, if a condition holds, one outcome.

Their form in kabo depends on which atoms may be unknown, which is decided after all actions have been read.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from kabo.language import formulas as f
from kabo.language.connectives import conjunction
from kabo.language.pddl.conditions import quantified_variables, read_condition
from kabo.language.pddl.dialect import read_atom, read_number, read_term
from kabo.language.pddl.forms import Form, Node
from kabo.language.resolver import NameResolver, one_of
from kabo.language.tree_algebra import rebound
from kabo.language.types import NUMBERS, Kind

_CHANGES = {"increase": "+", "decrease": "-", "scale-up": "*", "scale-down": "/"}
_REFUSED = {
    "oneof": "an effect by chance (oneof …)", "probabilistic": "a probabilistic effect",
    "at": "an effect with a time", "or": "an effect with a choice (or …)", "imply": "(imply …)",
    "exists": "(exists …)", "unknown": "forgetting (unknown …)",
}  # fmt: skip

Outcome = f.Literal | f.Comparison


@dataclass(frozen=True)
class ConditionalEffect:
    """One outcome of an action, with the condition under which it happens.

    Attributes:
        variables: the quantified variables; the effect happens for each of their instances that meets the
            condition.
        condition: the condition in the state before the action.
        outcome: a literal, or an assignment `f = v`.
        changes: whether the assignment is relative: `f = f + v`, f - v, f * v or f / v.
        place: the place of the effect in the file.
    """

    variables: tuple[f.Variable, ...]
    condition: f.Formula
    outcome: Outcome
    changes: bool = False
    place: f.Place | None = field(default=None, compare=False)

    @property
    def symbol(self) -> str:
        """The predicate or function that the effect changes."""
        if isinstance(self.outcome, f.Literal):
            return self.outcome.atom.predicate
        assert isinstance(self.outcome.left, f.Application)
        return self.outcome.left.function

    @property
    def arguments(self) -> tuple[f.Term, ...]:
        """The arguments of the changed predicate or function."""
        if isinstance(self.outcome, f.Literal):
            return self.outcome.atom.arguments
        assert isinstance(self.outcome.left, f.Application)
        return self.outcome.left.arguments


def read_effects(here: NameResolver, node: Node) -> list[ConditionalEffect]:
    """The conditional effects into which an effect is split; faulty ones are reported and left out."""
    return list(_pieces(here, node, (), f.Truth(True)))


def _pieces(
    here: NameResolver, node: Node, variables: tuple[f.Variable, ...], condition: f.Formula
) -> Iterator[ConditionalEffect]:
    head = node.head if isinstance(node, Form) else ""
    if isinstance(node, Form) and not here.vocabulary.is_predicate(head):
        if head == "and" or not node.items:
            for part in node.rest:
                yield from _pieces(here, part, variables, condition)
            return
        if head == "forall":
            for bound in quantified_variables(here, node):
                more = tuple(each.variable for each in bound.values())
                before = rebound(condition, {variable.name for variable in more})
                yield from _pieces(here.inside(bound), node.items[2], variables + more, before)
            return
        if head == "when":
            yield from _conditional(here, node, variables, condition)
            return
        if head == "assign" or head in _CHANGES:
            yield from _assignment(here, node, variables, condition)
            return
        if head in _REFUSED:
            here.report(node, f"{_REFUSED[head]} is not supported {here.where}")
            return
        if head == "=":
            here.report(node, f'"=" is no effect {here.where}', "write (assign (f …) value)")
            return
    yield from _literal(here, node, variables, condition)


def _conditional(
    here: NameResolver, form: Form, variables: tuple[f.Variable, ...], condition: f.Formula
) -> Iterator[ConditionalEffect]:
    if len(form.items) != 3:
        here.report(form, 'expected "(when condition effect)"')
        return
    inner = read_condition(here, form.items[1])
    both = f.Truth(True) if inner is None else conjunction([condition, inner], here.place(form))
    pieces = list(_pieces(here, form.items[2], variables, both))
    if inner is not None:
        yield from (replace(piece, place=piece.place) for piece in pieces)


def _literal(
    here: NameResolver, node: Node, variables: tuple[f.Variable, ...], condition: f.Formula
) -> Iterator[ConditionalEffect]:
    positive = not (isinstance(node, Form) and node.head == "not" and not here.vocabulary.is_predicate("not"))
    inner = node
    if isinstance(node, Form) and not positive:
        if len(node.items) != 2:
            here.report(node, f'"not" takes one atom, not {len(node.items) - 1}')
            return
        inner = node.items[1]
    atom = read_atom(here, inner)
    if atom is not None:
        place = here.place(node)
        yield ConditionalEffect(variables, condition, f.Literal(atom, positive, place), False, place)


def _assignment(
    here: NameResolver, form: Form, variables: tuple[f.Variable, ...], condition: f.Formula
) -> Iterator[ConditionalEffect]:
    if len(form.items) != 3:
        here.report(form, f'expected "({form.head} (f …) value)"')
        return
    left = read_term(here, form.items[1])
    place = here.place(form)
    if left is None:
        return
    term, kind = left
    if not isinstance(term, f.Application):
        here.report(form.items[1], f'"{form.head}" changes the value of a function, expected one')
        return
    right = _value(here, form, kind)
    if right is None:
        return
    changes = form.head in _CHANGES
    if changes:
        right = f.Arithmetic(_CHANGES[form.head], term, right, place)  # type: ignore[arg-type]
    yield ConditionalEffect(variables, condition, f.Comparison("=", term, right, place), changes, place)


def _value(here: NameResolver, form: Form, kind: Kind) -> f.Term | None:
    """The right side of an assignment, of a type that the function's value may have."""
    node = form.items[2]
    if kind == NUMBERS:
        return read_number(here, node)
    if form.head in _CHANGES:
        here.report(form, f'"{form.head}" changes numbers, "{here.quote(form.items[1])}" is none')
        return None
    if node.head == "undefined" if isinstance(node, Form) else node.text == "undefined":
        here.report(node, "a function without a value (undefined) is not supported")
        return None
    found = read_term(here, node)
    if found is None:
        return None
    if not here.vocabulary.types.fits(found[1], kind):
        here.report(node, f'the value must be of type {one_of(kind)}, "{here.quote(node)}" is not')
        return None
    return found[0]
