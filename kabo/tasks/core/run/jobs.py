"""Jobs: one call of a stage function, taken up again where it left off, here or in another process."""

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
    """The seed of a stage, from the task's seed and the stage's path."""
    digest = hashlib.blake2b(f"{seed}/{path}".encode(), digest_size=8).digest()
    return int.from_bytes(digest, "little")


def job_seed(stage: int, number: int) -> int:
    """The seed of a stage's job of that number, 63 bits."""
    mixed = (stage + number * _GOLDEN) & _MASK
    mixed = ((mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
    mixed = ((mixed ^ (mixed >> 27)) * 0x94D049BB133111EB) & _MASK
    return (mixed ^ (mixed >> 31)) >> 1


def call(function: Callable[..., Answers], arguments: tuple[Any, ...]) -> Answers:
    """Calls a stage function; it may read its properties, which other jobs share, and not change them."""
    *scenes, properties, seed = arguments
    return function(*scenes, MappingProxyType(properties), seed)


@dataclass(slots=True, eq=False)
class StageJob:
    """A call of a stage function for some states; `asked` says how often it gave something already.

    `subject` is what the node runs it for. What yields is asked for one success at a time.
    """

    subject: Any
    arguments: tuple[Any, ...] | UndefinedProperty
    asked: int = 0
    taken: int = 0
    source: Iterator[Answer] | None = None
    piecemeal: bool = False
    key: tuple[Any, ...] = ()

    def run(self, function: Callable[..., Answers]) -> tuple[list[Answer], bool]:
        """The next answers, and whether there are no more; what an error breaks off is begun anew, and found again."""
        if isinstance(self.arguments, UndefinedProperty):
            return [Failure("property", str(self.arguments))], True
        if self.source is None:
            source, self.piecemeal = answers(call(function, self.arguments))
            self.source = islice(source, self.taken, None) if self.taken else source
        if not self.piecemeal:
            return list(self.source), True
        source, self.source = self.source, None  # after an error it would say that there are no more
        found, finished = pull(source)
        self.source = source
        self.taken += len(found)
        return found, finished


def pull(source: Iterator[Answer]) -> tuple[list[Answer], bool]:
    """The answers up to the next success, and whether there are no more."""
    found = []
    for answer in source:
        found.append(answer)
        if isinstance(answer, Result) and answer.cost < float("inf"):
            return found, False
    return found, True
