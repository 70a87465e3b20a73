"""The interface of geometric procedures to the planner, implemented by `kabo.tasks.procedures`, and by fakes in tests.

The planner speaks to this protocol, so that only a problem with a scene loads the procedures and their kernels.
"""

from collections.abc import Callable
from typing import Protocol

from kabo.geometry_server.answers import Answer, GeometryStatistics, Refusal
from kabo.geometry_server.situation import Situation
from kabo.language.formulas import GroundCall
from kabo.scene import GeometricState, Scene

Elsewhere = Callable[[GroundCall, Situation, int, int], tuple[Answer, GeometryStatistics] | None]


class CallComponents(Protocol):
    """The components of the geometric state that a call with bound arguments moves and reads."""

    @property
    def moves(self) -> tuple[str, ...]:
        """The components that the call changes, as far as is known."""
        ...

    @property
    def reads(self) -> tuple[str, ...]:
        """The other components that the call's answer depends on, as far as is known."""
        ...


class ProcedureServer(Protocol):
    """Answers calls of geometric procedures; equal questions have equal answers."""

    elsewhere: Elsewhere | None  # asked first for an answer: worker processes that may have it

    @property
    def scene(self) -> Scene:
        """The scene in which calls are answered."""
        ...

    @property
    def statistics(self) -> GeometryStatistics:
        """Counts of what was computed so far."""
        ...

    @property
    def stop(self) -> Callable[[], bool]:
        """Whether time or a budget is spent."""
        ...

    @property
    def states_met(self) -> int:
        """The number of distinct geometric states after successful calls."""
        ...

    def identify(self, state: GeometricState) -> int:
        """The identifier of a geometric state [K Def. 5]."""
        ...

    def state(self, identifier: int) -> GeometricState:
        """The geometric state of an identifier."""
        ...

    def bind(self, call: GroundCall) -> CallComponents:
        """The components that a call moves and reads."""
        ...

    def single(self, call: GroundCall, situation: Situation) -> tuple[str, ...]:
        """The components that must have one value before a call, sorted."""
        ...

    def knows(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> bool:
        """Whether the answer to a question is remembered."""
        ...

    def call(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> Answer:
        """The answer to a call, valid for all values that components may have in the situation.

        `attempt` is the number of solutions to skip.

        Raises:
            CutOff: time or a budget was spent before there was an answer.
        """
        ...

    def refuted(self, call: GroundCall) -> Refusal | None:
        """The failure of a call, proven without sampling, wherever its components have their start values; or None."""
        ...
