"""The predicates and functions whose knowledge can change: those in effects and initial entries; all others are static.

Static knowledge is evaluated while grounding and takes no bits of states.
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
    Temporal,
    TermFact,
    WorldEffect,
)
from kabo.language.problem import Problem


@dataclass(frozen=True)
class Symbols:
    """Names of predicates and functions.

    `changing`: knowledge about them may change. `excludable`: functions of which `f != v` may be known while f is
    not. `written`: actions may change them in the world, or forget them; other changing symbols are only learned, once
    and for all. `causes`: world effects depend on them, so they may be learned by postdiction.
    """

    changing: frozenset[str]
    excludable: frozenset[str]
    written: frozenset[str]
    causes: frozenset[str] = frozenset()


def symbols_of(problem: Problem) -> Symbols:
    """The symbols of a problem, found in all its effects; symbols that actions sense count as changing."""
    actions = problem.domain.actions.values()
    sensed = {_name(sensed) for action in actions for sensed in action.sense}
    acting = [piece for action in actions for piece in pieces_of(action.effects)]
    ruling = list(pieces_of(problem.domain.update_rules))
    starting = list(pieces_of(problem.initial))
    touched = sensed | {name for piece in (*acting, *ruling) for name in _touched(piece)}
    touched |= {name for piece in starting if _is_open(piece) for name in _touched(piece)}
    excludable = {name for piece in (*starting, *acting, *ruling) for name in _excluded(piece)}
    if any(_has_temporal(part) for part in problem.goal):
        excludable |= set(problem.domain.functions)
    written = {name for piece in acting for name in _written(piece)}
    written |= {name for piece in (*acting, *ruling) if _takes_away(piece) for name in _touched(piece)}
    worlds = [piece for piece in acting if isinstance(piece, WorldEffect)]
    causes = {name for world in worlds for claim in world.conditions for name in _symbols(claim)}
    return Symbols(frozenset(touched), frozenset(excludable), frozenset(written), frozenset(causes))


def pieces_of(effects: Iterable[Effect]) -> Iterator[Change | WorldEffect]:
    """Every database update and world effect inside the effects, at any depth."""
    for effect in effects:
        match effect:
            case Change() | WorldEffect():
                yield effect
            case Conditional(updates=inner) | ForEach(effects=inner):
                yield from pieces_of(inner)


def _is_open(piece: Change | WorldEffect) -> bool:
    """Whether something may still be learned about the symbols of an initial effect."""
    return isinstance(piece, WorldEffect) or piece.database != "Kf" or piece.operation == "del"


def _takes_away(piece: Change | WorldEffect) -> bool:
    """Whether the effect forgets knowledge or removes an entry."""
    return isinstance(piece, Change) and piece.operation == "del" and piece.database not in ("Kw", "Kv")


def _touched(piece: Change | WorldEffect) -> Iterator[str]:
    for fact in piece.outcomes if isinstance(piece, WorldEffect) else piece.facts:
        yield from _symbols(fact)


def _written(piece: Change | WorldEffect) -> Iterator[str]:
    if isinstance(piece, WorldEffect):
        for claim in piece.outcomes:
            yield from _symbols(claim)
    elif piece.database == "Kf":
        yield from _touched(piece)


def _excluded(piece: Change | WorldEffect) -> Iterator[str]:
    """Functions of which a single value can be excluded by the piece."""
    if isinstance(piece, WorldEffect):
        for claim in piece.conditions:
            yield from _symbols(claim)
    if isinstance(piece, WorldEffect) or piece.database in ("Kx", "Kor", "LCW", "Kw"):
        yield from _touched(piece)
        return
    for fact in piece.facts:
        while isinstance(fact, FactForall):
            fact = fact.body
        parts = fact.parts if isinstance(fact, FactAll) else (fact,)
        for part in parts:
            if isinstance(part, Comparison) and part.operator == "!=":
                yield from _symbols(part)


def _symbols(fact: Fact) -> Iterator[str]:
    match fact:
        case Literal(atom=atom):
            yield atom.predicate
        case Comparison():
            yield from (side.function for side in (fact.left, fact.right) if isinstance(side, Application))
        case TermFact(term=term):
            yield term.function
        case FactAll(parts=parts):
            for part in parts:
                yield from _symbols(part)
        case FactForall(body=body) | ExactlyOne(body=body):
            yield from _symbols(body)


def _name(sensed: Atom | Application) -> str:
    return sensed.predicate if isinstance(sensed, Atom) else sensed.function


def _has_temporal(tree: object) -> bool:
    if isinstance(tree, Temporal):
        return tree.kind == "initially"
    parts = (
        tree if isinstance(tree, tuple) else [getattr(tree, name) for name in getattr(tree, "__match_args__", ())]
    )
    return any(_has_temporal(part) for part in parts if not isinstance(part, str | bool | float | None))
