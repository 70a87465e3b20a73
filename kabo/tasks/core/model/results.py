"""Return values of stage functions: results and failures, plain values that can be pickled."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable


class _Same:
    """Stands for a start scene that is the scene given to the stage."""

    def __repr__(self) -> str:
        return "SAME"

    def __reduce__(self) -> str:
        return "SAME"


SAME = _Same()


class StructuralReason(str):
    """The reason why two states never fit that lies in the order of the stages, whatever values they choose.

    One stage permits a contact on one side of a connector, for example, and none does on the other side.
    """


@dataclass(frozen=True)
class Agreed:
    """The value of an interface property that has to be equal on both sides of a connector, where both sides have it.

    It marks a choice between alternatives on which later stages rely: also those that a monitoring generator begins.
    """

    value: Any


@dataclass(frozen=True)
class Result:
    """A success that a stage function returns.

    Args:
        scene: the scene on the side that the stage computes: after it (forward), before it (backward), on both sides
            (generator); None keeps the scene that is there (connectors, wrappers).
        cost: the cost that the stage computes; an infinite cost turns the result into a failure.
        comment: a text for users, which no code interprets.
        motion: the motion in order of time; the core does not interpret it.
        properties: interface properties that are added to those inherited by the new state.
        start: for wrappers of generators, the scene before the wrapper, if it is not `scene`.
        details: a record for programs; it becomes the solution's `details`.
    """

    scene: Any = None
    cost: float = 0.0
    comment: str = ""
    motion: Any = None
    properties: Mapping[str, Any] = field(default_factory=dict)
    start: Any = SAME
    details: Any = None


@runtime_checkable
class Refused(Protocol):
    """The protocol of a failed attempt that a stage function returns: `Failure`, or a similar object."""

    @property
    def reason(self) -> str:
        """A short text that says why the attempt failed; failures are counted by reason."""

    @property
    def comment(self) -> str:
        """A comment for users, which no code interprets."""


@dataclass(frozen=True)
class Failure:
    """A failed attempt: `reason` is a short key under which failures are counted, `details` are for programs.

    `proof`: the same properties fail in every scene and with every seed.
    """

    reason: str
    comment: str = ""
    details: Any = None
    proof: bool = False


Answer = Result | Refused
Answers = Iterable[Answer] | Answer | None


def answers(given: Answers) -> tuple[Iterator[Answer], bool]:
    """An iterator over the answers of a stage function, and whether the function yields them one at a time.

    Raises:
        TypeError: the function returned something else than results and failures.
    """
    if given is None:
        return iter(()), False
    if isinstance(given, Iterator):
        return given, True
    if isinstance(given, (list, tuple)) and not hasattr(given, "reason"):  # asking a protocol takes much longer
        return iter(given), False
    if isinstance(given, (Result, Refused)):
        return iter((given,)), False
    if not isinstance(given, Iterable):
        raise TypeError(f"a stage function gives results and failures, not {given!r}")
    return iter(given), False
