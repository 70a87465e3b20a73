"""Worker processes for parallel rounds: they hold the stages, get the arguments of jobs, and send answers back.

A job that was asked before is taken up by calling its function again and passing over what it gave already: stage
functions are pure, so wherever a job runs, and however often, its answers are the same.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from itertools import islice
from multiprocessing import get_context
from time import perf_counter
from typing import Any

from kabo.tasks.core.errors import TaskError, UndefinedProperty, note
from kabo.tasks.core.jobs import Job, call, pull
from kabo.tasks.core.nodes import Node
from kabo.tasks.core.results import Answer, Failure, answers

_FUNCTIONS: list[Callable[..., Any]] = []  # in a worker: the stage functions, by number

Outcome = tuple[list[Answer], bool, float]


def _begin(functions: Sequence[Callable[..., Any]]) -> None:
    _FUNCTIONS[:] = functions


def _called(number: int, arguments: Any, taken: int) -> tuple[list[Answer], bool, bool, float]:
    began = perf_counter()
    if isinstance(arguments, UndefinedProperty):
        return [Failure("property", str(arguments))], True, False, 0.0
    source, piecemeal = answers(call(_FUNCTIONS[number], arguments))
    if not piecemeal:
        return list(source), True, False, perf_counter() - began
    found, finished = pull(islice(source, taken, None))
    return found, finished, True, perf_counter() - began


class Workers:
    """A pool of processes that know the stage functions of one run; a context manager."""

    def __init__(self, nodes: Sequence[Node], functions: Sequence[Callable[..., Any]], size: int) -> None:
        self._numbers = {node: number for number, node in enumerate(nodes)}
        # Forked, so that stages need not be sent: their functions may be closures.
        self._pool = ProcessPoolExecutor(size, get_context("fork"), initializer=_begin, initargs=(functions,))

    def __enter__(self) -> "Workers":
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def run(self, taken: Sequence[tuple[Node, Job]]) -> list[Outcome]:
        """The answers of jobs, in their order; each job notes how much of it was taken.

        Raises:
            TaskError: a scene, a property or an answer cannot be sent to another process.
        """
        futures = [
            self._pool.submit(_called, self._numbers[node], job.arguments, job.taken) for node, job in taken
        ]
        results = [_result(node, future) for (node, _), future in zip(taken, futures, strict=True)]
        for (_, job), (found, _, piecemeal, _) in zip(taken, results, strict=True):
            if piecemeal:
                job.taken += len(found)
                job.source = None  # one that was begun in this process has fallen behind
        return [(found, finished, seconds) for found, finished, _, seconds in results]


def _result(node: Node, future: "Future[Any]") -> Any:
    try:
        return future.result()
    except Exception as error:
        if "pickle" in str(error):
            raise TaskError(
                f"what stage {node.stage.path!r} is given, or gives, cannot be sent to another process: {error}; "
                "plan without workers, or with scenes that can be pickled"
            ) from error
        note(error, f"in stage {node.stage.path!r}")
        raise
