"""Knowledge that no longer matters: facts that only dead actions read.

An action is dead in a state if a literal of its precondition is false and can never become true again: it has no
achiever, or only achievers that are dead for the same reason. A dead action stays dead. So two states that differ only
in facts that dead actions read have the same plans; search nodes are compared without such facts. (Whether a cup that
was carried away may spill is such a fact: FORCE SENSING has 2^n nodes instead of 3^n.)
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from kabo.knowledge.actions import Branching, GroundAction
from kabo.knowledge.closure import Closure
from kabo.knowledge.facts import open_entries
from kabo.knowledge.progression import Effects
from kabo.knowledge.queries import Query, bits_of, split, union

_Cube = tuple[int, int]  # (mask, value), a conjunction of literals: the bits of the mask have the value


@dataclass(frozen=True)
class _Death:
    """The condition of being dead: a literal of `cube` is false, or one of `waiting` is, and all its achievers are dead."""

    cube: _Cube  # literals that have no achiever
    waiting: tuple[
        tuple[_Cube, tuple[_Cube, ...]], ...
    ]  # a literal, and for each achiever its literals without one

    def happened(self, state: int) -> bool:
        """Whether the action is dead in the state."""
        mask, value = self.cube
        if state & mask != value:
            return True
        for (mask, value), achievers in self.waiting:  # noqa: SIM110  called too often for a generator
            if state & mask != value and _all_fail(achievers, state):
                return True
        return False

    @property
    def is_possible(self) -> bool:
        """Whether the action can ever be dead."""
        return bool(self.cube[0] or self.waiting)

    @property
    def reads(self) -> int:
        """The bits that decide whether the action is dead."""
        return self.cube[0] | union(
            literal | union(achiever for achiever, _ in achievers) for (literal, _), achievers in self.waiting
        )


def _all_fail(cubes: Iterable[_Cube], state: int) -> bool:
    for mask, value in cubes:  # noqa: SIM110  called too often for a generator
        if state & mask == value:
            return False
    return True


@dataclass(frozen=True)
class _Droppable:
    """A group of bits, when each action that reads it is dead, and the bits that decide whether the group is obsolete."""

    group: int
    readers: tuple[_Death, ...]
    deciding: int

    def is_obsolete(self, state: int) -> bool:
        """Whether all actions that read the group are dead."""
        for death in self.readers:  # noqa: SIM110  called too often for a generator
            if not death.happened(state):
                return False
        return True


class Relevance:
    """Removes from states the knowledge that only dead actions read; its tables are made when first needed."""

    def __init__(
        self,
        actions: Iterable[GroundAction],
        goal: Query,
        branchings: Mapping[int, Branching],
        closure: Closure,
        groups: Iterable[int],
    ) -> None:
        self._actions, self._goal, self._groups = tuple(actions), goal, groups
        self._branchings, self._closure = branchings, closure
        self._entries = union(branchings)
        self._dropped: dict[int, int] = {}  # deciding bits of a state -> the obsolete bits
        self._last = 0  # the deciding bits of the last question

    @cached_property
    def _droppable(self) -> list[_Droppable]:
        found: list[_Droppable] = []
        kept = self._goal.reads | self._closure.reads
        groups = [group for group in self._groups if not group & kept]
        if not groups:
            return found
        achievers = _Achievers(self._actions, self._branchings, self._closure)
        deaths: dict[int, _Death] = {}

        def death(action: GroundAction) -> _Death:
            if action.index not in deaths:
                deaths[action.index] = achievers.death(action)
            return deaths[action.index]

        for group, reading in _readers(self._actions, groups):
            if not all(death(action).is_possible for action in reading):
                continue
            readers = tuple(death(action) for action in reading)
            found.append(_Droppable(group, readers, union(reader.reads for reader in readers)))
        self._dropped[0] = union(one.group for one in found if one.is_obsolete(0))
        return found

    @cached_property
    def _deciding(self) -> int:
        return union(one.deciding for one in self._droppable)

    @cached_property
    def _decided(self) -> dict[int, list[_Droppable]]:
        """For each deciding bit the groups for which it matters."""
        decided: dict[int, list[_Droppable]] = {}
        for one in self._droppable:
            for bit in bits_of(one.deciding):
                decided.setdefault(bit, []).append(one)
        return decided

    def reduced(self, state: int) -> int:
        """The state without knowledge that only dead actions read; unchanged while a branching is still open."""
        if not self._droppable or open_entries(state, self._entries):
            return state
        deciding = state & self._deciding
        dropped = self._dropped.get(deciding)
        if dropped is None:
            dropped = self._dropped[deciding] = self._changed(
                self._dropped[self._last], deciding ^ self._last, state
            )
            self._last = deciding
        return state & ~dropped

    def _changed(self, dropped: int, changed: int, state: int) -> int:
        """The obsolete bits; only groups for which the changed bits matter are computed anew."""
        again = {one.group: one for bit in bits_of(changed) for one in self._decided[bit]}
        return dropped & ~union(again) | union(group for group, one in again.items() if one.is_obsolete(state))


def _readers(actions: Iterable[GroundAction], groups: Iterable[int]) -> Iterator[tuple[int, list[GroundAction]]]:
    """Each group of bits with the actions that read any of them."""
    groups = list(groups)
    home = {bit: number for number, group in enumerate(groups) for bit in bits_of(group)}
    reading: list[dict[int, GroundAction]] = [{} for _ in groups]
    every = union(groups)
    for action in actions:
        for bit in bits_of(action.reads & every):
            reading[home[bit]][action.index] = action
    return zip(groups, (list(found.values()) for found in reading), strict=True)


class _Achievers:
    """The achievers of each literal."""

    def __init__(
        self, actions: tuple[GroundAction, ...], branchings: Mapping[int, Branching], closure: Closure
    ) -> None:
        self._by_sensing = (
            union(branching.mask for branching in branchings.values()) | closure.makes | closure.clears
        )
        written: dict[int, tuple[int, int]] = {}  # actions share effects
        for action in actions:
            if id(action.effects) not in written:
                written[id(action.effects)] = _written(action.effects)
        self._made = union(made for made, _ in written.values())
        self._cleared = union(cleared for _, cleared in written.values())
        self._tests = {action.index: split(action.precondition)[:2] for action in actions}
        self._finals = {index: self._final(*test) for index, test in self._tests.items()}
        self._written = [(self._finals[action.index], *written[id(action.effects)]) for action in actions]
        self._always_made = union(made for final, made, _ in self._written if not final[0]) | self._by_sensing
        self._always_cleared = (
            union(cleared for final, _, cleared in self._written if not final[0]) | self._by_sensing
        )

    @cached_property
    def _writers(self) -> tuple[dict[int, list[_Cube]], dict[int, list[_Cube]]]:
        """For each bit the literals without achiever of each action that may set it, and of each that may clear it.

        Only for bits that some precondition reads and that no action without such literals writes.
        """
        ones = union(value for _, value in self._tests.values()) & ~self._always_made
        zeros = union(mask & ~value for mask, value in self._tests.values()) & ~self._always_cleared
        setting: dict[int, list[_Cube]] = {}
        clearing: dict[int, list[_Cube]] = {}
        for final, made, cleared in self._written:
            for bit in bits_of(made & ones):
                setting.setdefault(bit, []).append(final)
            for bit in bits_of(cleared & zeros):
                clearing.setdefault(bit, []).append(final)
        return setting, clearing

    def death(self, action: GroundAction) -> _Death:
        """The condition under which the action is dead."""
        final = self._finals[action.index]
        mask, value = self._tests[action.index]
        ones, zeros = value & ~self._always_made, mask & ~value & ~self._always_cleared
        setting, clearing = self._writers
        waiting = tuple(
            ((bit, value & bit), tuple((setting if value & bit else clearing).get(bit, ())))
            for bit in bits_of((ones | zeros) & ~final[0])
        )
        return _Death(final, waiting)

    def _final(self, mask: int, value: int) -> _Cube:
        """The literals of a precondition that have no achiever."""
        lost = (value & ~self._made | mask & ~value & ~self._cleared) & ~self._by_sensing
        return lost, value & lost


def _written(effects: Effects) -> tuple[int, int]:
    """The bits that an action with these effects may set, and those that it may clear."""
    made = union(update.make for update in effects.updates)
    made |= union(update.assignment.bits.mask for update in effects.assigned if update.assignment)
    return made, effects.writes
