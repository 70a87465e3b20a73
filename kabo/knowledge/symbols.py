"""What can ever change: the symbols that actions and initial Kw or Kv entries touch; all others are static.

Static knowledge is settled while grounding and takes no room in the states.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from kabo.language.formulas import (
    Application,
    Atom,
    Change,
    Comparison,
    Conditional,
    Effect,
    ExactlyOne,
    Fact,
    FactAll,
    FactForall,
    ForEach,
    Literal,
    TermFact,
)
from kabo.language.problem import Problem


@dataclass(frozen=True)
class Symbols:
    """Names of predicates and functions: what may change, and which functions may have `f != v` as a fact."""

    changing: frozenset[str]
    excludable: frozenset[str]


def symbols_of(problem: Problem) -> Symbols:
    """Reads all effects of a problem; what actions sense counts as changed."""
    changing: set[str] = set()
    excludable: set[str] = set()
    for action in problem.domain.actions.values():
        changing.update(
            sensed.predicate if isinstance(sensed, Atom) else sensed.function for sensed in action.sense
        )
        for change in changes_of(action.effects):
            changing.update(symbol for fact in change.facts for symbol in _symbols(fact))
    for change in changes_of(problem.initial):
        if change.database != "Kf":
            changing.update(symbol for fact in change.facts for symbol in _symbols(fact))
    for effects in (problem.initial, *(action.effects for action in problem.domain.actions.values())):
        for change in changes_of(effects):
            excludable.update(name for fact in change.facts for name in _excluded(fact))
    return Symbols(frozenset(changing), frozenset(excludable))


def changes_of(effects: Iterable[Effect]) -> Iterator[Change]:
    """Every database update inside the effects, however deep."""
    for effect in effects:
        match effect:
            case Change():
                yield effect
            case Conditional(updates=inner) | ForEach(effects=inner):
                yield from changes_of(inner)


def _symbols(fact: Fact) -> Iterator[str]:
    match fact:
        case Literal(atom=Atom(predicate=name)):
            yield name
        case Comparison():
            yield from (side.function for side in (fact.left, fact.right) if isinstance(side, Application))
        case TermFact(term=term):
            yield term.function
        case FactAll(parts=parts):
            for part in parts:
                yield from _symbols(part)
        case FactForall(body=body) | ExactlyOne(body=body):
            yield from _symbols(body)


def _excluded(fact: Fact) -> Iterator[str]:
    match fact:
        case Comparison(operator="!="):
            yield from _symbols(fact)
        case FactAll(parts=parts):
            for part in parts:
                yield from _excluded(part)
        case FactForall(body=body):
            yield from _excluded(body)
