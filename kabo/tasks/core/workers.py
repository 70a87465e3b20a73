"""Worker processes for parallel rounds: they hold the stages, get the arguments of jobs, and send answers back.

A job that was asked before is taken up by calling its function again and passing over what it gave already: stage
functions are pure, so wherever a job runs, and however often, its answers are the same.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import islice
from multiprocessing import get_context
from time import perf_counter
from typing import Any

from kabo.tasks.core.errors import UndefinedProperty
from kabo.tasks.core.jobs import Job, pull
from kabo.tasks.core.nodes import Node
from kabo.tasks.core.results import Answer, Failure, answers

_FUNCTIONS: list[Callable[..., Any]] = []  # in a worker: the stage functions, by number

Outcome = tuple[list[Answer], bool, float]


def _called(number: int, arguments: Any, taken: int) -> tuple[list[Answer], bool, bool, float]:
    began = perf_counter()
    if isinstance(arguments, UndefinedProperty):
        return [Failure("property", str(arguments))], True, False, 0.0
    source, piecemeal = answers(_FUNCTIONS[number](*arguments))
    if not piecemeal:
        return list(source), True, False, perf_counter() - began
    found, finished = pull(islice(source, taken, None))
    return found, finished, True, perf_counter() - began


class Workers:
    """A pool of processes that know the stage functions of one run; a context manager."""

    def __init__(self, nodes: Sequence[Node], functions: Sequence[Callable[..., Any]], size: int) -> None:
        self._numbers = {node: number for number, node in enumerate(nodes)}
        # Forked, so that stages need not be sent: their functions may be closures.
        _FUNCTIONS[:] = functions
        self._pool = ProcessPoolExecutor(size, mp_context=get_context("fork"))

    def __enter__(self) -> "Workers":
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)
        _FUNCTIONS.clear()

    def run(self, taken: Sequence[tuple[Node, Job]]) -> list[Outcome]:
        """The answers of jobs, in their order; each job notes how much of it was taken."""
        futures = [
            self._pool.submit(_called, self._numbers[node], job.arguments, job.taken) for node, job in taken
        ]
        outcomes: list[Outcome] = []
        for (_, job), future in zip(taken, futures, strict=True):
            found, finished, piecemeal, seconds = future.result()
            if piecemeal:
                job.taken += len(found)
            outcomes.append((found, finished, seconds))
        return outcomes
