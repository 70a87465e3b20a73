"""The state that queries and effects read: known values, excluded values, and what will be known at run time."""

from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from typing import Protocol

from kabo.verify.knowledge.ground import GroundClaim, Symbol, Value

Excluded = Mapping[Symbol, frozenset[Value]]


class Facts(Protocol):
    """The interface of states that queries and effects can read: knowledge states, beliefs and worlds."""

    @property
    def known(self) -> Mapping[Symbol, Value]:
        """The known values of atoms and terms (Kf)."""

    @property
    def excluded(self) -> Excluded:
        """The values that each term is known not to have."""

    @property
    def whether(self) -> AbstractSet[Symbol]:
        """The atoms and terms that will be known at run time (Kw, Kv)."""

    @property
    def agent_knowledge(self) -> "Facts":
        """The knowledge by which conditions (`query => …`) are evaluated; for a world, the agent's knowledge."""


def truth(claim: GroundClaim, state: Facts) -> bool | None:
    """True if the claim is known to hold, False if it is known not to hold, None otherwise."""
    symbol, value, positive = claim
    known = state.known.get(symbol)
    if known is not None:
        return (known == value) is positive
    if value in state.excluded.get(symbol, ()):
        return not positive
    return None


def will_be_known(symbol: Symbol, state: Facts) -> bool:
    """Whether an atom or term is known now or will be known at run time (Kw of an atom, Kv of a term)."""
    return symbol in state.known or symbol in state.whether
