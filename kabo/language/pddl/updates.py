"""Translates PDDL's conditional effects into updates: of knowledge where all is known, else of the world (`when`)."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import groupby, product
from operator import attrgetter

from kabo.language import formulas as f
from kabo.language.connectives import conjunction
from kabo.language.pddl.effects import ConditionalEffect
from kabo.language.resolver import NameResolver
from kabo.language.tree_algebra import renaming, substituted, symbols, variable_names

_MOST_CASES = 64


@dataclass(frozen=True)
class Disjunct:
    """A disjunct of a condition: quantified variables, a part that is always known, and claims about the world."""

    variables: tuple[f.Variable, ...] = ()
    guard: tuple[f.Formula, ...] = ()  # nothing in it can be unknown
    claims: tuple[f.Claim, ...] = ()


class _CannotBeAsked(Exception):
    """Raised for a condition on unknown atoms that no `when` can express; carries the reason."""


def updates_of(
    here: NameResolver, pieces: list[ConditionalEffect], known: Callable[[object], bool]
) -> tuple[f.Effect, ...]:
    """The updates for conditional effects, in their order; adjacent effects with equal conditions are joined."""
    updates: list[f.Effect] = []
    for _, group in groupby(pieces, attrgetter("variables", "condition")):
        updates.extend(_updates(here, list(group), known))
    return tuple(updates)


def _updates(
    here: NameResolver, group: list[ConditionalEffect], known: Callable[[object], bool]
) -> Iterator[f.Effect]:
    first = group[0]
    outcomes = tuple(piece.outcome for piece in group)
    if first.condition == f.Truth(False):
        return
    if known(first.condition):
        yield _quantified(first.variables, _conditional(first.condition, _change(outcomes, first.place)), first)
        return
    refused = next((piece for piece in group if not _may_follow(piece.outcome)), None)
    if refused is not None:
        message = "a number or computed value that changes depending on what may be unknown is not supported"
        _report(here, refused, f"{message} {here.where}")
        return
    try:
        cases = list(_cases(first.condition, known))
    except _CannotBeAsked as reason:
        _report(here, first, f"the condition of this effect {reason} {here.where}")
        return
    for case in cases:
        if known(case.claims):  # in this case nothing is unknown
            parts = [*case.guard, *(f.Know(claim, claim.place) for claim in case.claims)]
            update = _conditional(conjunction(parts, first.place), _change(outcomes, first.place))
        else:
            world = f.WorldEffect(case.claims, outcomes, first.place)
            update = _conditional(conjunction(case.guard, first.place), world)
        yield _quantified(first.variables + case.variables, update, first)


def _may_follow(outcome: f.Claim) -> bool:
    """Whether `when … then` takes the outcome: a literal, or a term and a fixed value."""
    return isinstance(outcome, f.Literal) or isinstance(outcome.right, f.Constant | f.Variable)


def _change(outcomes: tuple[f.Claim, ...], place: f.Place | None) -> f.Change:
    return f.Change("add", "Kf", outcomes, place)


def _conditional(condition: f.Formula, update: f.Change | f.WorldEffect) -> f.Effect:
    if condition == f.Truth(True):
        return update
    return f.Conditional(condition, (update,), update.place)


def _quantified(variables: tuple[f.Variable, ...], effect: f.Effect, piece: ConditionalEffect) -> f.Effect:
    return f.ForEach(variables, (effect,), piece.place) if variables else effect


# ----------------------------------------------------------------------------------------------------------- cases
def _cases(formula: f.Formula, known: Callable[[object], bool]) -> Iterator[Disjunct]:
    """The cases of a condition of which something may be unknown.

    A disjunction gives one effect for each part, `exists` one for each instance: in the world it is the same.
    """
    if isinstance(formula, f.Know):
        if _is_claim(formula.claim):
            yield Disjunct((), (), (formula.claim,))
        elif known(formula):
            yield Disjunct((), (formula,))
        else:
            raise _CannotBeAsked("compares a value that may be unknown, which is not supported")
    elif known(formula):
        yield Disjunct((), (formula,))
    elif isinstance(formula, f.And):
        sides = [list(_cases(part, known)) for part in formula.parts]
        count = 1
        for side in sides:
            count *= len(side)
        if count > _MOST_CASES:
            raise _CannotBeAsked(f"has {count} cases, more than {_MOST_CASES}")
        for combination in product(*sides):
            yield _joined(combination)
    elif isinstance(formula, f.Or):
        for part in formula.parts:
            yield from _cases(part, known)
    elif isinstance(formula, f.Exists):
        for case in _cases(formula.body, known):
            yield Disjunct(formula.variables + case.variables, case.guard, case.claims)
    else:
        unknown = ", ".join(sorted(name for name in symbols(formula) if not known(f.Atom(name))))
        raise _CannotBeAsked(f"says (forall …) of what may be unknown ({unknown}), which is not supported")


def _is_claim(claim: f.Claim) -> bool:
    """Whether `when` takes the claim: a literal, or a term and a fixed value."""
    if isinstance(claim, f.Literal):
        return True
    fixed = isinstance(claim.right, f.Constant | f.Variable | f.Number)
    return claim.operator == "=" and isinstance(claim.left, f.Application) and fixed


def _joined(cases: tuple[Disjunct, ...]) -> Disjunct:
    """All of the cases at once; each keeps variables of its own."""
    whole = Disjunct()
    for case in cases:
        used = variable_names((whole.variables, whole.guard, whole.claims))
        own = renaming(case.variables, used, used | variable_names((case.variables, case.guard, case.claims)))
        variables = tuple(own.get(variable.name, variable) for variable in case.variables)
        guard, claims = substituted(case.guard, own), substituted(case.claims, own)
        claims = tuple(dict.fromkeys(whole.claims + claims))
        whole = Disjunct(whole.variables + variables, whole.guard + guard, claims)
    return whole


def _report(here: NameResolver, piece: ConditionalEffect, message: str) -> None:
    place = piece.place or f.Place(here.source.name, 1, 1)
    here.findings.add(place, message)
