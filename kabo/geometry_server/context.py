"""What every procedure is given beside its arguments: the scene around, the seed, and how much to try."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import count, islice
from time import perf_counter
from weakref import WeakValueDictionary

from kabo.errors import CutOff
from kabo.geometry_server.candidates import BATCH_SAMPLES, Candidate
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.scene import Scene

_SHARED: "WeakValueDictionary[int, ProcedureContext]" = WeakValueDictionary()
_NUMBERS = count()


def shared(number: int) -> "ProcedureContext":
    """The context of a number: in the process that made it, and in those that were forked from it since.

    Raises:
        KeyError: it was made elsewhere.
    """
    return _SHARED[number]


@dataclass(frozen=True)
class ProcedureContext:
    """The surroundings, the seed of all streams, and how many batches of candidates and path samples to try.

    `patience`: how many candidates in a row may be blocked by what can be moved away; None: any number.
    `stop` says that time or budget is spent.
    """

    surroundings: SceneSurroundings
    seed: int
    batches: int
    path_samples: int
    stop: Callable[[], bool]
    patience: int | None = None

    def __post_init__(self) -> None:
        """Scenes of tasks travel between processes; what is around them does not."""
        object.__setattr__(self, "_number", next(_NUMBERS))
        _SHARED[self._number] = self  # type: ignore[attr-defined]

    def __reduce__(self) -> "tuple[Callable[[int], ProcedureContext], tuple[int]]":
        return shared, (self._number,)  # type: ignore[attr-defined]

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.surroundings.scene

    def drawn(self, stream: Iterable[list[Candidate]]) -> Iterator[Candidate]:
        """The candidates of a stream, batch by batch, as many as are to be tried; counts the samples.

        Raises:
            CutOff: time or budget is spent: that there are no more candidates would be no answer.
        """
        batches, statistics = islice(stream, self.batches), self.surroundings.statistics
        while True:
            began = perf_counter()
            batch = next(batches, None)
            statistics.inverse_kinematics_s += perf_counter() - began
            if batch is None:
                return
            statistics.drawn(BATCH_SAMPLES)
            for candidate in batch:
                self.look()
                yield candidate

    def look(self) -> None:
        """Raises CutOff: time or budget is spent."""
        if self.stop():
            raise CutOff
