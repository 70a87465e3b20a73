"""What an action does to a knowledge state, and what of the state before it needs for a given outcome.

All conditions are read in the state before, then all updates happen; add wins over delete. Progression and
regression stand side by side because they must agree bit by bit.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from kabo.knowledge.facts import AtomBits, Group, NumberBits, TermBits
from kabo.knowledge.queries import FALSE, TRUE, GeometricOracle, NumberTerm, Query, optimistic, union


@dataclass(frozen=True)
class Assignment:
    """`f = expression`, read in the state before; an unknown value of the expression makes f unknown."""

    bits: NumberBits
    value: NumberTerm


@dataclass(frozen=True)
class Update:
    """One compiled update: under the condition, first `clear` then `make` bits of the group."""

    group: Group
    condition: Query
    clear: int
    make: int = 0
    assignment: Assignment | None = None

    @property
    def writes(self) -> int:
        """All bits that it may change."""
        return self.clear | self.make

    @property
    def reads(self) -> int:
        """All bits that decide whether and what it changes."""
        return self.condition.reads | (self.assignment.value.reads if self.assignment else 0)


@dataclass(frozen=True)
class Settlement:
    """Normal form: once a bit of `known` is set, the entries `implied` (Kw, Kv, f != v) are redundant."""

    known: int
    implied: int


@dataclass(frozen=True)
class Effects:
    """The effects of one ground action.

    `exclusive` are masks of bits of which one action must not make two: adding p and not p at once is a
    contradiction, and an action that would do so is not applicable.
    """

    updates: tuple[Update, ...]
    settlements: tuple[Settlement, ...] = ()
    exclusive: tuple[int, ...] = ()
    clear: int = 0  # of all unconditional updates
    make: int = 0
    conditional: tuple[Update, ...] = ()
    assigned: tuple[Update, ...] = ()
    contested: int = field(default=0)  # bits for which contradictions can happen

    @property
    def writes(self) -> int:
        """All bits that any update may change, normal form included."""
        return union(update.writes for update in self.updates) | union(rule.implied for rule in self.settlements)

    def after(self, state: int, test: GeometricOracle = optimistic) -> int | None:
        """The state after the action, or None if its updates contradict each other."""
        clear, make = self.clear, self.make
        for update in self.conditional:
            if update.condition.holds(state, test):
                clear |= update.clear
                make |= update.make
        if self.assigned:
            numbers = self._numbers(state, test)
            if numbers is None:
                return None
            clear, make = clear | numbers[0], make | numbers[1]
        for mask in self.exclusive:
            made = make & mask
            if made & (made - 1):
                return None
        state = state & ~clear | make
        for rule in self.settlements:
            if state & rule.known:
                state &= ~rule.implied
        return state

    def _numbers(self, state: int, test: GeometricOracle) -> tuple[int, int] | None:
        """Bits to clear and to make for assigned numbers; None if one number gets two values."""
        values: dict[NumberBits, float | None] = {}
        for update in self.assigned:
            if update.assignment is not None and update.condition.holds(state, test):
                value = update.assignment.value.value(state)
                if values.setdefault(update.assignment.bits, value) != value:
                    return None
        clear = union(bits.mask for bits in values)
        return clear, union(bits.encode(value) for bits, value in values.items() if value is not None)

    def needs(self, state: int, needed: int, test: GeometricOracle = optimistic) -> int:
        """Bits of the state before that fix the bits `needed` of the state after, and that there is one at all."""
        for rule in self.settlements:
            if needed & rule.implied:
                needed |= rule.known | rule.implied
        relevant, before, kept = needed | self.contested, 0, needed
        for update in self.updates:
            if not update.writes & relevant:
                continue
            before |= update.condition.support(state, test)
            if update.condition.holds(state, test):
                kept &= ~update.writes
                if update.assignment is not None:
                    before |= update.assignment.value.reads
        return before | kept


def effects_of(updates: Iterable[Update]) -> Effects:
    """Sorts updates by what they need: unconditional ones become one mask, contradictions are looked for once."""
    possible = tuple(update for update in updates if update.condition != FALSE)
    plain = [update for update in possible if update.assignment is None]
    unconditional = [update for update in plain if update.condition == TRUE]
    assigned = tuple(update for update in possible if update.assignment is not None)
    exclusive = _exclusive(plain)
    return Effects(
        updates=possible,
        settlements=_settlements(possible),
        exclusive=exclusive,
        clear=union(update.clear for update in unconditional),
        make=union(update.make for update in unconditional),
        conditional=_merged(update for update in plain if update.condition != TRUE),
        assigned=assigned,
        contested=union(exclusive) | _assigned_twice(assigned),
    )


def _merged(updates: Iterable[Update]) -> tuple[Update, ...]:
    """Updates with equal conditions as one (the group of the first stands for all)."""
    merged: dict[Query, Update] = {}
    for update in updates:
        other = merged.get(update.condition)
        clear, make = (other.clear, other.make) if other else (0, 0)
        merged[update.condition] = Update(update.group, update.condition, clear | update.clear, make | update.make)
    return tuple(merged.values())


def _settlements(updates: tuple[Update, ...]) -> tuple[Settlement, ...]:
    made = union(update.make for update in updates)
    rules = []
    for group in dict.fromkeys(update.group for update in updates):
        implied = group.mask & ~(group.field if isinstance(group, NumberBits) else group.known)
        if made & implied:
            rules.append(Settlement(group.known, implied))
    return tuple(rules)


def _exclusive(updates: list[Update]) -> tuple[int, ...]:
    made = union(update.make for update in updates)
    masks = [mask & made for group in dict.fromkeys(u.group for u in updates) for mask in _contradictions(group)]
    return tuple(mask for mask in masks if mask & (mask - 1))


def _contradictions(group: Group) -> list[int]:
    """Sets of bits of a group of which at most one can be known at a time."""
    match group:
        case AtomBits():
            return [group.known]
        case TermBits():
            return [group.known, *(group.equal[value] | bit for value, bit in group.unequal.items())]
    return []


def _assigned_twice(assigned: tuple[Update, ...]) -> int:
    seen = twice = 0
    for update in assigned:
        twice |= update.writes & seen
        seen |= update.writes
    return twice
