"""Lower bounds of the cost of weak plans, for A*: LM-cut over the delete relaxation of knowledge.

The delete relaxation assumes all outcomes of sensing at once and never loses knowledge, so that every weak plan is
also a relaxed plan, at the same or a lower cost.
"""

from collections.abc import Sequence
from functools import cached_property
from math import floor

from kabo import finite_domain
from kabo.knowledge import GroundedTask
from kabo.language.formulas import GroundCall
from kabo.planner.search.algorithms.graph import HeuristicValue
from kabo.planner.search.delete_relaxation import Relaxation

UNITS = 1000  # integer units of cost 1; costs are rounded down to them, so that bounds stay bounds


class CostBounds:
    """Lower bounds on the cost of weak plans for one task; the bound of each state is computed once."""

    def __init__(self, task: GroundedTask, relaxation: Relaxation) -> None:
        self._task, self._relaxation = task, relaxation
        self._known: dict[int, float | None] = {}

    @cached_property
    def _landmarks(self) -> "finite_domain.LandmarkBound":
        relaxation, task = self._relaxation, self._task
        costs = {action.index: floor(UNITS * action.cost) for action in task.actions}
        goal = relaxation.goal_of(tuple(range(len(task.goal))))
        return finite_domain.LandmarkBound(relaxation.task.facts, relaxation.operators, goal, costs)

    def below(self, state: int) -> float | None:
        """A lower bound of the cost of weak plans from a state; None if there is no plan."""
        if state not in self._known:
            bound = self._landmarks.below(self._relaxation.true_in(state))
            self._known[state] = None if bound is None else bound / UNITS
        return self._known[state]


class RelaxedPlans:
    """The heuristic of the delete relaxation: estimates by relaxed plans [h_FF], lower bounds by LM-cut."""

    def __init__(self, task: GroundedTask, refused: frozenset[GroundCall] = frozenset()) -> None:
        self._task, self._relaxation = task, Relaxation(task, refused)

    @cached_property
    def _bounds(self) -> CostBounds:
        return CostBounds(self._task, self._relaxation)

    def estimate(self, state: int, parts: Sequence[int]) -> HeuristicValue:
        """The cost of a relaxed plan from a state to some goal conjuncts, and the actions that can begin it."""
        found = self._relaxation.estimate(state, parts)
        return HeuristicValue(found.value, frozenset(found.preferred))

    def lower_bound(self, state: int) -> float | None:
        """A lower bound of the cost of weak plans from a state; None if there is no plan."""
        return self._bounds.below(state)
