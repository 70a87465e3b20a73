"""The effects of an action on a knowledge state: all conditions are evaluated first, then all updates happen.

A bit that is both set and cleared is set (add wins over delete). A change of the world also removes the entries
about the changed groups. Afterwards the closure draws its inferences [kabo.knowledge.closure].
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from kabo.knowledge.entries import Entry
from kabo.knowledge.facts import AtomBits, ConjunctionBits, Group, NumberBits, TermBits
from kabo.knowledge.numbers import NumberTerm
from kabo.knowledge.queries import (
    FALSE,
    TRUE,
    AllOf,
    GeometricOracle,
    Query,
    bits_of,
    optimistic,
    union,
)


@dataclass(frozen=True)
class Assignment:
    """The assignment `f = expression`, evaluated in the state before the action.

    If the value of the expression is unknown, f becomes unknown; with `at_run_time`, Kv(f) then says that f will
    be known at run time.
    """

    bits: NumberBits
    value: NumberTerm
    at_run_time: bool = False


@dataclass(frozen=True)
class Update:
    """One compiled update: under the condition the bits `clear` are cleared, then the bits `make` set.

    `touch` has the bits of the group that the update changes in the world; it is 0 if the update only infers or
    senses. `entry` is the group whose truth or value will be known at run time by the update.
    """

    condition: Query
    clear: int
    make: int = 0
    touch: int = 0
    assignment: Assignment | None = None
    entry: Group | None = None
    static: bool = False  # whether its bits are those of static knowledge, not of states

    @cached_property
    def is_possible(self) -> bool:
        """Whether the update can ever happen: its condition is not the constant FALSE."""
        return self.condition != FALSE

    @cached_property
    def is_certain(self) -> bool:
        """Whether the update has no condition, so that it always happens."""
        return self.condition == TRUE

    @cached_property
    def writes(self) -> int:
        """The mask of all bits that the update may change, without those of entries that it removes."""
        return self.clear | self.make

    @cached_property
    def reads(self) -> int:
        """The mask of all bits that decide whether the update happens, and what it changes."""
        return self.condition.reads | (self.assignment.value.reads if self.assignment else 0)


@dataclass(frozen=True)
class Switch:
    """Conditional updates in a table, indexed by the bit of `mask` that the state has; it has at most one."""

    mask: int
    table: Mapping[int, tuple[int, int, int]]  # the bit that is set -> bits to clear, to make, and touched


@dataclass(frozen=True)
class Effects:
    """The effects of one ground action.

    `exclusive` has masks of bits that contradict each other, such as those of p and not p. An action that would
    set two bits of one mask is not applicable.
    """

    updates: tuple[Update, ...]
    entries: tuple[Entry, ...]  # those that its updates may remove
    conjunctions: tuple[ConjunctionBits, ...]  # those whose truth its updates may change
    exclusive: tuple[int, ...]
    clear: int  # of all unconditional updates
    make: int
    touch: int
    switches: tuple[Switch, ...]
    conditional: tuple[Update, ...]
    assigned: tuple[Update, ...]

    @cached_property
    def writes(self) -> int:
        """The mask of all bits that any update of the action may change."""
        dropped = union(entry.mask for entry in self.entries) | union(c.whether for c in self.conjunctions)
        return union(update.writes for update in self.updates) | dropped

    @cached_property
    def reads(self) -> int:
        """The mask of all bits that any update of the action reads."""
        return union(update.reads for update in self.updates)

    @cached_property
    def contested(self) -> int:
        """The bits for which updates may contradict each other."""
        return union(self.exclusive) | _assigned_twice(self.assigned)

    def after(self, state: int, test: GeometricOracle = optimistic) -> int | None:
        """The state after all updates, before the closure; None if the updates contradict each other."""
        clear, make, touch = self.clear, self.make, self.touch
        for switch in self.switches:
            found = switch.table.get(state & switch.mask)
            if found is not None:
                clear, make, touch = clear | found[0], make | found[1], touch | found[2]
        for update in self.conditional:
            if update.condition.holds(state, test):
                clear, make, touch = clear | update.clear, make | update.make, touch | update.touch
        if self.assigned:
            numbers = self._numbers(state, test)
            if numbers is None:
                return None
            clear, make = clear | numbers[0], make | numbers[1]
        for mask in self.exclusive:
            made = make & mask
            if made & (made - 1):
                return None
        for entry in self.entries:
            if entry.dropped_by(state, touch):
                clear |= entry.mask
        for conjunction in self.conjunctions:
            if conjunction.about & touch:
                clear |= conjunction.whether
        return state & ~clear | make

    def _numbers(self, state: int, test: GeometricOracle) -> tuple[int, int] | None:
        """The bits to clear and to set for assigned numbers; None if one number gets two values."""
        values: dict[NumberBits, tuple[float | None, bool]] = {}
        for update in self.assigned:
            if update.assignment is not None and update.condition.holds(state, test):
                new = update.assignment.value.value(state), update.assignment.at_run_time
                if values.setdefault(update.assignment.bits, new) != new:
                    return None
        made = 0
        for bits, (value, later) in values.items():
            made |= bits.encode(value) if value is not None else bits.whether if later else 0
        return union(bits.mask for bits in values), made


@dataclass(frozen=True)
class Lexicon:
    """The facts about bits that effects need: the contradictory bits, and the entries that can be removed."""

    entries: tuple[Entry, ...] = ()
    conjunctions: tuple[ConjunctionBits, ...] = ()
    values: Mapping[int, int] = field(
        default_factory=dict
    )  # bit of a known value -> bits of all values of its term
    contradictions: Mapping[int, tuple[int, ...]] = field(
        default_factory=dict
    )  # bit -> bits that cannot both be made

    # What was compiled so far, with its parts: actions share updates that do not depend on all of their arguments.
    switches: dict[tuple[int, ...], tuple[list[Update], Switch]] = field(default_factory=dict)
    effects: dict[tuple[int, ...], tuple[tuple[Update, ...], "Effects"]] = field(default_factory=dict)

    _at_odds: dict[int, tuple[int, ...]] = field(default_factory=dict)

    def at_odds(self, made: int) -> tuple[int, ...]:
        """The masks of contradictory bits that contain some bit of `made`, each mask once."""
        found = self._at_odds.get(made)
        if found is None:
            masks = [mask for bit in bits_of(made) for mask in self.contradictions.get(bit, ())]
            found = self._at_odds[made] = tuple(dict.fromkeys(masks))
        return found

    @staticmethod
    def of(groups: Iterable[Group], entries: Iterable[Entry] = ()) -> "Lexicon":
        """The lexicon of these groups and entries."""
        values: dict[int, int] = {}
        contradictions: dict[int, tuple[int, ...]] = {}
        conjunctions = []
        for group in groups:
            match group:
                case AtomBits():
                    contradictions |= dict.fromkeys((group.true, group.false), (group.known,))
                case TermBits():
                    values |= dict.fromkeys(group.equal.values(), group.known)
                    contradictions |= dict.fromkeys(group.equal.values(), (group.known,))
                    for value, bit in group.unequal.items():
                        contradictions[bit] = (group.equal[value] | bit,)
                case ConjunctionBits():
                    conjunctions.append(group)
        droppable = tuple(entry for entry in entries if entry.active)
        return Lexicon(droppable, tuple(conjunctions), values, contradictions)


def effects_of(updates: Sequence[Update], lexicon: Lexicon) -> Effects:
    """The effects with these updates; calls with the same update objects return the same result."""
    key = tuple(map(id, updates))
    if key not in lexicon.effects:
        lexicon.effects[key] = tuple(updates), _sorted(updates, lexicon)
    return lexicon.effects[key][1]


def _sorted(updates: Iterable[Update], lexicon: Lexicon) -> Effects:
    possible = tuple([update for update in updates if update.is_possible])
    plain = [update for update in possible if update.assignment is None]
    unconditional = [update for update in plain if update.is_certain]
    touched = union(update.touch for update in possible)
    switches, conditional = _switches([update for update in plain if not update.is_certain], lexicon)
    return Effects(
        updates=possible,
        entries=tuple(e for e in lexicon.entries if any(member.group.mask & touched for member in e.members)),
        conjunctions=tuple(c for c in lexicon.conjunctions if c.about & touched),
        exclusive=_exclusive(plain, lexicon),
        clear=union(update.clear for update in unconditional),
        make=union(update.make for update in unconditional),
        touch=union(update.touch for update in unconditional),
        switches=switches,
        conditional=conditional,
        assigned=tuple(update for update in possible if update.assignment is not None),
    )


def _switches(updates: list[Update], lexicon: Lexicon) -> tuple[tuple[Switch, ...], tuple[Update, ...]]:
    """Updates under values of the same term as one switch, and the other updates, one for equal conditions."""
    by_term: dict[int, list[Update]] = {}
    for update in updates:
        by_term.setdefault(_waits_for(update.condition, lexicon), []).append(update)
    rest = _merged(by_term.pop(0, []))
    switches = []
    for mask, group in by_term.items():
        if len(group) == 1:
            rest += group
            continue
        key = tuple(map(id, group))
        if key not in lexicon.switches:
            table = {u.condition.reads: (u.clear, u.make, u.touch) for u in _merged(group)}
            lexicon.switches[key] = group, Switch(mask, table)
        switches.append(lexicon.switches[key][1])
    return tuple(switches), tuple(rest)


def _merged(updates: list[Update]) -> list[Update]:
    merged: dict[Query, Update] = {}
    for update in updates:
        other = merged.get(update.condition)
        merged[update.condition] = update if other is None else _both(other, update)
    return list(merged.values())


def _both(one: Update, other: Update) -> Update:
    clear, make, touch = one.clear | other.clear, one.make | other.make, one.touch | other.touch
    return Update(one.condition, clear, make, touch)


def _waits_for(condition: Query, lexicon: Lexicon) -> int:
    """All value bits of a term if the condition is that a certain one of them is set; 0 for any other condition."""
    if isinstance(condition, AllOf) and condition.mask == condition.value:
        return lexicon.values.get(condition.mask, 0)
    return 0


def _exclusive(updates: list[Update], lexicon: Lexicon) -> tuple[int, ...]:
    """The masks of contradicting bits that two different updates set; one update never contradicts itself."""
    made: dict[int, int] = {}
    contested: dict[int, int] = {}
    for update in updates:
        for mask in lexicon.at_odds(update.make):
            bits = update.make & mask
            if made.setdefault(mask, bits) != bits:
                contested[mask] = contested.get(mask, made[mask]) | bits
    return tuple(sorted(set(contested.values())))


def _assigned_twice(assigned: tuple[Update, ...]) -> int:
    seen = twice = 0
    for update in assigned:
        bits = update.assignment.bits.mask if update.assignment else 0
        twice |= bits & seen
        seen |= bits
    return twice
