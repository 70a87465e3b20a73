"""One stretch of a node's motion: the bodies that move along a path, and the bodies that stand still."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from kabo.verify.motion.sweep import Path, SweptBody


@dataclass(frozen=True, eq=False)
class MotionStretch:
    """A stretch in which the same segments run: their indices, the path, and the moving and the standing bodies.

    `permitted` are the pairs whose contact was granted, which may be fewer than the plan claims. If the node
    begins early, `before` are the segments of the preceding node that run at the same time. The first `divide`
    moving bodies are then those of the preceding node, and only pairs of one of them and one other moving body are
    checked. `roots` has for each object the one at the root of all that is attached to each other.
    """

    node: str
    segments: tuple[int, ...]
    path: Path
    moving: Sequence[SweptBody]
    standing: Sequence[SweptBody]
    permitted: frozenset[frozenset[str]] = frozenset()
    before: tuple[int, ...] = ()
    divide: int = 0
    roots: Mapping[str, str] = field(default_factory=dict)

    @property
    def name(self) -> tuple[str, tuple[int, ...], tuple[int, ...]]:
        """The name by which a certificate refers to the stretch."""
        return self.node, self.segments, self.before
