"""Cost terms that need no robot: constants, offsets, random costs and sums [T 3.5].

A cost term is a function of a solution that returns a cost, or a cost and a comment, or these and a record for programs;
it replaces the stage's own cost. An infinite cost turns the solution into a failure.
"""

from random import Random
from typing import Any

from kabo.tasks.core.model.solutions import Solution
from kabo.tasks.core.model.stages import CostTerm, Told


def told(answer: Told) -> tuple[float, str, Any]:
    """The answer of a cost term as cost, comment (empty if there is none) and record (None if there is none)."""
    if not isinstance(answer, tuple):
        return answer, "", None
    return answer if len(answer) == 3 else (*answer, None)


def constant(value: float) -> CostTerm:
    """A term that gives every solution the same cost."""

    def cost(solution: Solution) -> float:
        return float(value)

    return cost


def offset(value: float) -> CostTerm:
    """A term that adds a constant to the cost that the stage itself gave to the solution."""

    def cost(solution: Solution) -> float:
        return solution.cost + value

    return cost


def uniform_random(low: float = 0.0, high: float = 1.0, seed: int = 0) -> CostTerm:
    """A term that gives each solution a random cost in [low, high], fixed by `seed`, its stage and its number."""

    def cost(solution: Solution) -> float:
        return Random(f"{seed} {solution.number} {solution.stage.path}").uniform(low, high)  # noqa: S311 - no secret

    return cost


def weighted(*terms: tuple[CostTerm, float]) -> CostTerm:
    """The weighted sum of terms, given as (term, weight); comments are joined, the record is that of the first with one."""

    def cost(solution: Solution) -> tuple[float, str, Any]:
        value, comments, record = 0.0, [], None
        for term, weight in terms:
            own, comment, details = told(term(solution))
            value += weight * own
            comments += [comment] if comment else []
            record = details if record is None else record
        return value, ", ".join(comments), record

    return cost


def total(*terms: CostTerm) -> CostTerm:
    """The sum of terms; their comments are joined."""
    return weighted(*((term, 1.0) for term in terms))
