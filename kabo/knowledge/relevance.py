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
    """A group of bits and what decides whether it is obsolete; answers are kept by the bits that they rest on."""

    group: int
    readers: tuple[_Death, ...]
    deciding: int
    answers: dict[int, bool]

    def is_obsolete(self, state: int) -> bool:
        """Whether all its readers are dead."""
        read = state & self.deciding
        answer = self.answers.get(read)
        if answer is None:
            answer = self.answers[read] = all(death.happened(state) for death in self.readers)
        return answer


class Relevance:
    """Drops from states what only dead actions would read."""

    def __init__(
        self,
        actions: Iterable[GroundAction],
        goal: Query,
        branchings: Mapping[int, Branching],
        closure: Closure,
        groups: Iterable[int],
    ) -> None:
        actions = tuple(actions)
        makers = _Makers(actions, branchings, closure)
        deaths: dict[int, _Death] = {}

        def death(action: GroundAction) -> _Death:
            if action.index not in deaths:
                deaths[action.index] = makers.death(action)
            return deaths[action.index]

        self._droppable: list[_Droppable] = []
        for group, reading in _readers(actions, groups):
            if (goal.reads | closure.reads) & group or not all(death(action).is_possible for action in reading):
                continue
            readers = tuple(death(action) for action in reading)
            deciding = union(reader.reads for reader in readers)
            self._droppable.append(_Droppable(group, readers, deciding, {}))
        self._entries = union(branchings)
        self._deciding = union(one.deciding for one in self._droppable)
        self._kept: dict[int, int] = {}

    def reduced(self, state: int) -> int:
        """The state without what no longer matters; while an entry stands open, everything does."""
        if not self._droppable or open_entries(state, self._entries):
            return state
        deciding = state & self._deciding
        kept = self._kept.get(deciding)
        if kept is None:
            kept = self._kept[deciding] = ~union(o.group for o in self._droppable if o.is_obsolete(state))
        return state & kept


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

    @cached_property
    def _writers(self) -> tuple[dict[int, list[GroundAction]], dict[int, list[GroundAction]]]:
        """For each bit the actions that may set it, and those that may clear it."""
        setting: dict[int, list[GroundAction]] = {}
        clearing: dict[int, list[GroundAction]] = {}
        for action, made, cleared in self._written:
            for bit in bits_of(made):
                setting.setdefault(bit, []).append(action)
            for bit in bits_of(cleared):
                clearing.setdefault(bit, []).append(action)
        return setting, clearing

    def death(self, action: GroundAction) -> _Death:
        """When the action is dead."""
        final = self._final(action)
        mask, value, _ = split(action.precondition)
        setting, clearing = self._writers
        waiting = []
        for bit in bits_of(mask & ~(final.mask | self._by_sensing)):
            writers = (setting if value & bit else clearing).get(bit, ())
            makers = tuple(self._final(maker) for maker in writers)
            if all(maker.mask for maker in makers):
                waiting.append((AllOf(bit, value & bit), makers))
        return _Death(final, tuple(waiting))

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
