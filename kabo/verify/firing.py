"""Which entries the rest of a plan can still draw conclusions from: all others may be forgotten.

An entry concludes something only if enough of its members become known. What becomes known begins with what the rest
of the plan touches: senses, changes, or ties together by entries of its own. From there this is a relaxation: what
may become known to hold is never taken back, so an entry that is left out here can indeed never fire. Claims are
bits, each beside its complement, since thousands of states with hundreds of entries are looked at.
"""

from collections.abc import Callable
from dataclasses import dataclass

from kabo.verify.ground import Entry, GroundClaim, Symbol
from kabo.verify.knowledge import symbols_of

Entries = tuple[frozenset[Entry], frozenset[Entry]]  # of Kx and of Kor

REMEMBERED = (
    2000  # answers at most: states of one part of a plan have much in common, the rest is a matter of memory
)


@dataclass(frozen=True)
class _Row:
    """An entry as bits: its members, their complements, and the terms (not atoms) that they are about."""

    entry: Entry
    members: int
    complements: int
    size: int
    terms: tuple[Symbol, ...]


class Firing:
    """Finds the entries that may fire; what it has worked out about entries is kept."""

    def __init__(self) -> None:
        self._rows: dict[Entry, _Row] = {}
        self._bits: dict[tuple[Symbol, object], int] = {}  # of the positive claim; the one above is its complement
        self._of_symbol: dict[Symbol, int] = {}  # every claim about it that was met, and its complement
        self._even = 0
        self._about: dict[Entries, int] = {}  # every claim about what entries speak of
        self._known: dict[tuple[Entries, int], Entries] = {}
        self._touched: dict[int, tuple[int, int]] = {}

    def may_fire(
        self, exclusive: frozenset[Entry], some: frozenset[Entry], touched: Callable[[Symbol], bool], key: int
    ) -> Entries:
        """The entries of Kx and of Kor that may conclude something.

        Args:
            exclusive: of Kx.
            some: of Kor.
            touched: whether the rest of the plan may find out or change an atom or term.
            key: tells what is touched from what is touched elsewhere.
        """
        entries = exclusive, some
        about = self._about.get(entries)
        if about is None:
            if len(self._about) > REMEMBERED:
                self._about.clear()
            about = self._about[entries] = self._all_about(entries)
        holding = about & self._claims_touched(touched, key)
        known = self._known.get((entries, holding))
        if known is None:
            if len(self._known) > REMEMBERED:
                self._known.clear()
            known = self._known[entries, holding] = self._found(entries, holding)
        return known

    def _all_about(self, entries: Entries) -> int:
        rows = [self._row(entry) for each in entries for entry in each]
        about = 0
        for symbol in set[Symbol]().union(*(symbols_of(row.entry) for row in rows)):
            about |= self._of_symbol[symbol]
        return about

    def _claims_touched(self, touched: Callable[[Symbol], bool], key: int) -> int:
        """Every claim about what is touched; asked again when more atoms or terms have been met."""
        met = len(self._of_symbol)
        if key not in self._touched or self._touched[key][0] != met:
            claims = 0
            for symbol, own in self._of_symbol.items():
                if touched(symbol):
                    claims |= own
            self._touched[key] = met, claims
        return self._touched[key][1]

    def _found(self, entries: Entries, holding: int) -> Entries:
        """The fixpoint, from claims that may become known to hold."""
        waiting = [(True, self._row(entry)) for entry in entries[0]]
        waiting += [(False, self._row(entry)) for entry in entries[1]]
        terms = {term for _, row in waiting for term in row.terms}
        found: tuple[set[Entry], set[Entry]] = (set(), set())
        before = -1
        while holding != before:
            before = holding
            rest = []
            for exactly, row in waiting:
                made = self._concluded(exactly, row, holding)
                holding |= made
                if made:
                    found[0 if exactly else 1].add(row.entry)
                if not made or row.members & ~holding or row.complements & ~holding:
                    rest.append((exactly, row))  # it may conclude more
            for term in terms:
                if holding & self._of_symbol[term]:
                    holding |= self._of_symbol[term]
            waiting = rest
        return frozenset(found[0]), frozenset(found[1])

    def _concluded(self, exactly: bool, row: _Row, holding: int) -> int:
        """What may follow from an entry; 0 if it cannot fire."""
        made = 0
        held = row.members & holding
        if exactly and held:
            one = held & (held - 1) == 0
            made |= row.complements & ~(self._swapped(held) if one else 0)
        failing = row.complements & holding
        if failing.bit_count() == row.size:
            made |= row.members
        elif failing.bit_count() == row.size - 1:
            made |= self._swapped(row.complements & ~failing)
        return made

    def _swapped(self, claims: int) -> int:
        """Every claim as its complement."""
        return (claims & self._even) << 1 | (claims >> 1) & self._even

    def _row(self, entry: Entry) -> _Row:
        row = self._rows.get(entry)
        if row is None:
            members = 0
            for claim in entry:
                members |= self._bit(claim)
            terms = tuple({claim[0] for claim in entry if not isinstance(claim[1], bool)})
            row = self._rows[entry] = _Row(entry, members, self._swapped(members), len(entry), terms)
        return row

    def _bit(self, claim: GroundClaim) -> int:
        symbol, value, positive = claim
        if isinstance(value, bool):
            positive, value = value is positive, True
        key = symbol, value
        if key not in self._bits:
            bit = self._bits[key] = 1 << 2 * len(self._bits)
            self._even |= bit
            self._of_symbol[symbol] = self._of_symbol.get(symbol, 0) | bit | bit << 1
        return self._bits[key] if positive else self._bits[key] << 1
