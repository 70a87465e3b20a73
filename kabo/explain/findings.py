"""The geometric part of an explanation as data: failed calls, tried changes of the scene, and their effects.

This module does not import the geometry kernels, so that symbolic problems are explained without loading them.
"""

from dataclasses import dataclass
from typing import Any, Literal

from kabo.geometry_server.answers import Pair
from kabo.geometry_server.foresight.measures import Measure
from kabo.language.formulas import GroundCall
from kabo.plan import Node, StateChange, node_to_json


@dataclass(frozen=True)
class LeastMove:
    """The shortest displacement (x, y, z) [m] found of a robot's base that brings a target within reach."""

    metres: float
    by: tuple[float, float, float]


@dataclass(frozen=True)
class Row:
    """The number of attempts at a call that failed for the same reason, for the same pair of bodies or robots.

    `missing`: the distance by which the target is out of reach [m]. `because_of_epsilon`: the number of these
    attempts that succeed with exact geometry. `said`: what the stage itself said, where no pair and no distance is told.
    """

    reason: str
    between: Pair | None
    count: int
    missing: float | None = None
    because_of_epsilon: int = 0
    said: str | None = None


@dataclass(frozen=True)
class Sample:
    """A refused attempt of a call, to be looked at.

    `row`: which of the finding's rows counts it. `state`: what is elsewhere than at the start of the scene when it was
    refused; the robot is where it would have stopped. `between`: the pair that came too close.
    """

    row: int
    state: StateChange
    between: Pair | None = None

    def json(self) -> dict[str, Any]:
        """The JSON object for a sample, in the schema `kabo-explain-1`."""
        told = node_to_json(Node("action", "", after=self.state)).get("after", {})
        return {"failure": self.row, "state": told, "between": self.between and list(self.between)}


@dataclass(frozen=True)
class Finding:
    """The reasons why one call failed, with the numbers of examined and of successful attempts.

    `rows`: the failed attempts by reason and pair of bodies. `proof`: no number of samples would help.
    `dispensable`: another robot could do the task. `freed`: for each blocking body, the number of attempts that
    succeed without it. `nearer`: displacements of the base of `robot` that bring the target within reach, the last
    one at the same height. `floor`: the region that its base drives in, if it does; `nearer` then are displacements of
    this region. `measures`: the numbers on which the failures rest, of every limit the nearest one.
    `needed`: no plan does without this call. `handed_by`: the robots that have brought the object to where this
    call's robot fails to take it. `repeated`: its attempts were repeated and looked at; if not, since there was no time
    left, `rows` are as they were counted while the problem was solved.
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
    floor: str | None = None
    measures: tuple[Measure, ...] = ()
    needed: bool = False
    handed_by: tuple[str, ...] = ()
    repeated: bool = True
    samples: tuple[Sample, ...] = ()

    @property
    def refused(self) -> int:
        """The number of refused attempts."""
        return sum(row.count for row in self.rows)

    @property
    def because_of_epsilon(self) -> int:
        """The number of refused attempts that succeed with exact geometry, and so fail because of epsilon."""
        return sum(row.because_of_epsilon for row in self.rows)

    @property
    def missing(self) -> float | None:
        """The distance by which the target is out of reach [m]; None if the call failed for another reason."""
        return next((row.missing for row in self.rows if row.missing is not None), None)

    def share(self, body: str) -> int:
        """The number of attempts that a body blocked."""
        return sum(row.count for row in self.rows if row.between is not None and body in row.between)


@dataclass(frozen=True)
class BodyRemoved:
    """A change of the scene that removes a body."""

    body: str

    def __str__(self) -> str:
        return f"without {self.body}"

    def json(self) -> dict[str, Any]:
        """The JSON object for a removed body, in the schema `kabo-explain-1`."""
        return {"remove": self.body}


@dataclass(frozen=True)
class SmallerEpsilon:
    """A change that sets a smaller epsilon [m]."""

    epsilon: float

    def __str__(self) -> str:
        return f"with epsilon = {self.epsilon:g}"

    def json(self) -> dict[str, Any]:
        """The JSON object for a smaller epsilon, in the schema `kabo-explain-1`."""
        return {"epsilon": self.epsilon}


@dataclass(frozen=True)
class BaseMoved:
    """A change of the scene that moves a robot's base by a vector [m] in the world frame."""

    robot: str
    by: tuple[float, float, float]

    def __str__(self) -> str:
        x, y, z = (f"{value:g}" for value in self.by)
        return f"with the base of {self.robot} moved by ({x}, {y}, {z}) m"

    def json(self) -> dict[str, Any]:
        """The JSON object for a moved base, in the schema `kabo-explain-1`."""
        return {"move_base": {"robot": self.robot, "by": list(self.by)}}


@dataclass(frozen=True)
class FloorLarger:
    """A change of the scene that makes the floor region of a robot's base larger, by `by` [m] on every side."""

    robot: str
    floor: str
    by: float

    def __str__(self) -> str:
        return f"with the floor {self.floor} of {self.robot} larger by {self.by:g} m on every side"

    def json(self) -> dict[str, Any]:
        """The JSON object for a larger floor, in the schema `kabo-explain-1`."""
        return {"larger_floor": {"robot": self.robot, "region": self.floor, "by": self.by}}


Change = BodyRemoved | SmallerEpsilon | BaseMoved | FloorLarger


@dataclass(frozen=True)
class Counterfactual:
    """A change, and the result of solving the problem with it.

    `plan_actions`: the number of actions on the longest branch of the plan that was found; None if none was found.
    `why`: why the change could not be tried; or how much was tried in vain.
    """

    change: Change
    result: Literal["solved", "no_plan", "exhausted", "not_tried"]
    plan_actions: int | None = None
    why: str | None = None

    def json(self) -> dict[str, Any]:
        """The JSON object for a change and its result, in the schema `kabo-explain-1`."""
        told = {} if self.why is None else {"why": self.why}
        did = {"result": self.result, "plan_actions": self.plan_actions}
        return {"change": self.change.json(), "said": str(self.change), **did, **told}


@dataclass(frozen=True)
class Obstacles:
    """The result of solving with geometry, and if no plan was found, the reasons, the main finding first.

    `start`: what is wrong with the scene at its start, and what can never be done in it. `unfinished`: what there was no
    time for.
    """

    verdict: Literal["solvable", "proved", "exhausted"]
    summary: tuple[str, ...]
    findings: tuple[Finding, ...] = ()
    counterfactuals: tuple[Counterfactual, ...] = ()
    start: tuple[str, ...] = ()
    unfinished: tuple[str, ...] = ()
