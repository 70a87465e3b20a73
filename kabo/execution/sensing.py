"""Sensors that know the truth: outcomes that are given, or drawn from a seed; poses of the robot's own world."""

from collections.abc import Callable, Mapping

from kabo.arrays import Array
from kabo.given import require_function, require_given
from kabo.options import require_seed
from kabo.streams import stream_key, uniforms


class KnownTruth:
    """Answers from a table; what is not in it is drawn by the seed, each outcome with the same probability.

    Args:
        truth: outcomes by formula, as the plan spells them, and values by term.
        seed: of what is not given.
        poses: of bodies, in the world.

    Raises:
        ArgumentError: an argument is of a wrong kind.
    """

    def __init__(
        self,
        truth: Mapping[str, str] = {},
        seed: int = 0,
        poses: Callable[[], Mapping[str, Array]] = dict,
    ) -> None:
        require_given("truth", truth, Mapping)
        require_seed(seed)
        require_function("poses", poses)
        self.truth, self.seed, self._poses = truth, seed, poses

    def resolve(self, formula: str, outcomes: tuple[str, ...]) -> str | None:
        """The true outcome."""
        if formula in self.truth:
            return self.truth[formula]
        drawn = float(uniforms(stream_key("truth", self.seed, formula), 0, 1, 1)[0, 0])
        return outcomes[int(drawn * len(outcomes))]

    def value(self, term: str) -> object | None:
        """The true value; a term that is not given has its own name as its value."""
        return self.truth.get(term, term)

    def poses(self) -> Mapping[str, Array]:
        """Where bodies are."""
        return self._poses()
