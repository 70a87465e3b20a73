"""The delete relaxation over knowledge: the facts that could ever become known, and the goals that never can."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kabo.knowledge.actions import Branching, GroundAction
from kabo.knowledge.closure import Closure
from kabo.knowledge.entries import Entry
from kabo.knowledge.progression import Update
from kabo.knowledge.queries import All, AllOf, Query, bits_of, union
from kabo.knowledge.task import GroundedTask


@dataclass(frozen=True)
class Reach:
    """The bits that can be 1, the bits that can be 0, the actions that can ever apply, and the number of layers.

    `history` has for each layer the bits that can be 1 and those that can be 0; the start is layer 0.
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
    """The fixpoint of applying all actions when no possible value of a bit is ever lost.

    It contains every state that a plan can reach: a bit outside `ones` is 0 in all of them. Without `by_layers` an
    action sees the results of earlier actions of the same round; that takes fewer rounds to the same fixpoint.
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


def unreachable_goals(task: GroundedTask) -> list[str]:
    """The texts of the goal conjuncts that are out of reach even in the delete relaxation, in the order of the file."""
    reach = relaxed_reach(task.initial, task.actions, task.branchings, task.closure)
    return [part.text for part in task.goal if not part.query.possible(reach.ones, reach.zeros)]


class _Doing:
    """Adds the values of bits that applicable actions make possible; actions found applicable are not tried again."""

    def __init__(self, actions: Sequence[GroundAction]) -> None:
        self.reached: set[int] = set()  # indices of the actions that can apply
        self._waiting = [(0, action) for action in actions]  # each with a bit that it lacks, 0 if none is known
        self._updates: dict[int, Update] = {}  # of actions that can apply; they share many
        self._done: set[int] = set()  # those of them that have been possible

    def after(self, ones: int, zeros: int, *, at_once: bool) -> tuple[int, int]:
        """The bits that can be 1 and those that can be 0 after one round.

        With `at_once` an action sees the results of those before it in the same round.
        """
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
    """A bit outside `ones` that the query requires to be 1; 0 if its first part names none."""
    part = query.parts[0] if isinstance(query, All) else query
    lacking = part.value & ~ones if isinstance(part, AllOf) else 0
    return lacking & -lacking


class _Learning:
    """Adds the values of bits that branching and inference make possible."""

    def __init__(self, branchings: Mapping[int, Branching], closure: Closure) -> None:
        self._branchings, self._closure = dict(branchings), closure
        self._waiting = dict(enumerate(closure.propagators))

    def after(self, ones: int, zeros: int) -> tuple[int, int]:
        """The bits that can be 1 and those that can be 0 after all possible outcomes and inferences."""
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
