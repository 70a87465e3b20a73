"""What could bring a piece of knowledge about, and what keeps all of it from happening."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

from kabo.knowledge import GroundAction, Query
from kabo.knowledge.entries import Entry, LastValue
from kabo.knowledge.facts import TermBits, open_entries
from kabo.knowledge.grounding.problem import Grounding
from kabo.knowledge.progression import Update
from kabo.knowledge.queries import AnyOf, bits_of, disjunction, union
from kabo.planner.proofs.wording import Want, Words, entry_text, wants, where

Kind = Literal["does", "senses", "rule", "entry"]


@dataclass(frozen=True)
class Maker:
    """Something that would bring a want about if `blocker` could ever hold; `family` is the action's schema."""

    kind: Kind
    family: str
    name: str
    blocker: Query


class Makers:
    """Finds the makers of what the delete relaxation cannot reach."""

    def __init__(self, whole: Grounding, words: Words) -> None:
        self.whole, self.words = whole, words
        self.ones, self.zeros = whole.reach.ones, whole.reach.zeros
        self._made: dict[int, list[tuple[int, Update]]] = {}
        self._opened: dict[int, list[tuple[int, Update]]] = {}
        self._cleared: dict[int, list[tuple[int, Update]]] = {}
        self._told: dict[int, list[int]] = {}  # the entries of Kw and Kv whose outcomes would tell a bit
        self._index()
        for entry, branching in whole.splits.items():
            for bit in bits_of(union(choice.make for choice in branching.choices) & ~self.ones & ~entry):
                if entry in self._opened:
                    self._told.setdefault(bit, []).append(entry)
        self._tellable = self._closed(union(self._made) | union(self._told) | union(r.make for r in whole.rules))

    def of(self, want: Want) -> list[Maker]:
        """Everything that could make a bit that can never be 1 (or, if so asked, 0), in the order of the file."""
        if not want.is_set:
            return [*self._actions(self._cleared, want.bit, "does"), *self._rules(want)]
        found = [*self._actions(self._made, want.bit, "does")]
        done = {maker.name for maker in found}
        found += [maker for maker in self._sensing(want.bit) if maker.name not in done]
        return [*found, *self._rules(want), *self._entries(want.bit)]

    def wants(self, maker: Maker) -> list[Want]:
        """What keeps a maker from ever acting."""
        return list(dict.fromkeys(wants(maker.blocker, self.ones, self.zeros)))

    def _index(self) -> None:
        """Notes which actions would make bits that are never 1, or clear bits that are never 0."""
        notes: dict[int, tuple[int, int]] = {}  # of updates; actions share many
        for action in self.whole.actions:
            for update in action.effects.updates:
                if id(update) not in notes:
                    made = update.make | (update.assignment.bits.mask if update.assignment else 0)
                    notes[id(update)] = made & ~self.ones, update.clear & ~self.zeros
                made, cleared = notes[id(update)]
                for bit in bits_of(open_entries(update.make, self.whole.compiler.fluents.whether) & made):
                    self._opened.setdefault(bit, []).append((action.index, update))
                for bit in bits_of(made):
                    self._made.setdefault(bit, []).append((action.index, update))
                for bit in bits_of(cleared):
                    self._cleared.setdefault(bit, []).append((action.index, update))

    def _closed(self, tellable: int) -> int:
        """What actions and rules could tell, with what would follow from that."""
        tellable &= ~self.ones
        while True:
            before = tellable
            for propagator in self.whole.closure.propagators:
                if propagator.watches & tellable:
                    tellable |= propagator.makes & ~self.ones
            if tellable == before:
                return tellable

    def _actions(self, table: dict[int, list[tuple[int, Update]]], bit: int, kind: Kind) -> Iterator[Maker]:
        updates: dict[int, list[Update]] = {}
        for index, update in table.get(bit, ()):
            updates.setdefault(index, []).append(update)
        for index, found in sorted(updates.items()):
            action = self.whole.actions[index]
            yield Maker(kind, action.name, str(action), self._blocker(action, found))

    def _blocker(self, action: GroundAction, updates: Iterable[Update]) -> Query:
        if not action.precondition.possible(self.ones, self.zeros):
            return action.precondition
        return disjunction(update.condition for update in updates)

    def _sensing(self, bit: int) -> Iterator[Maker]:
        """Actions that sense what would tell."""
        for entry in self._told.get(bit, ()):
            yield from self._actions(self._opened, entry, "senses")

    def _rules(self, want: Want) -> Iterator[Maker]:
        for rule in self.whole.rules:
            if want.bit & (rule.make if want.is_set else rule.clear):
                name = "an update rule" if rule.place is None else f"the update rule at {where(rule.place)}"
                yield Maker("rule", name, name, rule.condition)

    def _entries(self, bit: int) -> Iterator[Maker]:
        """Inference from entries, if an action or a rule could tell something that it follows from."""
        own = self.words.meaning(bit).group
        for propagator in self.whole.closure.propagators:
            if not propagator.makes & bit:
                continue
            if isinstance(propagator, Entry) and not bit & propagator.mask:
                watched = propagator.watches & ~(own.mask if own is not None else 0)
                if watched & self._tellable:
                    yield Maker("entry", "an entry", f"that {entry_text(propagator)}", AnyOf(watched))
            elif isinstance(propagator, LastValue) and isinstance(own, TermBits):
                excluded = own.excluded & ~bit
                if excluded & self._tellable:
                    yield Maker("entry", "an entry", f"the last value left of {own.text}", AnyOf(excluded))
