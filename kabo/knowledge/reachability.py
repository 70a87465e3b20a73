"""The delete relaxation over knowledge: what could ever become known, and which goals never can."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kabo.knowledge.actions import Branching, GroundAction
from kabo.knowledge.closure import Closure
from kabo.knowledge.entries import Entry
from kabo.knowledge.progression import Update
from kabo.knowledge.queries import All, AllOf, Query, bits_of, union
from kabo.knowledge.task import Task


@dataclass(frozen=True)
class Reach:
    """Bits that can be 1 and bits that can be 0, the actions that can ever apply, and the number of layers.

    `history` are the bits that can be 1, and those that can be 0, in each layer, the start (layer 0) first.
    """

    ones: int
    zeros: int
    actions: tuple[GroundAction, ...]
    layers: int
    history: tuple[tuple[int, int], ...] = ()


def relaxed_reach(
    initial: int,
    actions: Sequence[GroundAction],
    branchings: Mapping[int, Branching],
    closure: Closure,
    *,
    by_layers: bool = True,
) -> Reach:
    """The fixpoint of applying all actions without ever losing a bit value that was possible.

    Every state that a plan can reach is contained: a bit outside `ones` is 0 in all of them. Without `by_layers` an
    action already sees what those before it in the same round made: fewer rounds, the same fixpoint.
    """
    learning = _Learning(branchings, closure)
    ones, zeros = learning.after(initial, ~initial)
    doing = _Doing(actions)
    layers, history = 0, [(ones, zeros)]
    while True:
        now = ones, zeros, len(doing.reached)
        ones, zeros = learning.after(*doing.after(ones, zeros, at_once=not by_layers))
        if (ones, zeros, len(doing.reached)) == now:
            used = tuple(action for action in actions if action.index in doing.reached)
            return Reach(ones, zeros, used, layers, tuple(history))
        layers += 1
        history.append((ones, zeros))


def unreachable_goals(task: Task) -> list[str]:
    """The goal conjuncts out of reach even if nothing were ever lost, as text in the order of the file."""
    reach = relaxed_reach(task.initial, task.actions, task.branchings, task.closure)
    return [part.text for part in task.goal if not part.query.possible(reach.ones, reach.zeros)]


class _Doing:
    """What actions may add to bits that are possible. What has been possible once is not looked at again."""

    def __init__(self, actions: Sequence[GroundAction]) -> None:
        self.reached: set[int] = set()  # indices of the actions that can apply
        self._waiting = [(0, action) for action in actions]  # each with a bit that it lacks, 0 if none is known
        self._updates: dict[int, Update] = {}  # of actions that can apply; they share many
        self._done: set[int] = set()  # those of them that have been possible

    def after(self, ones: int, zeros: int, *, at_once: bool) -> tuple[int, int]:
        """The bits that can be 1 and those that can be 0 after one round; `at_once` an action sees what others made."""
        new_ones, new_zeros = ones, zeros
        for update in list(self._updates.values()):
            if update.condition.possible(ones, zeros):
                new_ones, new_zeros = self._with(update, new_ones, new_zeros)
        waiting, self._waiting = self._waiting, []
        for lacking, action in waiting:
            if at_once:
                ones, zeros = new_ones, new_zeros
            if lacking & ~ones:
                self._waiting.append((lacking, action))
                continue
            if not action.precondition.possible(ones, zeros):
                self._waiting.append((_lacking(action.precondition, ones), action))
                continue
            self.reached.add(action.index)
            new_zeros |= union(entry.mask for entry in action.effects.entries)
            for update in action.effects.updates:
                if id(update) in self._done:
                    continue
                if update.condition.possible(ones, zeros):
                    new_ones, new_zeros = self._with(update, new_ones, new_zeros)
                else:
                    self._updates[id(update)] = update
        return new_ones, new_zeros

    def _with(self, update: Update, ones: int, zeros: int) -> tuple[int, int]:
        self._done.add(id(update))
        self._updates.pop(id(update), None)
        return ones | update.make | (update.assignment.bits.mask if update.assignment else 0), zeros | update.clear


def _lacking(query: Query, ones: int) -> int:
    """A bit outside `ones` that the query asks for; 0 if its first part tells of none."""
    part = query.parts[0] if isinstance(query, All) else query
    lacking = part.value & ~ones if isinstance(part, AllOf) else 0
    return lacking & -lacking


class _Learning:
    """What branching and inference may add to bits that are possible."""

    def __init__(self, branchings: Mapping[int, Branching], closure: Closure) -> None:
        self._branchings, self._closure = dict(branchings), closure
        self._waiting = dict(enumerate(closure.propagators))

    def after(self, ones: int, zeros: int) -> tuple[int, int]:
        """The bits that can be 1, and those that can be 0, once everything that could be inferred is."""
        while True:
            before = ones, zeros
            for entry in bits_of(ones & union(self._branchings)):
                branching = self._branchings.pop(entry)
                made = union(choice.make for choice in branching.choices)
                ones, zeros = ones | made, zeros | branching.mask
            for number, propagator in list(self._waiting.items()):
                told = propagator.holds | propagator.fails if isinstance(propagator, Entry) else propagator.watches
                if told & ones:
                    del self._waiting[number]
                    ones, zeros = ones | propagator.makes, zeros | getattr(propagator, "mask", 0)
            for rule in self._closure.rules:
                if rule.condition.possible(ones, zeros):
                    ones, zeros = ones | rule.make, zeros | rule.clear
            for monitor in self._closure.monitors:
                zeros |= monitor.held
            if (ones, zeros) == before:
                return before
