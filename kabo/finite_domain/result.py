"""What a search says."""

from dataclasses import dataclass
from typing import Literal

Status = Literal["solved", "unsolvable", "exhausted", "stopped"]


@dataclass(frozen=True)
class SearchResult:
    """A plan, or why there is none.

    "unsolvable" is a proof. "exhausted": the budget of expansions or memory is spent; "stopped": the caller said so.
    """

    status: Status
    plan: tuple[int, ...] | None  # indices of operators
    cost: int | None  # of the plan
    expanded: int
    generated: int
    states: int  # kept at the end
    optimal: bool = False  # proven: no plan has fewer actions (breadth first), or costs less (astar)
    initial_estimate: int | None = None  # where a heuristic was asked: its value at the start
