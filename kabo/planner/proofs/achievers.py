"""The achievers of a fact: actions, sensing, rules and entries that could make it true; and what blocks each."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

from kabo.knowledge import GroundAction, Query
from kabo.knowledge.entries import Entry, LastValue
from kabo.knowledge.facts import TermBits, open_entries
from kabo.knowledge.grounding.problem import Grounding
from kabo.knowledge.progression import Update
from kabo.knowledge.queries import AnyOf, bits_of, disjunction, union
from kabo.planner.proofs.wording import BitMeanings, MissingFact, entry_text, missing_facts, where

Kind = Literal["does", "senses", "rule", "entry"]


@dataclass(frozen=True)
class Achiever:
    """Something that would make a missing fact true if its condition `blocker`, which never holds, did hold.

    `family`: the action schema to which an action belongs.
    """

    kind: Kind
    family: str
    name: str
    blocker: Query


class Achievers:
    """Finds the achievers of facts that the delete relaxation cannot reach."""

    def __init__(self, whole: Grounding, meanings: BitMeanings) -> None:
        self.whole, self.meanings = whole, meanings
        self.ones, self.zeros = whole.reach.ones, whole.reach.zeros
        self._made: dict[int, list[tuple[int, Update]]] = {}
        self._opened: dict[int, list[tuple[int, Update]]] = {}
        self._cleared: dict[int, list[tuple[int, Update]]] = {}
        self._revealed_by: dict[int, list[int]] = {}  # bit -> the bits of Kw and Kv whose outcomes would set it
        self._index()
        for entry, branching in whole.splits.items():
            for bit in bits_of(union(choice.make for choice in branching.choices) & ~self.ones & ~entry):
                if entry in self._opened:
                    self._revealed_by.setdefault(bit, []).append(entry)
        self._learnable = self._closed(
            union(self._made) | union(self._revealed_by) | union(r.make for r in whole.rules)
        )

    def of(self, fact: MissingFact) -> list[Achiever]:
        """The achievers of a missing fact: actions, sensing, rules and entries, in the order of the file."""
        if not fact.is_set:
            return [*self._actions(self._cleared, fact.bit, "does"), *self._rules(fact)]
        found = [*self._actions(self._made, fact.bit, "does")]
        done = {achiever.name for achiever in found}
        found += [achiever for achiever in self._sensing(fact.bit) if achiever.name not in done]
        return [*found, *self._rules(fact), *self._entries(fact.bit)]

    def missing_facts(self, achiever: Achiever) -> list[MissingFact]:
        """The facts that an achiever's condition requires and that can never hold."""
        return list(dict.fromkeys(missing_facts(achiever.blocker, self.ones, self.zeros)))

    def _index(self) -> None:
        """Indexes the actions that would set bits which are never 1, or clear bits which are never 0."""
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

    def _closed(self, learnable: int) -> int:
        """The bits that actions and rules could set, closed under inference."""
        learnable &= ~self.ones
        while True:
            before = learnable
            for propagator in self.whole.closure.propagators:
                if propagator.watches & learnable:
                    learnable |= propagator.makes & ~self.ones
            if learnable == before:
                return learnable

    def _actions(self, table: dict[int, list[tuple[int, Update]]], bit: int, kind: Kind) -> Iterator[Achiever]:
        updates: dict[int, list[Update]] = {}
        for index, update in table.get(bit, ()):
            updates.setdefault(index, []).append(update)
        for index, found in sorted(updates.items()):
            action = self.whole.actions[index]
            yield Achiever(kind, action.name, str(action), self._blocker(action, found))

    def _blocker(self, action: GroundAction, updates: Iterable[Update]) -> Query:
        if not action.precondition.possible(self.ones, self.zeros):
            return action.precondition
        return disjunction(update.condition for update in updates)

    def _sensing(self, bit: int) -> Iterator[Achiever]:
        """Actions that sense something whose outcome would set the bit."""
        for entry in self._revealed_by.get(bit, ()):
            yield from self._actions(self._opened, entry, "senses")

    def _rules(self, fact: MissingFact) -> Iterator[Achiever]:
        for rule in self.whole.rules:
            if fact.bit & (rule.make if fact.is_set else rule.clear):
                name = "an update rule" if rule.place is None else f"the update rule at {where(rule.place)}"
                yield Achiever("rule", name, name, rule.condition)

    def _entries(self, bit: int) -> Iterator[Achiever]:
        """Inference from entries, if an action or a rule could set something that it follows from."""
        own = self.meanings.meaning(bit).group
        for propagator in self.whole.closure.propagators:
            if not propagator.makes & bit:
                continue
            if isinstance(propagator, Entry) and not bit & propagator.mask:
                watched = propagator.watches & ~(own.mask if own is not None else 0)
                if watched & self._learnable:
                    yield Achiever("entry", "an entry", f"that {entry_text(propagator)}", AnyOf(watched))
            elif isinstance(propagator, LastValue) and isinstance(own, TermBits):
                excluded = own.excluded & ~bit
                if excluded & self._learnable:
                    yield Achiever("entry", "an entry", f"the last value left of {own.text}", AnyOf(excluded))
