"""Knowledge that no longer matters: facts that only dead actions would read.

An action is dead in a state if a literal of its precondition fails and nothing can make it hold again: no action
writes it so, or only actions that are dead for that reason themselves. What is dead stays dead. So two states that
differ in a fact which only dead actions read have the same plans; search nodes are told apart without such facts.
(Whether a cup that was carried away may spill is such a fact: FORCE SENSING has 2^n such nodes instead of 3^n.)
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from kabo.knowledge.actions import Branching, GroundAction
from kabo.knowledge.closure import Closure
from kabo.knowledge.facts import open_entries
from kabo.knowledge.queries import AllOf, Query, bits_of, split, union


@dataclass(frozen=True)
class _Death:
    """When an action is dead: a literal of `cube` fails, or one of `waiting` fails and all its makers are dead."""

    cube: AllOf  # what nothing can make hold again
    waiting: tuple[
        tuple[AllOf, tuple[AllOf, ...]], ...
    ]  # a literal, and for each of its makers what it cannot regain

    def happened(self, state: int) -> bool:
        """Whether the action is dead in the state."""
        if state & self.cube.mask != self.cube.value:
            return True
        return any(
            state & literal.mask != literal.value and all(state & maker.mask != maker.value for maker in makers)
            for literal, makers in self.waiting
        )

    @property
    def is_possible(self) -> bool:
        """Whether it can ever happen."""
        return bool(self.cube.mask or self.waiting)

    @property
    def reads(self) -> int:
        """The bits that decide it."""
        return self.cube.mask | union(
            literal.mask | union(maker.mask for maker in makers) for literal, makers in self.waiting
        )


@dataclass(frozen=True)
class _Droppable:
    """A group of bits, all actions that read it, and what decides whether it is obsolete."""

    group: int
    readers: tuple[_Death, ...]
    deciding: int

    def is_obsolete(self, state: int) -> bool:
        """Whether all its readers are dead."""
        return all(death.happened(state) for death in self.readers)


class Relevance:
    """Drops from states what only dead actions would read; found out when it is first asked for."""

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
        self._dropped: dict[int, int] = {}  # deciding bits of a state -> what is obsolete there
        self._last = 0  # those that were asked for last

    @cached_property
    def _droppable(self) -> list[_Droppable]:
        makers = _Makers(self._actions, self._branchings, self._closure)
        found: list[_Droppable] = []
        deaths: dict[int, _Death] = {}

        def death(action: GroundAction) -> _Death:
            if action.index not in deaths:
                deaths[action.index] = makers.death(action)
            return deaths[action.index]

        for group, reading in _readers(self._actions, self._groups):
            read = (self._goal.reads | self._closure.reads) & group
            if read or not all(death(action).is_possible for action in reading):
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
        """For each deciding bit the groups that it decides about."""
        decided: dict[int, list[_Droppable]] = {}
        for one in self._droppable:
            for bit in bits_of(one.deciding):
                decided.setdefault(bit, []).append(one)
        return decided

    def reduced(self, state: int) -> int:
        """The state without what no longer matters; while an entry stands open, everything does."""
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
        """What is obsolete: only what the changed bits decide about is asked again."""
        again = {one.group: one for bit in bits_of(changed) for one in self._decided[bit]}
        return dropped & ~union(again) | union(group for group, one in again.items() if one.is_obsolete(state))


def _readers(actions: Iterable[GroundAction], groups: Iterable[int]) -> Iterator[tuple[int, list[GroundAction]]]:
    """Each group of bits with the actions that read any of them."""
    groups = list(groups)
    home = {bit: number for number, group in enumerate(groups) for bit in bits_of(group)}
    reading: list[dict[int, GroundAction]] = [{} for _ in groups]
    for action in actions:
        for bit in bits_of(action.reads):
            if bit in home:
                reading[home[bit]][action.index] = action
    return zip(groups, (list(found.values()) for found in reading), strict=True)


class _Makers:
    """Which actions can make a literal hold."""

    def __init__(
        self, actions: tuple[GroundAction, ...], branchings: Mapping[int, Branching], closure: Closure
    ) -> None:
        self._by_sensing = (
            union(branching.mask for branching in branchings.values()) | closure.makes | closure.clears
        )
        self._finals: dict[int, AllOf] = {}
        self._written = [(action, *_written(action)) for action in actions]
        self._made = union(made for _, made, _ in self._written)
        self._cleared = union(cleared for *_, cleared in self._written)
        immortal = [(made, cleared) for action, made, cleared in self._written if not self._final(action).mask]
        self._always_made = union(made for made, _ in immortal) | self._by_sensing
        self._always_cleared = union(cleared for _, cleared in immortal) | self._by_sensing

    @cached_property
    def _writers(self) -> tuple[dict[int, list[AllOf]], dict[int, list[AllOf]]]:
        """For each bit what the actions that may set it cannot regain, and those that may clear it.

        Only for bits that some precondition asks for, and that no action can always write.
        """
        tests = [split(action.precondition) for action, *_ in self._written]
        ones = union(value for _, value, _ in tests) & ~self._always_made
        zeros = union(mask & ~value for mask, value, _ in tests) & ~self._always_cleared
        setting: dict[int, list[AllOf]] = {}
        clearing: dict[int, list[AllOf]] = {}
        for action, made, cleared in self._written:
            for bit in bits_of(made & ones):
                setting.setdefault(bit, []).append(self._final(action))
            for bit in bits_of(cleared & zeros):
                clearing.setdefault(bit, []).append(self._final(action))
        return setting, clearing

    def death(self, action: GroundAction) -> _Death:
        """When the action is dead."""
        final = self._final(action)
        mask, value, _ = split(action.precondition)
        ones, zeros = value & ~self._always_made, mask & ~value & ~self._always_cleared
        setting, clearing = self._writers
        waiting = tuple(
            (AllOf(bit, value & bit), tuple((setting if value & bit else clearing).get(bit, ())))
            for bit in bits_of((ones | zeros) & ~final.mask)
        )
        return _Death(final, waiting)

    def _final(self, action: GroundAction) -> AllOf:
        """The literals of the precondition that nothing can make hold again once they fail."""
        known = self._finals.get(action.index)
        if known is not None:
            return known
        mask, value, _ = split(action.precondition)
        lost = (value & ~self._made | mask & ~value & ~self._cleared) & ~self._by_sensing
        self._finals[action.index] = AllOf(lost, value & lost)
        return self._finals[action.index]


def _written(action: GroundAction) -> tuple[int, int]:
    """The bits that an action may set, and those that it may clear."""
    made = union(update.make for update in action.effects.updates)
    made |= union(update.assignment.bits.mask for update in action.effects.assigned if update.assignment)
    return made, action.effects.writes
