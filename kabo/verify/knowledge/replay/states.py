"""States of knowledge as dictionaries and sets [docs/explanation/knowledge.md; P].

This simple representation is independent of the planner's bit sets, and both must give the same results.
"""

from collections.abc import Mapping, MutableMapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from functools import lru_cache

from kabo.verify.knowledge.facts import Excluded
from kabo.verify.knowledge.ground import Entry, GroundClaim, Symbol, Value

MAX_SCANNED_ENTRIES = 24  # entries of a set that is searched without an index
MAX_INDEXED_ENTRIES = 1 << 16  # entries in the index before it starts anew

Frozen = tuple[object, ...]
Remembered = AbstractSet["Symbol | str"]  # atoms and terms, or the names of all of them


@dataclass(frozen=True)
class Knowledge:
    """A state of knowledge.

    Attributes:
        known: the known values of atoms and terms (Kf).
        excluded: the values that terms of unknown value are known not to have.
        whether: the atoms and terms that will be known at run time (Kw, Kv) and are not known now.
        exclusive: the entries of Kx, of which exactly one member holds; each has at least two members, all unknown.
        some: the entries of Kor, of which at least one member holds; each has at least two members, all unknown.
        conjunctions: the Kw entries that are conjunctions.
        past: the present knowledge of the initial state, with the entries that held there; None if no goal needs it.
        touched: the atoms and terms that actions have changed, so that learning them says nothing of the initial state.
        broken: the numbers of the `always` goals that have been false in some state on the way.
        settled: a bit for each part of the goal that holds and that the rest of the plan cannot touch.
    """

    known: Mapping[Symbol, Value]
    excluded: Excluded = field(default_factory=dict)
    whether: frozenset[Symbol] = frozenset()
    exclusive: frozenset[Entry] = frozenset()
    some: frozenset[Entry] = frozenset()
    conjunctions: frozenset[tuple[GroundClaim, ...]] = frozenset()
    past: "Knowledge | None" = None
    touched: frozenset[Symbol] = frozenset()
    broken: frozenset[int] = frozenset()
    settled: int = 0

    @property
    def agent_knowledge(self) -> "Knowledge":
        """The state itself: conditions on knowledge are evaluated in it."""
        return self

    def frozen(self) -> Frozen:
        """The state as a hashable value, which is equal for equal states."""
        return (
            frozenset(self.known.items()),
            frozenset(self.excluded.items()),
            self.whether,
            self.exclusive,
            self.some,
            self.conjunctions,
            None if self.past is None else self.past.frozen(),
            self.touched,
            self.broken,
            self.settled,
        )

    def at_start(self) -> "Knowledge":
        """The present knowledge of the initial state, with the Kw and Kv entries that no action has touched."""
        past = self.past or Knowledge({})
        return replace(past, whether=past.whether | (self.whether - self.touched))


@lru_cache(maxsize=1 << 16)
def symbols_of(entry: Entry | tuple[GroundClaim, ...]) -> frozenset[Symbol]:
    """The atoms and terms of an entry's members."""
    return frozenset(claim[0] for claim in entry)


@lru_cache(maxsize=1 << 16)
def in_order(entry: Entry) -> tuple[GroundClaim, ...]:
    """The members of an entry in a fixed order, so that every run gives the same answer."""
    return tuple(sorted(entry, key=repr))


class Mentions:
    """An index of entries by the atoms and terms that they mention.

    The index keeps all entries given to `of`, and is emptied when there are too many.
    """

    def __init__(self) -> None:
        self._where: dict[Symbol, list[Entry]] = {}
        self._seen: set[Entry] = set()

    def of(self, entries: AbstractSet[Entry], symbols: AbstractSet[Symbol]) -> list[Entry]:
        """The entries among `entries` that mention one of the symbols, each once."""
        if len(entries) <= MAX_SCANNED_ENTRIES or len(symbols) > MAX_SCANNED_ENTRIES:
            return [entry for entry in entries if not symbols_of(entry).isdisjoint(symbols)]
        if not self._seen >= entries:
            self._note(entries)
        found = [entry for symbol in symbols for entry in self._where.get(symbol, ()) if entry in entries]
        return found if len(symbols) == 1 else list(dict.fromkeys(found))

    def _note(self, entries: AbstractSet[Entry]) -> None:
        if len(self._seen) > MAX_INDEXED_ENTRIES:
            self._seen.clear()
            self._where.clear()
        for entry in entries - self._seen:
            self._seen.add(entry)
            for symbol in symbols_of(entry):
                self._where.setdefault(symbol, []).append(entry)


_MENTIONS = Mentions()


def mentioning(entries: AbstractSet[Entry], symbols: AbstractSet[Symbol]) -> list[Entry]:
    """The entries that mention one of the symbols, each once, in no particular order."""
    return _MENTIONS.of(entries, symbols)


def mentions_any(entry: Entry | tuple[GroundClaim, ...], symbols: AbstractSet[Symbol]) -> bool:
    """Whether a member of an entry is about one of the symbols."""
    return not symbols_of(entry).isdisjoint(symbols)


def exclude(excluded: MutableMapping[Symbol, frozenset[Value]], symbol: Symbol, value: Value) -> None:
    """Adds to `excluded` that the symbol does not have the value."""
    excluded[symbol] = excluded.get(symbol, frozenset()) | {value}
