"""How often to look: answers that may be wrong are collected until the error of the most probable one is small enough.

This is the sequential probability ratio test [Wald 1945, "Sequential tests of statistical hypotheses"], with all outcomes
equally probable at first: of m outcomes, one that n of the looks have given has the weight rⁿ with
r = (1 - wrong) (m - 1) / wrong, and its probability is this weight over the sum of all. With two outcomes the test ends
when one of them is k looks ahead of the other, k = log((1 - error) / error) / log((1 - wrong) / wrong), rounded up.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Decision:
    """The answer of all looks together.

    Attributes:
        outcome: None: the looks that are permitted were not enough.
        looks: how often was looked.
        error: the probability that the most probable outcome is not the true one.
    """

    outcome: str | None
    looks: int
    error: float


def decide(
    look: Callable[[int], str | None], outcomes: Sequence[str], wrong: float, error: float, most: int
) -> Decision:
    """Looks until the error is within its bound, at most so often.

    Args:
        look: the answer of the look of a number from 0 on; None: nothing was seen.
        outcomes: that are possible; an answer that is none of them is taken as nothing.
        wrong: the probability that an answer is wrong.
        error: up to which probability the decision may be wrong.
        most: looks.
    """
    counts = dict.fromkeys(outcomes, 0)
    best, left = None, 1.0 - 1.0 / max(1, len(outcomes))
    for number in range(most):
        found = look(number)
        if found not in counts:
            if number == 0 and wrong == 0.0:
                return Decision(None, 1, left)  # what sees nothing and never errs sees nothing later either
            continue
        counts[found] += 1
        best, left = most_probable(counts, wrong)
        if left <= error:
            return Decision(best, number + 1, left)
    return Decision(None, most, left)


def most_probable(counts: dict[str, int], wrong: float) -> tuple[str, float]:
    """The most probable outcome by how often each was seen, and the probability that it is not the true one."""
    best = max(counts, key=lambda each: counts[each])
    if wrong == 0.0 or len(counts) == 1:
        return best, 0.0
    ratio = wrong / ((1.0 - wrong) * (len(counts) - 1))
    others = sum(ratio ** (counts[best] - count) for name, count in counts.items() if name != best)
    return best, others / (1.0 + others)


def expected_looks(wrong: float, lead: int) -> float:
    """The mean number of looks until one of two outcomes is `lead` looks ahead [Wald 1945; Feller 1968, XIV.3]."""
    if wrong == 0.0:
        return float(lead)
    ratio = (wrong / (1.0 - wrong)) ** lead
    return lead * (1.0 - ratio) / (1.0 + ratio) / (1.0 - 2.0 * wrong)
