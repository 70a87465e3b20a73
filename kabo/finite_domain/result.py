"""The result of a search."""

from dataclasses import dataclass
from typing import Literal

Status = Literal["solved", "unsolvable", "exhausted", "stopped"]


@dataclass(frozen=True)
class SearchResult:
    """The result of a search: a plan, or the reason why there is none.

    The status "unsolvable" is a proof that there is no plan. "exhausted" says that the budget of expansions or
    memory is spent, "stopped" that the caller asked the search to stop.
    """

    status: Status
    plan: tuple[int, ...] | None  # indices of operators
    cost: int | None  # of the plan
    expanded: int
    generated: int
    states: int  # how many were kept at the end
    optimal: bool = False  # it is proven that no plan has fewer actions (breadth_first), or costs less (astar)
    initial_estimate: int | None = None  # the heuristic's value at the start; None if there was no heuristic
