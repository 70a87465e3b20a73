"""The interface between planner and geometric procedures; `kabo.tasks.procedures` and test doubles implement it.

The planner uses only this protocol, so that the procedures and their kernels are loaded only for problems with a
scene.
"""

from collections.abc import Callable
from typing import Protocol

from kabo.geometry_server.answers import Answer, GeometryStatistics, Refusal
from kabo.geometry_server.situation import Situation
from kabo.language.formulas import GroundCall
from kabo.scene import GeometricState, Scene

Elsewhere = Callable[[GroundCall, Situation, int, int], tuple[Answer, GeometryStatistics] | None]


class CallComponents(Protocol):
    """The components of the geometric state that a call changes or reads."""

    @property
    def moves(self) -> tuple[str, ...]:
        """The components that the call changes, as far as is known."""
        ...

    @property
    def reads(self) -> tuple[str, ...]:
        """The other components that the call's answer depends on, as far as is known."""
        ...


class ProcedureServer(Protocol):
    """Answers calls of geometric procedures; equal calls in equal situations get equal answers."""

    elsewhere: Elsewhere | None  # asked first for an answer: worker processes that may have it

    @property
    def scene(self) -> Scene:
        """The scene in which the calls take place."""
        ...

    @property
    def statistics(self) -> GeometryStatistics:
        """The counts of calls, failures and samples so far."""
        ...

    @property
    def stop(self) -> Callable[[], bool]:
        """A function that returns True when time or another budget is spent."""
        ...

    @property
    def states_met(self) -> int:
        """The number of distinct geometric states that resulted from successful calls."""
        ...

    def identify(self, state: GeometricState) -> int:
        """The identifier of a geometric state [K Def. 5]."""
        ...

    def state(self, identifier: int) -> GeometricState:
        """The geometric state that has this identifier."""
        ...

    def bind(self, call: GroundCall) -> CallComponents:
        """The components that a call changes and those that its answer depends on."""
        ...

    def single(self, call: GroundCall, situation: Situation) -> tuple[str, ...]:
        """The names of the components that must have a single value when the call is made, sorted."""
        ...

    def knows(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> bool:
        """Whether the answer to this attempt at a call in this situation is already known."""
        ...

    def call(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> Answer:
        """The answer to a call, valid for all values that components may have in the situation.

        `attempt` is the number of earlier solutions to skip.

        Raises:
            CutOff: time or another budget was spent before the answer was found.
        """
        ...

    def refuted(self, call: GroundCall) -> Refusal | None:
        """The refusal of a call in the start state if it is proven without sampling; None if there is no proof.

        The refusal is valid wherever the components that the call depends on have their start values.
        """
        ...
