"""Jobs: calls of stage functions that can be interrupted and resumed, in this process or another."""

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from types import MappingProxyType
from typing import Any

from kabo.tasks.core.model.errors import UndefinedProperty
from kabo.tasks.core.model.results import Answer, Answers, Failure, Result, answers

_GOLDEN, _MASK = 0x9E3779B97F4A7C15, (1 << 64) - 1


def stage_seed(seed: int, path: str) -> int:
    """The seed of a stage, derived from the task's seed and the stage's path."""
    digest = hashlib.blake2b(f"{seed}/{path}".encode(), digest_size=8).digest()
    return int.from_bytes(digest, "little")


def job_seed(stage: int, number: int) -> int:
    """The 63-bit seed of the job with a given number, derived from the seed of its stage."""
    mixed = (stage + number * _GOLDEN) & _MASK
    mixed = ((mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
    mixed = ((mixed ^ (mixed >> 27)) * 0x94D049BB133111EB) & _MASK
    return (mixed ^ (mixed >> 31)) >> 1


def call(function: Callable[..., Answers], arguments: tuple[Any, ...]) -> Answers:
    """Calls a stage function with a read-only view of the properties, because other jobs share them."""
    *scenes, properties, seed = arguments
    return function(*scenes, MappingProxyType(properties), seed)


@dataclass(slots=True, eq=False)
class StageJob:
    """One call of a stage function; `subject` is the state, pair of states or solution to which it is applied.

    `asked` counts the runs that left answers. If the function yields, each run ends with its next success.
    """

    subject: Any
    arguments: tuple[Any, ...] | UndefinedProperty
    asked: int = 0
    taken: int = 0
    source: Iterator[Answer] | None = None
    piecemeal: bool = False
    key: tuple[Any, ...] = ()

    def run(self, function: Callable[..., Answers]) -> tuple[list[Answer], bool]:
        """The next answers, and whether they are the last. After an error the next run calls the function anew."""
        if isinstance(self.arguments, UndefinedProperty):
            return [Failure("property", str(self.arguments))], True
        if self.source is None:
            source, self.piecemeal = answers(call(function, self.arguments))
            self.source = islice(source, self.taken, None) if self.taken else source
        if not self.piecemeal:
            return list(self.source), True
        source, self.source = self.source, None  # after an error a generator would end without saying why
        found, finished = pull(source)
        self.source = source
        self.taken += len(found)
        return found, finished


def pull(source: Iterator[Answer]) -> tuple[list[Answer], bool]:
    """The answers up to and including the next success, and whether the source is exhausted."""
    found = []
    for answer in source:
        found.append(answer)
        if isinstance(answer, Result) and answer.cost < float("inf"):
            return found, False
    return found, True
