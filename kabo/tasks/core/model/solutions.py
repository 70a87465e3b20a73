"""Interface states and solutions: the graph that planning grows [T 3.2, 3.5].

A state stands between two neighbouring stages of one container. Its solutions on the left and on the right are
edges of the graph. A state on a container's border has a counterpart outside.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from kabo.tasks.core.model.stages import Stage

LEFT, RIGHT = 0, 1


class State:
    """A scene with interface properties; `edges` are the solutions that end here (LEFT) and that start here (RIGHT).

    Planning's own: `best` per side is (stages, stages outside, cost) of the longest, then cheapest path, `order`
    puts states with longer paths first, then those with cheaper ones; `alive` per
    side, whether it may still become part of a whole solution; `outside` its counterparts beyond the border; `cause`
    the success for which a monitor wrote it.
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
        self.lane = lane  # states of different lanes never meet: pairs that a fallback tries one by one
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
        """Notes the best path that leads here from `side`."""
        self.best[side] = best
        self.order[side] = (-best[0] - best[1], best[2])

    def leads_on(self, side: int) -> bool:
        """Whether a solution leads from here to a state that is alive on that side."""
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


@dataclass(frozen=True)
class NamedStage:
    """What is left of a stage when a solution travels to another process."""

    name: str
    path: str


class Solution:
    """What a stage found between two states: a cost, a comment, its motion or the solutions it is made of.

    A failure is a solution of infinite cost; then `reason` groups it and `details` are for programs.
    """

    __slots__ = ("comment", "cost", "details", "end", "motion", "number", "parts", "reason", "stage", "start")

    def __init__(
        self,
        stage: Stage,
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
        """Whether this is a failure: its cost is infinite, or no number."""
        return not self.cost < float("inf")

    @property
    def properties(self) -> Mapping[str, Any]:
        """The interface properties at its end: what was decided here, such as a grasp."""
        return {} if self.end is None else self.end.properties

    @property
    def leaves(self) -> tuple["Solution", ...]:
        """The solutions with a motion of their own, and those made of nothing else, in order of time."""
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
        """This solution and all it is made of, in order of time."""
        waiting = [self]
        while waiting:
            solution = waiting.pop()
            yield solution
            waiting.extend(reversed(solution.parts))

    def __getitem__(self, path: str) -> "Solution":
        """The part of a path of stage names, relative to this solution's stage.

        Raises:
            KeyError: no part of that path.
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
        """The part of that name; containers that only choose or wrap are looked through."""
        from kabo.tasks.core.model.containers import Parallel, Wrapper

        for part in self.parts:
            if part.stage.name == name:
                return part
        for part in self.parts:
            if isinstance(part.stage, (Parallel, Wrapper)):
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
