"""Cost terms that need no robot: constants, offsets, random ones, sums; a term replaces a stage's own cost [T 3.5].

A term is a function of a solution that returns a cost, or a cost and a comment. An infinite cost makes a failure.
"""

from random import Random

from kabo.tasks.core.model.solutions import Solution
from kabo.tasks.core.model.stages import CostTerm


def constant(value: float) -> CostTerm:
    """The same cost for every solution."""

    def cost(solution: Solution) -> float:
        return float(value)

    return cost


def offset(value: float) -> CostTerm:
    """The solution's own cost and a constant."""

    def cost(solution: Solution) -> float:
        return solution.cost + value

    return cost


def uniform_random(low: float = 0.0, high: float = 1.0, seed: int = 0) -> CostTerm:
    """A random cost, the same for the same solution of the same run."""

    def cost(solution: Solution) -> float:
        return Random(f"{seed} {solution.number} {solution.stage.path}").uniform(low, high)  # noqa: S311 - no secret

    return cost


def weighted(*terms: tuple[CostTerm, float]) -> CostTerm:
    """The sum of terms, each with its weight, and all their comments."""

    def cost(solution: Solution) -> tuple[float, str]:
        value, comments = 0.0, []
        for term, weight in terms:
            found = term(solution)
            own, comment = found if isinstance(found, tuple) else (found, "")
            value += weight * own
            comments += [comment] if comment else []
        return value, ", ".join(comments)

    return cost


def total(*terms: CostTerm) -> CostTerm:
    """The sum of terms, and all their comments."""
    return weighted(*((term, 1.0) for term in terms))
