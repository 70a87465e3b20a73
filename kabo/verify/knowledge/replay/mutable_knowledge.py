"""A knowledge state while it changes: facts are learned, and the closure infers more from entries and ranges.

Closure: in a Kx entry a member known to be true makes all others false, a member known to be false is dropped, and the
last one left is true. A Kor entry with a member known to be true is removed, a member known to be false is dropped, and
the last one left is true. A term has its last value once all others are excluded. Learning forgets nothing, since the
world does not change by it.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

from kabo.language.problem import Problem
from kabo.verify.knowledge.facts import truth
from kabo.verify.knowledge.ground import Entry, GroundClaim, Symbol, Value, claim_text, denied, range_of, text_of
from kabo.verify.knowledge.replay.states import Knowledge, Remembered, exclude, in_order, mentioning, mentions_any


class ContradictionError(Exception):
    """A claim contradicts what is known."""


class MutableKnowledge:
    """A mutable copy of a knowledge state; `changed` are the atoms and terms that the closure has yet to process."""

    def __init__(self, problem: Problem, state: Knowledge) -> None:
        self.problem = problem
        self.known: dict[Symbol, Value] = dict(state.known)
        self.excluded: dict[Symbol, frozenset[Value]] = dict(state.excluded)
        self.whether = set(state.whether)
        self.exclusive = set(state.exclusive)
        self.some = set(state.some)
        self.conjunctions = set(state.conjunctions)
        self.past = state.past
        self.touched = state.touched
        self.broken = state.broken
        self.settled = state.settled
        self.changed: set[Symbol] = set()

    @property
    def agent_knowledge(self) -> "MutableKnowledge":
        """The state itself: conditions on knowledge are evaluated in it."""
        return self

    def finished(self) -> Knowledge:
        """An immutable copy of the state as it is now."""
        return Knowledge(
            self.known,
            self.excluded,
            frozenset(self.whether),
            frozenset(self.exclusive),
            frozenset(self.some),
            frozenset(self.conjunctions),
            self.past,
            self.touched,
            self.broken,
            self.settled,
        )

    # ------------------------------------------------------------------------------------------------- learning
    def learn(self, claim: GroundClaim) -> None:
        """Adds the knowledge that the claim holds.

        Raises:
            ContradictionError: it is known not to hold.
        """
        symbol, value, positive = claim
        already = truth(claim, self)
        if already is False:
            raise ContradictionError(f"{claim_text(claim)}, which is known not to hold")
        if already:
            return
        self.changed.add(symbol)
        if positive:
            self.known[symbol] = value
            self.excluded.pop(symbol, None)
            self.whether.discard(symbol)
        else:
            exclude(self.excluded, symbol, value)

    def will_know(self, symbol: Symbol) -> None:
        """Records that the symbol's value will be known at run time, unless it is known now."""
        if symbol not in self.known and symbol not in self.whether:
            self.whether.add(symbol)
            self.changed.add(symbol)

    def add_entry(self, database: str, entry: Entry) -> None:
        """Adds an entry to Kx or Kor, and infers what follows from it."""
        (self._settle_exclusive if database == "Kx" else self._settle_some)(entry)

    def remove_entry(self, database: str, entry: Entry) -> None:
        """Removes an entry from Kx or Kor, if the database contains it."""
        (self.exclusive if database == "Kx" else self.some).discard(entry)

    def deny_all(self, claims: Iterable[GroundClaim]) -> None:
        """Adds the knowledge that not all of the claims hold."""
        complements = frozenset(denied(self.problem, claim) for claim in claims)
        self.add_entry("Kor", complements)

    # -------------------------------------------------------------------------------------------------- closure
    def close(self) -> set[Symbol]:
        """Infers all that the closure allows; returns the atoms and terms that have changed since the last call.

        Raises:
            ContradictionError: the state contradicts itself.
        """
        everything: set[Symbol] = set()
        while self.changed:
            now, self.changed = self.changed, set()
            everything |= now
            for symbol in now if len(now) == 1 else sorted(now, key=repr):
                self._close_range(symbol)
            for entry in _in_order(mentioning(self.exclusive, now)):
                self.exclusive.discard(entry)
                self._settle_exclusive(entry)
            for entry in _in_order(mentioning(self.some, now)):
                self.some.discard(entry)
                self._settle_some(entry)
            for whole in [whole for whole in self.conjunctions if mentions_any(whole, now)]:
                truths = [truth(claim, self) for claim in whole]
                if False in truths or None not in truths:
                    self.conjunctions.discard(whole)
        return everything

    def _close_range(self, symbol: Symbol) -> None:
        if symbol in self.known:
            return
        values = range_of(self.problem, symbol)
        if values is None:
            return
        without = self.excluded.get(symbol, ())
        left = [value for value in values if value not in without]
        if not left:
            raise ContradictionError(f"{text_of(symbol)} has no value left")
        if len(left) == 1:
            self.learn((symbol, left[0], True))

    def _settle_exclusive(self, entry: Entry) -> None:
        truths = {claim: truth(claim, self) for claim in in_order(entry)}
        holding = [claim for claim, known in truths.items() if known]
        unknown = [claim for claim, known in truths.items() if known is None]
        if len(holding) > 1:
            raise ContradictionError(f"{claim_text(holding[0])} and {claim_text(holding[1])} exclude each other")
        if holding:
            for claim in unknown:
                self.learn(denied(self.problem, claim))
        elif len(unknown) == 1:
            self.learn(unknown[0])
        elif unknown:
            self.exclusive.add(frozenset(unknown))
        else:
            raise ContradictionError("of an exclusive set no member is left")

    def _settle_some(self, entry: Entry) -> None:
        truths = {claim: truth(claim, self) for claim in in_order(entry)}
        if True in truths.values():
            return
        rest = frozenset(claim for claim, known in truths.items() if known is None)
        if len(rest) == 1:
            self.learn(next(iter(rest)))
        elif rest:
            self.some.add(rest)
        else:
            raise ContradictionError("of several claims of which one holds, none is left")

    # ------------------------------------------------------------------------------------------- world changes
    def drop_entries(self, symbols: set[Symbol]) -> None:
        """Removes the entries that mention one of the given atoms and terms, whose values change."""
        self.exclusive.difference_update(mentioning(self.exclusive, symbols))
        self.some.difference_update(mentioning(self.some, symbols))
        self.conjunctions = {whole for whole in self.conjunctions if not mentions_any(whole, symbols)}

    def touch(self, symbols: Iterable[Symbol], remember: Remembered) -> None:
        """Records that symbols in `remember` have changed, and keeps their Kw and Kv for the initial state."""
        new = frozenset(s for s in symbols if s not in self.touched and (s in remember or s[0] in remember))
        if new and self.past is not None:
            self.past = replace(self.past, whether=self.past.whether | (self.whether & new))
        self.touched |= new

    def forget(self, symbol: Symbol) -> None:
        """Forgets all that is known of the atom or term."""
        self.changed.add(symbol)
        self.known.pop(symbol, None)
        self.excluded.pop(symbol, None)
        self.whether.discard(symbol)

    def may_become(self, symbol: Symbol, value: Value) -> None:
        """Updates the state for a value that may have come true: forgets its complement, and its Kw or Kv."""
        self.changed.add(symbol)
        self.whether.discard(symbol)
        before = self.known.get(symbol)
        values = range_of(self.problem, symbol)
        if before is not None and before != value:
            del self.known[symbol]
            if values is not None and len(values) > 2:
                self.excluded[symbol] = frozenset(values) - {before, value}
        elif value in self.excluded.get(symbol, ()):
            rest = self.excluded.pop(symbol) - {value}
            if rest:
                self.excluded[symbol] = rest

    def may_cease(self, claim: GroundClaim) -> None:
        """Updates the state for a claim that may have ceased to hold: forgets the claim, not its complement."""
        symbol, value, positive = claim
        if not positive:
            self.may_become(symbol, value)
            return
        self.changed.add(symbol)
        self.whether.discard(symbol)
        if self.known.get(symbol) == value:
            del self.known[symbol]


def _in_order(entries: Iterable[Entry]) -> list[Entry]:
    found = list(entries)
    return found if len(found) < 2 else sorted(found, key=_spelled)


@lru_cache(maxsize=1 << 16)
def _spelled(entry: Entry) -> str:
    return repr(in_order(entry))
