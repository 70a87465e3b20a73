"""What queries and effects read: values that are known, values that are excluded, what will be known at run time."""

from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from typing import Protocol

from kabo.verify.knowledge.ground import GroundClaim, Symbol, Value

Excluded = Mapping[Symbol, frozenset[Value]]


class Facts(Protocol):
    """What queries read: a state, or one that is being changed."""

    @property
    def known(self) -> Mapping[Symbol, Value]:
        """Values of atoms and terms (Kf)."""

    @property
    def excluded(self) -> Excluded:
        """Values that terms do not have."""

    @property
    def whether(self) -> AbstractSet[Symbol]:
        """Atoms and terms that will be known at run time (Kw, Kv)."""

    @property
    def mind(self) -> "Facts":
        """What conditions on knowledge (`query => …`) are asked of: a world is not what the agent knows of it."""


def truth(claim: GroundClaim, state: Facts) -> bool | None:
    """Whether a claim is known to hold (True), known not to hold (False), or neither (None)."""
    symbol, value, positive = claim
    known = state.known.get(symbol)
    if known is not None:
        return (known == value) is positive
    if value in state.excluded.get(symbol, ()):
        return not positive
    return None


def will_be_known(symbol: Symbol, state: Facts) -> bool:
    """Kw of an atom, Kv of a term: known, or known at run time."""
    return symbol in state.known or symbol in state.whether
