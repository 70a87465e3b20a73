"""The context of procedure calls: the surroundings, the seed, and the numbers of attempts to make."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import count, islice
from time import perf_counter
from weakref import WeakValueDictionary

from kabo.errors import CutOff
from kabo.geometry_server.candidates import BATCH_SAMPLES
from kabo.geometry_server.configurations import Candidate
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.scene import Scene

EMPTY_BATCHES = 64  # of a stream without a candidate, after which it is asked whether there can be any

_SHARED: "WeakValueDictionary[int, ProcedureContext]" = WeakValueDictionary()
_NUMBERS = count()


def shared(number: int) -> "ProcedureContext":
    """The context with index `number`, looked up in the process that made the context or in a later fork of it.

    Raises:
        KeyError: the context was made in another process.
    """
    return _SHARED[number]


@dataclass(frozen=True)
class ProcedureContext:
    """The surroundings, the seed of all streams, and the numbers of candidate batches and path samples to try.

    `patience`: the number of consecutive candidates that movable objects may block; None: no limit. `stop` returns
    whether time or budget is spent.
    """

    surroundings: SceneSurroundings
    seed: int
    batches: int
    path_samples: int
    stop: Callable[[], bool]
    patience: int | None = None

    def __post_init__(self) -> None:
        """Registers the context under a new index, by which it is pickled: forked workers already hold its surroundings."""
        object.__setattr__(self, "_number", next(_NUMBERS))
        _SHARED[self._number] = self  # type: ignore[attr-defined]

    def __reduce__(self) -> "tuple[Callable[[int], ProcedureContext], tuple[int]]":
        return shared, (self._number,)  # type: ignore[attr-defined]

    @property
    def scene(self) -> Scene:
        """The scene of the surroundings."""
        return self.surroundings.scene

    @property
    def tries_again(self) -> bool:
        """Whether the least effort has failed, so that it is worth looking for what no effort would change."""
        return self.patience is None

    def candidates(
        self, stream: Iterable[list[Candidate]], hopeless: Callable[[], bool] = lambda: False
    ) -> Iterator[Candidate]:
        """The candidates of the first `batches` batches of a stream; counts the samples.

        If the first `EMPTY_BATCHES` have none, `hopeless` is called once; True ends the stream.

        Raises:
            CutOff: time or budget is spent, which is different from having no more candidates.
        """
        batches, statistics = islice(stream, self.batches), self.surroundings.statistics
        found = False
        for number in count():
            if number == EMPTY_BATCHES and not found and hopeless():
                return
            self.look()
            began = perf_counter()
            batch = next(batches, None)
            statistics.inverse_kinematics_s += perf_counter() - began
            if batch is None:
                return
            statistics.count_samples(BATCH_SAMPLES)
            found = found or bool(batch)
            for candidate in batch:
                self.look()
                yield candidate

    def look(self) -> None:
        """Raises CutOff if time or budget is spent."""
        if self.stop():
            raise CutOff
