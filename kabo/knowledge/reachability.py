"""The delete relaxation over knowledge: what could ever become known, and which goals never can."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kabo.knowledge.actions import Branching, GroundAction
from kabo.knowledge.closure import Closure
from kabo.knowledge.entries import Entry
from kabo.knowledge.queries import bits_of, union
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
    reached: set[int] = set()
    layers, history = 0, [(ones, zeros)]
    while True:
        now = ones, zeros, len(reached)
        possible: dict[int, bool] = {}  # of updates; actions share many
        new_ones, new_zeros = ones, zeros
        for action in actions:
            if action.index in reached and not action.reads & learning.fresh:
                continue
            if action.precondition.possible(ones, zeros):
                reached.add(action.index)
                made, cleared = _relaxed_effects(action, ones, zeros, possible)
                new_ones |= made
                new_zeros |= cleared
                if not by_layers:
                    ones, zeros = new_ones, new_zeros
        ones, zeros = learning.after(new_ones, new_zeros)
        learning.fresh = ones ^ now[0] | zeros ^ now[1]
        if (ones, zeros, len(reached)) == now:
            used = tuple(action for action in actions if action.index in reached)
            return Reach(ones, zeros, used, layers, tuple(history))
        layers += 1
        history.append((ones, zeros))


def unreachable_goals(task: Task) -> list[str]:
    """The goal conjuncts out of reach even if nothing were ever lost, as text in the order of the file."""
    reach = relaxed_reach(task.initial, task.actions, task.branchings, task.closure)
    return [part.text for part in task.goal if not part.query.possible(reach.ones, reach.zeros)]


def _relaxed_effects(action: GroundAction, ones: int, zeros: int, possible: dict[int, bool]) -> tuple[int, int]:
    made, cleared = 0, union(entry.mask for entry in action.effects.entries)
    for update in action.effects.updates:
        known = possible.get(id(update))
        if known is None:
            known = possible[id(update)] = update.condition.possible(ones, zeros)
        if known:
            made |= update.make | (update.assignment.bits.mask if update.assignment else 0)
            cleared |= update.clear
    return made, cleared


class _Learning:
    """What branching and inference may add to bits that are possible."""

    def __init__(self, branchings: Mapping[int, Branching], closure: Closure) -> None:
        self._branchings, self._closure = dict(branchings), closure
        self._waiting = dict(enumerate(closure.propagators))
        self.fresh = -1

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
