"""What an explanation says of geometry, as data: calls that failed, changes that were tried, and what came of them.

Nothing here loads geometry, so that explanations of symbolic problems are quick to make.
"""

from dataclasses import dataclass
from typing import Any, Literal

from kabo.geometry_server.answers import Pair
from kabo.language.formulas import GroundCall


@dataclass(frozen=True)
class LeastMove:
    """The least move found of a robot's base that brings something within reach: its length [m], and (x, y, z) [m]."""

    metres: float
    by: tuple[float, float, float]


@dataclass(frozen=True)
class Row:
    """Attempts that failed for one reason, between one pair of things.

    `missing` [m]: how far out of reach; `because_of_epsilon`: how many of them exact geometry lets pass.
    """

    reason: str
    between: Pair | None
    count: int
    missing: float | None = None
    because_of_epsilon: int = 0


@dataclass(frozen=True)
class Finding:
    """What came of one call: attempts that were looked at, answers with a motion, failures by reason and pair.

    `proof`: no number of samples would help; `dispensable`: another robot could do it. `freed` counts, for each body
    that blocked, the attempts that pass without it; `nearer` are moves [m] of the base of `robot` after which what is
    out of reach is within reach, the last one at the same height.
    """

    call: GroundCall
    attempts: int
    successes: int
    rows: tuple[Row, ...]
    message: str
    proof: bool = False
    dispensable: bool = False
    freed: tuple[tuple[str, int], ...] = ()
    robot: str | None = None
    nearer: tuple[LeastMove, ...] = ()

    @property
    def refused(self) -> int:
        """How many attempts were refused."""
        return sum(row.count for row in self.rows)

    @property
    def because_of_epsilon(self) -> int:
        """How many of them exact geometry lets pass."""
        return sum(row.because_of_epsilon for row in self.rows)

    @property
    def missing(self) -> float | None:
        """How far out of reach [m]; None if that is not why."""
        return next((row.missing for row in self.rows if row.missing is not None), None)

    def share(self, body: str) -> int:
        """How many attempts a body blocked."""
        return sum(row.count for row in self.rows if row.between is not None and body in row.between)


@dataclass(frozen=True)
class BodyRemoved:
    """Without a body."""

    body: str

    def __str__(self) -> str:
        return f"without {self.body}"

    def json(self) -> dict[str, Any]:
        """As the schema `kabo-explain-1` wants it."""
        return {"remove": self.body}


@dataclass(frozen=True)
class SmallerEpsilon:
    """With another epsilon [m]."""

    epsilon: float

    def __str__(self) -> str:
        return f"with epsilon = {self.epsilon:g}"

    def json(self) -> dict[str, Any]:
        """As the schema `kabo-explain-1` wants it."""
        return {"epsilon": self.epsilon}


@dataclass(frozen=True)
class BaseMoved:
    """With a robot's base moved by so much [m] in the world."""

    robot: str
    by: tuple[float, float, float]

    def __str__(self) -> str:
        x, y, z = (f"{value:g}" for value in self.by)
        return f"with the base of {self.robot} moved by ({x}, {y}, {z}) m"

    def json(self) -> dict[str, Any]:
        """As the schema `kabo-explain-1` wants it."""
        return {"move_base": {"robot": self.robot, "by": list(self.by)}}


Change = BodyRemoved | SmallerEpsilon | BaseMoved


@dataclass(frozen=True)
class Counterfactual:
    """A change and what came of solving the problem with it; `plan_actions` on the longest branch."""

    change: Change
    result: Literal["solved", "no_plan", "exhausted"]
    plan_actions: int | None = None

    def json(self) -> dict[str, Any]:
        """As the schema `kabo-explain-1` wants it."""
        return {"change": self.change.json(), "result": self.result, "plan_actions": self.plan_actions}


@dataclass(frozen=True)
class Obstacles:
    """Whether there are motions, and what stood in the way if there are none; the main finding comes first."""

    verdict: Literal["solvable", "proved", "exhausted"]
    summary: tuple[str, ...]
    findings: tuple[Finding, ...] = ()
    counterfactuals: tuple[Counterfactual, ...] = ()
