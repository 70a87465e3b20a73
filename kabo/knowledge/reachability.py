"""The delete relaxation over knowledge: what could ever become known, and which goals never can."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kabo.knowledge.actions import Branching, GroundAction
from kabo.knowledge.queries import bits_of
from kabo.knowledge.task import Task


@dataclass(frozen=True)
class Reach:
    """Bits that can be 1 and bits that can be 0, the actions that can ever apply, and the number of layers."""

    ones: int
    zeros: int
    actions: tuple[GroundAction, ...]
    layers: int


def relaxed_reach(initial: int, actions: Sequence[GroundAction], branchings: Mapping[int, Branching]) -> Reach:
    """The fixpoint of applying all actions without ever losing a bit value that was possible.

    Every state that a plan can reach is contained: a bit outside `ones` is 0 in all of them.
    """
    ones, zeros = _split(initial, ~initial, branchings)
    reached: set[int] = set()
    layers = 0
    while True:
        now = ones, zeros, len(reached)
        new_ones, new_zeros = ones, zeros
        for action in actions:
            if action.precondition.possible(ones, zeros):
                reached.add(action.index)
                made, cleared = _relaxed_effects(action, ones, zeros)
                new_ones |= made
                new_zeros |= cleared
        ones, zeros = _split(new_ones, new_zeros, branchings)
        if (ones, zeros, len(reached)) == now:
            return Reach(ones, zeros, tuple(action for action in actions if action.index in reached), layers)
        layers += 1


def unreachable_goals(task: Task) -> list[str]:
    """The goal conjuncts out of reach even if nothing were ever lost, as text in the order of the file."""
    reach = relaxed_reach(task.initial, task.actions, task.branchings)
    return [part.text for part in task.goal if not part.query.possible(reach.ones, reach.zeros)]


def _relaxed_effects(action: GroundAction, ones: int, zeros: int) -> tuple[int, int]:
    made = cleared = 0
    for update in action.effects.updates:
        if update.condition.possible(ones, zeros):
            made |= update.make | (update.assignment.bits.field if update.assignment else 0)
            cleared |= update.clear
    for rule in action.effects.settlements:
        cleared |= rule.implied
    return made, cleared


def _split(ones: int, zeros: int, branchings: Mapping[int, Branching]) -> tuple[int, int]:
    """What branching on every possible entry adds."""
    for entry in bits_of(ones):
        branching = branchings.get(entry)
        if branching is not None:
            ones |= branching.mask
            zeros |= branching.mask
    return ones, zeros
