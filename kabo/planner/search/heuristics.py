"""The interface of heuristics, and the table `HEURISTICS`, in which each heuristic has a row."""

from collections.abc import Callable, Sequence
from typing import Protocol

from kabo.knowledge import GroundedTask
from kabo.language.formulas import GroundCall
from kabo.planner.search.algorithms.graph import HeuristicValue


class Heuristic(Protocol):
    """Estimates and lower bounds of the remaining cost for the knowledge states of one task."""

    def estimate(self, state: int, parts: Sequence[int]) -> HeuristicValue:
        """The estimated cost from a state to the goal conjuncts with these indices, and the preferred actions."""
        ...

    def lower_bound(self, state: int) -> float | None:
        """A lower bound of the cost of weak plans from a state; 0.0 if none is known, None if there is no plan."""
        ...


def _relaxed_plans(task: GroundedTask, refused: frozenset[GroundCall]) -> Heuristic:
    # Loads estimates of finite-domain tasks (15 files), which searches in such tasks never need from here.
    from kabo.planner.search.cost_bounds import RelaxedPlans

    return RelaxedPlans(task, refused)


DEFAULT_HEURISTIC = "relaxed plans"
# By name: makes the heuristic of a task without the actions whose calls are refused.
HEURISTICS: dict[str, Callable[[GroundedTask, frozenset[GroundCall]], Heuristic]] = {
    "relaxed plans": _relaxed_plans
}
