"""Knowledge as dictionaries and sets [docs/knowledge.md; P].

Written to be obvious, and on its own: the planner's bit sets must agree with it, not it with them.
"""

from collections.abc import Mapping, MutableMapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from functools import lru_cache

from kabo.verify.knowledge.facts import Excluded
from kabo.verify.knowledge.ground import Entry, GroundClaim, Symbol, Value

FEW = 24  # of so few entries all are looked at
MANY = 1 << 16  # entries that are remembered

Frozen = tuple[object, ...]
Remembered = AbstractSet["Symbol | str"]  # atoms and terms, or the names of all of them


@dataclass(frozen=True)
class Knowledge:
    """What is known.

    Attributes:
        known: values of atoms and terms (Kf).
        excluded: values that terms do not have; nothing about known ones.
        whether: what will be known at run time (Kw, Kv) and is not known now.
        exclusive: Kx: exactly one member holds. Members are unknown, at least two.
        some: Kor: at least one member holds. Members are unknown, at least two.
        conjunctions: Kw entries that are conjunctions.
        past: what is now known of the initial state, with the entries that held there; None if nobody asks.
        touched: what actions have touched of that: what is found out about it says nothing about the start.
        broken: the `always` goals, by number, that have not held somewhere on the way.
        settled: a bit for each part of the goal that holds and that the rest of a plan cannot touch.
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
    def mind(self) -> "Knowledge":
        """Itself."""
        return self

    def frozen(self) -> Frozen:
        """The state as a value that sets can hold."""
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
        """What is now known of the initial state; what was to be known of it at run time still is if untouched."""
        past = self.past or Knowledge({})
        return replace(past, whether=past.whether | (self.whether - self.touched))


@lru_cache(maxsize=1 << 16)
def symbols_of(entry: Entry | tuple[GroundClaim, ...]) -> frozenset[Symbol]:
    """What the members of an entry are about."""
    return frozenset(claim[0] for claim in entry)


@lru_cache(maxsize=1 << 16)
def in_order(entry: Entry) -> tuple[GroundClaim, ...]:
    """The members of an entry, always in the same order, so that every run says the same."""
    return tuple(sorted(entry, key=repr))


class Mentions:
    """Finds the entries of a set that mention one of some symbols, without looking at all of them.

    It knows where the entries that it has ever been given mention something; it forgets when these are too many.
    """

    def __init__(self) -> None:
        self._where: dict[Symbol, list[Entry]] = {}
        self._seen: set[Entry] = set()

    def of(self, entries: AbstractSet[Entry], symbols: AbstractSet[Symbol]) -> list[Entry]:
        """The entries that mention a symbol, each once."""
        if len(entries) <= FEW or len(symbols) > FEW:
            return [entry for entry in entries if not symbols_of(entry).isdisjoint(symbols)]
        if not self._seen >= entries:
            self._note(entries)
        found = [entry for symbol in symbols for entry in self._where.get(symbol, ()) if entry in entries]
        return found if len(symbols) == 1 else list(dict.fromkeys(found))

    def _note(self, entries: AbstractSet[Entry]) -> None:
        if len(self._seen) > MANY:
            self._seen.clear()
            self._where.clear()
        for entry in entries - self._seen:
            self._seen.add(entry)
            for symbol in symbols_of(entry):
                self._where.setdefault(symbol, []).append(entry)


_MENTIONS = Mentions()


def mentioning(entries: AbstractSet[Entry], symbols: AbstractSet[Symbol]) -> list[Entry]:
    """The entries that mention one of the symbols, each once, in no order."""
    return _MENTIONS.of(entries, symbols)


def mentions_any(entry: Entry | tuple[GroundClaim, ...], symbols: AbstractSet[Symbol]) -> bool:
    """Whether a member of an entry is about one of the symbols."""
    return not symbols_of(entry).isdisjoint(symbols)


def exclude(excluded: MutableMapping[Symbol, frozenset[Value]], symbol: Symbol, value: Value) -> None:
    """Notes that the symbol does not have the value."""
    excluded[symbol] = excluded.get(symbol, frozenset()) | {value}
