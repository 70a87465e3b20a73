"""The facts that the rest of a plan can read; all others may be forgotten, so that 2^n branches need only a few states.

The continuation of a node depends only on the atoms and terms that it reads before it overwrites them, on those that
update rules relate to these, and on entries that a chain of shared members ties to these. A part of the goal that holds
and that nothing in the continuation can touch is settled: it is not evaluated again, so its facts may be forgotten, too.
States that agree on all that is left behave alike from there on, and are replayed once.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import compress

from kabo.plan import Plan
from kabo.verify.knowledge.ground import Entry, GroundClaim, Symbol, Value
from kabo.verify.knowledge.replay.dependencies import NodeDependencies, dependencies_of
from kabo.verify.knowledge.replay.interpreter import Interpreter
from kabo.verify.knowledge.replay.states import Knowledge, symbols_of


class Relevance:
    """The atoms and terms that each node and its continuation read and may change, as bit masks.

    There is a bit for each atom, each term, and each symbol as a whole; sets for 25,000 nodes would not fit into memory.
    """

    def __init__(self, plan: Plan, order: Sequence[str], interpreter: Interpreter) -> None:
        """Collects the relevant atoms and terms of the reached nodes; `order` has each before its successors."""
        self._goals = interpreter.goals
        self._bits: dict[Symbol | str, int] = {}
        self._read: dict[str, int] = {}
        self._touched: dict[str, int] = {}
        asked = [self._mask(goal.mentioned) for goal in self._goals]
        self._throughout = self._union(m for m, goal in zip(asked, self._goals, strict=True) if goal.temporal)
        known: dict[NodeDependencies, tuple[int, int, int]] = {}
        for name in reversed(order):
            node = plan.nodes[name]
            dependencies = dependencies_of(node, interpreter)
            if dependencies not in known:
                known[dependencies] = tuple(
                    map(self._mask, (dependencies.read, dependencies.touched, dependencies.overwritten))
                )  # type: ignore[assignment]
            read, touched, overwritten = known[dependencies]
            following = [successor for successor in node.successors if successor in self._read]
            later = self._union(self._read[successor] for successor in following)
            self._read[name] = read | self._throughout | (later & ~overwritten)
            self._touched[name] = touched | self._union(self._touched[successor] for successor in following)
        self._close(asked, [self._mask(group) for group in interpreter.rules.mentioned])

    def _close(self, asked: list[int], rules: list[int]) -> None:
        """Adds the instances of whole symbols and the effects of update rules; finds the goals that nothing can touch."""
        self._names = [(thing, bit) for thing, bit in self._bits.items() if isinstance(thing, str)]
        self._of_name = {
            name: self._mask([t for t in self._bits if not isinstance(t, str) and t[0] == name])
            for name, _ in self._names
        }
        self._groups = _merged([self._widened(group) for group in rules])
        self._asked = [self.tied(self._widened(mask)) for mask in asked]
        self._read = {name: self.tied(self._widened(mask)) for name, mask in self._read.items()}
        self._untouched: dict[str, int] = {}
        found: dict[int, int] = {}
        for name, mask in self._touched.items():
            if mask not in found:
                wide = self.tied(self._widened(mask))
                free = [
                    not goal.temporal and not a & wide for a, goal in zip(self._asked, self._goals, strict=True)
                ]
                found[mask] = sum(1 << number for number, is_free in enumerate(free) if is_free)
            self._untouched[name] = found[mask]
        self._kept: dict[tuple[str, int], Kept] = {}
        self._owed: dict[int, int] = {}

    def _mask(self, group: Iterable[Symbol | str]) -> int:
        mask = 0
        for thing in group:
            mask |= self._bits.setdefault(thing, 1 << len(self._bits))
        return mask

    @staticmethod
    def _union(masks: Iterable[int]) -> int:
        result = 0
        for mask in masks:
            result |= mask
        return result

    def _widened(self, mask: int) -> int:
        """The mask with all instances of the whole symbols in it, so that groups that share one are merged."""
        for name, bit in self._names:
            if bit & mask:
                mask |= self._of_name[name]
        return mask

    @property
    def has_rules(self) -> bool:
        """Whether update rules relate any atoms or terms to each other."""
        return bool(self._groups)

    def tied(self, mask: int) -> int:
        """A mask extended by all atoms and terms that update rules relate to a member of the mask."""
        for group in self._groups:
            if group & mask:
                mask |= group
        return mask

    # ----------------------------------------------------------------------------------------------- what is kept
    def mattering(self, name: str) -> list[Symbol]:
        """The atoms and terms on which a node, its continuation or the goal depends, in a fixed order."""
        kept = self._at(name, 0)
        return [thing for thing in self._bits if not isinstance(thing, str) and kept(thing)]

    def reduced(self, name: str, state: Knowledge) -> Knowledge:
        """The state without the facts that neither the node, its continuation nor an unsettled goal part reads."""
        open_ = self._untouched[name] & ~state.settled
        settled = state.settled
        if open_:
            entries = frozenset[Symbol]().union(*map(symbols_of, _entries(state)))
            for number, goal in enumerate(self._goals):
                if open_ >> number & 1 and entries.isdisjoint(goal.mentioned) and goal.holds(state):
                    settled |= 1 << number
        kept = self._at(name, settled)
        state = replace(state, settled=settled)
        return forget(state, kept)

    def _at(self, name: str, settled: int) -> "Kept":
        if settled not in self._owed:
            numbers = [number for number in range(len(self._goals)) if not settled >> number & 1]
            self._owed[settled] = self._union(self._asked[number] for number in numbers)
        mask = self._read[name] | self._owed[settled]
        if (name, settled) not in self._kept:
            self._kept[name, settled] = self.kept_by(mask)
        return self._kept[name, settled]

    def leave(self, name: str) -> None:
        """Frees the cached data of a node that is no longer needed."""
        for key in [key for key in self._kept if key[0] == name]:
            del self._kept[key]

    def kept_by(self, mask: int) -> "Kept":
        """The set of atoms and terms whose bits are set in a mask."""
        names = frozenset(str(thing) for thing, bit in self._names if bit & mask)
        return Kept(self, mask, frozenset(compress(self._bits, map(int, f"{mask:b}"[::-1]))), names)

    def bits_of(self, symbols: Iterable[Symbol]) -> int:
        """The mask with the bits of the given atoms and terms; symbols that no node mentions have no bit."""
        mask = 0
        for symbol in symbols:
            mask |= self._bits.get(symbol, 0)
        return mask


@dataclass(frozen=True)
class Kept:
    """A set of relevant atoms and terms; calling the set with a symbol tests membership."""

    relevance: Relevance
    mask: int
    symbols: frozenset["Symbol | str"]
    names: frozenset[str]

    def __call__(self, symbol: Symbol) -> bool:  # noqa: D102 (the class says it)
        return symbol in self.symbols or symbol[0] in self.names

    def tied_to(self, symbols: Iterable[Symbol]) -> "Kept":
        """This set, extended by the atoms and terms that update rules relate to these symbols."""
        wide = self.relevance.tied(self.mask | self.relevance.bits_of(symbols))
        return self if wide == self.mask else self.relevance.kept_by(wide)

    def only(self, known: Mapping[Symbol, Value]) -> dict[Symbol, Value]:
        """The part of `known` whose atoms and terms are in this set."""
        if self.names:
            return {symbol: value for symbol, value in known.items() if self(symbol)}
        symbols = self.symbols
        return {symbol: value for symbol, value in known.items() if symbol in symbols}


def _merged(groups: Iterable[int]) -> list[int]:
    """The groups, with those that share a bit merged into one."""
    merged: list[int] = []
    for group in groups:
        apart = [other for other in merged if not other & group]
        for other in merged:
            if other & group:
                group |= other
        merged = [*apart, group]
    return merged


def forget(state: Knowledge, kept: Kept) -> Knowledge:
    """The state without the facts and entries that no later node reads."""
    entries = _entries(state)
    tied, keeps = _tied(entries, kept) if entries else (frozenset[Symbol](), kept)
    state = replace(
        state,
        exclusive=frozenset(e for e in state.exclusive if not symbols_of(e).isdisjoint(tied)),
        some=frozenset(e for e in state.some if not symbols_of(e).isdisjoint(tied)),
        conjunctions=frozenset(e for e in state.conjunctions if not symbols_of(e).isdisjoint(tied)),
    )
    return _without(state, keeps)


def _without(state: Knowledge, kept: Kept) -> Knowledge:
    """The state without the facts that no later node reads and that none of its entries is about."""
    entries = _entries(state) if state.excluded or state.whether else ()
    tied = frozenset[Symbol]().union(*map(symbols_of, entries))
    return replace(
        state,
        known=kept.only(state.known),
        excluded={s: values for s, values in state.excluded.items() if s in tied or kept(s)},
        whether=frozenset(symbol for symbol in state.whether if symbol in tied or kept(symbol)),
    )


def _entries(state: Knowledge) -> list[Entry | tuple[GroundClaim, ...]]:
    return [*state.exclusive, *state.some, *state.conjunctions]


def _tied(entries: Sequence[Entry | tuple[GroundClaim, ...]], kept: Kept) -> tuple[frozenset[Symbol], Kept]:
    """The atoms and terms of all entries that a chain of shared members ties to a relevant one; and all relevant ones."""
    rest = [symbols_of(entry) for entry in entries]
    tied: frozenset[Symbol] = frozenset()
    while True:
        near: list[frozenset[Symbol]] = []
        far: list[frozenset[Symbol]] = []
        for group in rest:
            wanted = not group.isdisjoint(tied) or not group.isdisjoint(kept.symbols)
            (near if wanted or (kept.names and any(map(kept, group))) else far).append(group)
        if not near:
            return tied, kept
        rest, tied = far, tied.union(*near)
        kept = kept.tied_to(tied) if kept.relevance.has_rules else kept
