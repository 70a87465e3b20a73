"""Which entries the rest of a plan can still draw conclusions from: all others may be forgotten.

An entry concludes something only if enough of its members become known. What becomes known begins with what the rest
of the plan touches: senses, changes, or ties together by entries of its own. From there this is a relaxation: what
may become known to hold is never taken back, so an entry that is left out here can indeed never fire. Claims are
bits, each beside its complement, since thousands of states with hundreds of entries are looked at.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass

from kabo.verify.knowledge.ground import Entry, GroundClaim, Symbol

Asked = Callable[[Symbol], bool]
Entries = tuple[frozenset[Entry], frozenset[Entry]]  # of Kx and of Kor

_DIGITS = re.compile(r"[0-9]{1,9}")
REMEMBERED = 2000  # answers: states of one part of a plan have much in common, more is a matter of memory


@dataclass(frozen=True)
class _Row:
    """An entry as bits: its members, their complements, both, and the terms (not atoms) that they are about."""

    entry: Entry
    members: int
    complements: int
    about: int
    size: int
    terms: tuple[Symbol, ...]
    order: tuple[object, ...]  # rows that are about the same things are near each other


class Firing:
    """Finds the entries that may fire; what it has worked out about entries is kept."""

    def __init__(self) -> None:
        self._rows: dict[Entry, _Row] = {}
        self._bits: dict[tuple[Symbol, object], int] = {}  # of the positive claim; the one above is its complement
        self._of_symbol: dict[Symbol, int] = {}  # every claim about it that was met, and its complement
        self._even = 0
        self._about: dict[Entries, int] = {}  # every claim about what entries speak of
        self._orders: dict[Entries, list[tuple[bool, _Row]]] = {}  # entries in their order
        self._known: dict[tuple[Entries, int, int], Entries] = {}
        self._asked: dict[int, tuple[int, int]] = {}

    def may_matter(
        self,
        exclusive: frozenset[Entry],
        some: frozenset[Entry],
        touched: tuple[Asked, int],
        wanted: tuple[Asked, int],
    ) -> Entries:
        """The entries of Kx and of Kor that may conclude something, and that a chain of these ties to what is wanted.

        Args:
            exclusive: of Kx.
            some: of Kor.
            touched: whether the rest of the plan may find out or change an atom or term; with a number that tells
                this question from others.
            wanted: whether anybody asks for it; the same.
        """
        entries = exclusive, some
        about = self._about.get(entries)
        if about is None:
            if len(self._about) > REMEMBERED:
                self._about.clear()
            about = self._about[entries] = self._all_about(entries)
        key = entries, about & self._claims(*touched), about & self._claims(*wanted)
        known = self._known.get(key)
        if known is None:
            if len(self._known) > REMEMBERED:
                self._known.clear()
            known = self._known[key] = self._tied(self._fired(entries, key[1]), key[2])
        return known

    def _all_about(self, entries: Entries) -> int:
        about = 0
        for each in entries:
            for entry in each:
                about |= self._row(entry).about
        return about

    def _claims(self, asked: Asked, key: int) -> int:
        """Every claim about what is asked for; looked for again when more atoms or terms have been met."""
        met = len(self._bits)
        if key not in self._asked or self._asked[key][0] != met:
            claims = 0
            for symbol, own in self._of_symbol.items():
                if asked(symbol):
                    claims |= own
            self._asked[key] = met, claims
        return self._asked[key][1]

    def _fired(self, entries: Entries, holding: int) -> list[tuple[bool, _Row]]:
        """The fixpoint, from claims that may become known to hold."""
        waiting = self._in_order(entries)
        terms = {term for _, row in waiting for term in row.terms}
        found: dict[tuple[bool, Entry], _Row] = {}
        new = holding
        while new:
            before = holding
            rest = []
            for exactly, row in waiting:
                about = row.about
                if about & new:
                    if about & holding == about:
                        found[exactly, row.entry] = row  # all may hold: it fires, and nothing follows from it
                        continue
                    made = self._concluded(exactly, row, holding)
                    if made:
                        holding |= made
                        new |= made
                        found[exactly, row.entry] = row
                        if about & holding == about:
                            continue
                rest.append((exactly, row))
            # Chains run either way along the order: the next round goes back.
            waiting = rest[::-1]
            for term in terms:
                if holding & self._of_symbol[term]:
                    holding |= self._of_symbol[term]
            new = holding & ~before
        return [(exactly, row) for (exactly, _), row in found.items()]

    def _in_order(self, entries: Entries) -> list[tuple[bool, _Row]]:
        """The entries (True: of Kx), those near each other that speak of things with near names."""
        if entries not in self._orders:
            if len(self._orders) > REMEMBERED // 10:
                self._orders.clear()
            rows = [(True, self._row(entry)) for entry in entries[0]]
            rows += [(False, self._row(entry)) for entry in entries[1]]
            self._orders[entries] = sorted(rows, key=lambda each: each[1].order)
        return self._orders[entries]

    def _tied(self, rows: list[tuple[bool, _Row]], wanted: int) -> Entries:
        """Those that a chain of shared atoms and terms ties to what is wanted."""
        found: tuple[set[Entry], set[Entry]] = (set(), set())
        while rows:
            far = []
            for exactly, row in rows:
                if row.about & wanted:
                    wanted |= row.about
                    found[0 if exactly else 1].add(row.entry)
                else:
                    far.append((exactly, row))
            if len(far) == len(rows):
                break
            rows = far
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
            others = self._swapped(members)
            about = members | others
            for term in terms:
                about |= self._of_symbol[term]
            row = self._rows[entry] = _Row(entry, members, others, about, len(entry), terms, _order(entry))
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


def _order(entry: Entry) -> tuple[object, ...]:
    """Where an entry stands among others: by the numbers in the names of what it is about, then by the names.

    Only how fast the fixpoint is found depends on it: conclusions run along the numbers of rows, columns and steps.
    """
    names = sorted(str(part) for claim in entry for part in claim[0])
    numbers = [int(digits) for name in names for digits in _DIGITS.findall(name)]
    return (sum(numbers) / len(numbers) if numbers else 0.0, tuple(names))
