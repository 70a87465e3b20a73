"""Ground actions and branchings: the two kinds of edge between knowledge states."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from kabo.knowledge.closure import Closure
from kabo.knowledge.entries import Entry, Trace
from kabo.knowledge.facts import AtomBits, ConjunctionBits, Group, TermBits
from kabo.knowledge.progression import Effects
from kabo.knowledge.queries import GeometricOracle, Query, optimistic, union
from kabo.knowledge.regression import before_closure, before_effects, why_contradiction
from kabo.language.formulas import GroundCall


@dataclass(frozen=True)
class RunTimeArgument:
    """An argument that is the value of a term and becomes known only at run time."""

    term: str

    def __str__(self) -> str:
        return self.term


@dataclass(frozen=True)
class GroundAction:
    """An action with its arguments; `sense` has the texts of the facts that executing the action senses."""

    name: str
    arguments: Mapping[str, "str | RunTimeArgument"] = field(hash=False)
    call: GroundCall | None
    sense: tuple[str, ...]
    precondition: Query
    effects: Effects
    closure: Closure = field(hash=False, repr=False, compare=False)
    index: int  # its position in the task: in the order of the file, then of the arguments
    cost: float = 1.0

    def __str__(self) -> str:
        return f"{self.name}({', '.join(map(str, self.arguments.values()))})"

    @cached_property
    def reads(self) -> int:
        """The mask of all bits on which the action's applicability and effects depend."""
        return self.precondition.reads | self.effects.reads

    def applicable(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Whether the preconditions hold; the existence of a motion is not checked here."""
        return self.precondition.holds(state, test)

    def after(self, state: int, test: GeometricOracle = optimistic) -> int | None:
        """The state after the action, before it has sensed; None if its effects contradict each other."""
        after = self.effects.after(state, test)
        if after is None or self.closure.is_empty:
            return after
        return self.closure.complete(after, state ^ after)

    def reasons(self, state: int, test: GeometricOracle = optimistic) -> int:
        """The reasons of all inferences that the closure draws after the action's effects, as a mask of bits."""
        updated = self.effects.after(state, test)
        return 0 if updated is None else _reasons(self.closure, state, updated)

    def needs(self, state: int, needed: int, test: GeometricOracle = optimistic) -> int:
        """Bits of `state` that make the action applicable and decide the bits `needed` of the state after it."""
        if not self.closure.is_empty:
            updated = self.effects.after(state, test)
            assert updated is not None, "explained is only what was done"
            trace: Trace = []
            after = self.closure.complete(updated, state ^ updated, trace)
            assert after is not None, "explained is only what was done"
            needed = before_closure(self.closure, trace, after, needed)
            needed |= self.closure.consistent_by(updated & ~state, self.effects.writes, trace)
        return self.precondition.support(state, test) | before_effects(self.effects, state, needed, test)


@dataclass(frozen=True)
class Choice:
    """One outcome of a branching: its name, the bits that it sets, and the bits that would contradict it."""

    outcome: str
    make: int
    against: int


@dataclass(frozen=True)
class Branching:
    """The branching of a plan on a Kw or Kv entry: an outcome for each truth value or possible value, in plan order."""

    entry: int
    mask: int
    fact: str
    choices: tuple[Choice, ...]
    closure: Closure = field(hash=False, repr=False, compare=False)
    keeps: bool = True  # whether the entry stays in the state once its outcome is known

    def outcomes(self, state: int) -> Iterator[tuple[str, int]]:
        """Each possible outcome with the state after it."""
        for choice in self.choices:
            after = self.after(state, choice)
            if after is not None:
                yield choice.outcome, after

    def after(self, state: int, choice: Choice, trace: Trace | None = None) -> int | None:
        """The state after the outcome; None if the outcome contradicts what is known."""
        if state & choice.against:
            return None
        made = state & (-1 if self.keeps else ~self.entry) | choice.make
        return made if self.closure.is_empty else self.closure.complete(made, state ^ made, trace)

    def reasons(self, state: int, outcome: str) -> int:
        """The reasons of all inferences that the closure draws after the outcome, as a mask of bits."""
        choice = next(choice for choice in self.choices if choice.outcome == outcome)
        return _reasons(self.closure, state, state | choice.make)

    def needs(self, state: int, outcome: str, needed: int) -> int:
        """Bits of `state` that decide the bits `needed` of the state after the outcome."""
        choice = next(choice for choice in self.choices if choice.outcome == outcome)
        if not self.closure.is_empty:
            trace: Trace = []
            after = self.after(state, choice, trace)
            assert after is not None, "explained is only what can happen"
            needed = before_closure(self.closure, trace, after, needed)
        return needed & ~choice.make & ~self.mask  # the outcome itself sets the bits of its group

    def excluded(self, state: int) -> int:
        """Bits of `state` that suffice to rule out every outcome that is impossible in it."""
        reasons = 0
        for choice in self.choices:
            against = state & choice.against
            if against:
                reasons |= against & -against
                continue
            trace: Trace = []
            if self.after(state, choice, trace) is None:
                reasons |= why_contradiction(trace) & ~(choice.make & ~state)
        return reasons


def _reasons(closure: Closure, state: int, updated: int) -> int:
    trace: Trace = []
    if not closure.is_empty:
        closure.complete(updated, state ^ updated, trace)
    return union(reason for _, reason in trace)


def branching_of(group: Group, closure: Closure, entry_of: Mapping[str, Entry]) -> Branching | None:
    """The branching on an atom, a term with a finite range or a conjunction; None for a number."""
    choices: tuple[Choice, ...]
    match group:
        case AtomBits():
            choices = (
                Choice("false", group.claim(False).makes, group.true),
                Choice("true", group.claim(True).makes, group.false),
            )
        case TermBits():
            choices = tuple(
                Choice(value, group.learned(value), group.known & ~bit | group.unequal.get(value, 0))
                for value, bit in group.equal.items()
            )
        case ConjunctionBits():
            both = union(part.makes for part in group.parts)
            against = union(part.fails for part in group.parts)
            choices = (Choice("false", entry_of[group.text].active, 0), Choice("true", both, against))
            return Branching(group.whether, group.mask, group.text, choices, closure, keeps=False)
        case _:
            return None
    return Branching(group.whether, group.mask, group.text, choices, closure)
