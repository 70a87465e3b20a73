"""What stage functions answer: results and failures, plain values that travel between processes."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any


class _Same:
    """The start scene of a result is the scene that the stage began with."""

    def __repr__(self) -> str:
        return "SAME"

    def __reduce__(self) -> str:
        return "SAME"


SAME = _Same()


@dataclass(frozen=True)
class Result:
    """One success of a stage function.

    Args:
        scene: the scene at the end that the stage computes: after it (forward), before it (backward), both
            (generator); None keeps the one that is there (connectors, wrappers).
        cost: the stage's own; infinite makes a failure of it.
        comment: for people.
        motion: what moves, in order of time; the core only carries it.
        properties: interface properties, added to those that the new state inherits.
        start: for wrappers of generators, the scene before, where it is not `scene`.
    """

    scene: Any = None
    cost: float = 0.0
    comment: str = ""
    motion: Any = None
    properties: Mapping[str, Any] = field(default_factory=dict)
    start: Any = SAME


@dataclass(frozen=True)
class Failure:
    """A refused attempt: `reason` is short and groups counts, `comment` is for people, `details` for programs."""

    reason: str
    comment: str = ""
    details: Any = None


Answer = Result | Failure
Answers = Iterable[Answer] | Answer | None


def answers(given: Answers) -> tuple[Iterator[Answer], bool]:
    """What a stage function gave, one by one, and whether to take it piece by piece (it yields) or at once.

    Raises:
        TypeError: it gave something else than results and failures.
    """
    if given is None:
        return iter(()), False
    if isinstance(given, (Result, Failure)):
        return iter((given,)), False
    if not isinstance(given, Iterable):
        raise TypeError(f"a stage function gives results and failures, not {given!r}")
    return iter(given), isinstance(given, Iterator)
