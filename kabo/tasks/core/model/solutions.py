"""Interface states and solutions: the graph that planning builds [T 3.2, 3.5].

A state stands between two neighbouring stages of one container; solutions are the edges between states. A state at a
container's border has a counterpart outside the container.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

LEFT, RIGHT = 0, 1


class State:
    """A scene with interface properties; `edges` are the solutions that end (LEFT) and start (RIGHT) in it.

    The rest is used by planning only, per side where it is a list: `best` is (stages, stages outside, cost) of the best
    path, the longest, then the cheapest; `order` is the sort key made of it, less is better; `alive` says whether the state
    may still become part of a whole solution; `outside` lists its counterparts outside the container; `cause` is the
    solution that triggered the monitoring generator which wrote it.
    """

    __slots__ = (
        "alive",
        "announced",
        "best",
        "cause",
        "edges",
        "inside",
        "lane",
        "level",
        "number",
        "order",
        "outside",
        "position",
        "properties",
        "scene",
    )

    def __init__(self, scene: Any, properties: Mapping[str, Any], number: int, lane: object = None) -> None:
        self.scene = scene
        self.properties = properties
        self.number = number
        # States of different lanes are never joined; a lane is a pair that fallbacks try their children on.
        self.lane = lane
        self.edges: tuple[list[Solution], list[Solution]] = ([], [])
        self.best = [(0, 0, 0.0), (0, 0, 0.0)]
        self.order = [(0, 0.0), (0, 0.0)]
        self.alive = [True, True]
        self.level: Any = None
        self.position = -1
        self.outside: list[State] = []
        self.inside: list[State] = []
        self.announced = False
        self.cause: Solution | None = None

    @property
    def incoming(self) -> tuple["Solution", ...]:
        """The solutions that end in this state."""
        return tuple(self.edges[LEFT])

    @property
    def outgoing(self) -> tuple["Solution", ...]:
        """The solutions that start in this state."""
        return tuple(self.edges[RIGHT])

    def reached(self, side: int, best: tuple[int, int, float]) -> None:
        """Records the best path that leads to this state from `side`."""
        self.best[side] = best
        self.order[side] = (-best[0] - best[1], best[2])

    def leads_on(self, side: int) -> bool:
        """Whether a solution leads from this state, towards `side`, to a state that is alive on `side`."""
        for edge in self.edges[side]:
            beyond = edge.end if side == RIGHT else edge.start
            if beyond is not None and beyond.alive[side]:
                return True
        return False

    def __getstate__(self) -> tuple[Any, Mapping[str, Any], int]:
        return self.scene, dict(self.properties), self.number

    def __setstate__(self, given: tuple[Any, Mapping[str, Any], int]) -> None:
        self.__init__(*given)  # type: ignore[misc]

    def __repr__(self) -> str:
        return f"State({self.number})"


class SolvedStage(Protocol):
    """The stage that a solution refers to: a `Stage` in the process that planned it, a `NamedStage` in others."""

    TRANSPARENT: ClassVar[bool]  # whether parts of its solutions are found without its name

    @property
    def name(self) -> str:
        """The name of the stage."""
        ...

    @property
    def path(self) -> str:
        """The names of the stages from the task's child down to this stage, joined by `/`."""
        ...


@dataclass(frozen=True)
class NamedStage:
    """The name and path of a stage, which a solution keeps when it is sent to another process."""

    TRANSPARENT: ClassVar[bool] = False
    name: str
    path: str


class Solution:
    """A solution of a stage between two states: its cost, a comment, and its motion or the solutions that it consists of.

    A failure is a solution of infinite cost; `reason` is the key under which it is counted, `details` are for programs.
    """

    __slots__ = ("comment", "cost", "details", "end", "motion", "number", "parts", "reason", "stage", "start")

    def __init__(
        self,
        stage: SolvedStage,
        start: State | None,
        end: State | None,
        cost: float,
        comment: str = "",
        motion: Any = None,
        parts: tuple["Solution", ...] = (),
        number: int = 0,
        reason: str = "",
        details: Any = None,
    ) -> None:
        self.stage, self.start, self.end = stage, start, end
        self.cost, self.comment, self.motion, self.parts = cost, comment, motion, parts
        self.number, self.reason, self.details = number, reason, details

    @property
    def failed(self) -> bool:
        """Whether this is a failure: its cost is infinite or not a number."""
        return not self.cost < float("inf")

    @property
    def properties(self) -> Mapping[str, Any]:
        """The interface properties of the state at the solution's end, such as the grasp that was chosen."""
        return {} if self.end is None else self.end.properties

    @property
    def leaves(self) -> tuple["Solution", ...]:
        """The innermost solutions that have a motion of their own or no parts, in order of time."""
        return tuple(self._leaves())

    def _leaves(self) -> Iterator["Solution"]:
        waiting = [self]
        while waiting:
            solution = waiting.pop()
            if solution.motion is not None or not solution.parts:
                yield solution
            else:
                waiting.extend(reversed(solution.parts))

    def walk(self) -> Iterator["Solution"]:
        """This solution and all solutions that it consists of, in order of time."""
        waiting = [self]
        while waiting:
            solution = waiting.pop()
            yield solution
            waiting.extend(reversed(solution.parts))

    def __getitem__(self, path: str) -> "Solution":
        """The part at a path of stage names, relative to this solution's stage.

        Raises:
            KeyError: there is no part at that path.
        """
        here = self
        for name in path.split("/"):
            found = here._named(name)
            if found is None:
                names = ", ".join(repr(part.stage.name) for part in here.parts)
                raise KeyError(f"{here.stage.name!r} has no part {name!r}; it has {names or 'none'}")
            here = found
        return here

    def _named(self, name: str) -> "Solution | None":
        """The part with that name, or None; parts of containers that only choose or wrap are searched as well."""
        for part in self.parts:
            if part.stage.name == name:
                return part
        for part in self.parts:
            if part.stage.TRANSPARENT:
                found = part._named(name)
                if found is not None:
                    return found
        return None

    def __getstate__(self) -> tuple[Any, ...]:
        stage = NamedStage(self.stage.name, self.stage.path)
        rest = self.cost, self.comment, self.motion, self.parts, self.number, self.reason, self.details
        return stage, self.start, self.end, *rest

    def __setstate__(self, given: tuple[Any, ...]) -> None:
        self.__init__(*given)  # type: ignore[misc]

    def __repr__(self) -> str:
        return f"Solution({self.stage.path!r}, cost {self.cost:g}{', ' + self.comment if self.comment else ''})"
