"""One stretch of a node's motion as it was walked: what moves along one path, and what stands meanwhile."""

from collections.abc import Sequence
from dataclasses import dataclass

from kabo.verify.motion.sweep import Path, Thing


@dataclass(frozen=True, eq=False)
class Course:
    """A stretch in which the same segments are under way: their numbers, the path, what moves along it, what stands.

    `permitted` are the pairs whose contact was granted there, which may be fewer than the plan asks for. `before` are
    the segments of the node before that are under way, too, if this one begins early; the first `divide` of the moving
    things are theirs, and only pairs of one of them and another thing matter.
    """

    node: str
    segments: tuple[int, ...]
    path: Path
    moving: Sequence[Thing]
    standing: Sequence[Thing]
    permitted: frozenset[frozenset[str]] = frozenset()
    before: tuple[int, ...] = ()
    divide: int = 0

    @property
    def name(self) -> tuple[str, tuple[int, ...], tuple[int, ...]]:
        """What a proof calls it."""
        return self.node, self.segments, self.before
