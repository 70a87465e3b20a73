"""How far bodies are from where they should be: by the corners of the boxes around them.

The difference of two poses is affine in the point: what any point of a body is displaced by lies in the hull of what the
corners of its box are displaced by. A turn and a shift that partly cancel count as little as they move.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.execution.kernels.placed import displaced


@dataclass(frozen=True, eq=False)
class Displacement:
    """How far a body is from its place.

    Attributes:
        moves: vectors (k, 3) of the world, in whose hull is what any of its points is displaced by [m]; a single one, for
            a body that is only shifted, may be (3,).
        error: how much farther any of its points may be displaced, in any direction [m].
        longest: the length of the longest of the vectors [m]; None: it is computed.
    """

    moves: Array
    error: float = 0.0
    longest: float | None = None

    def __post_init__(self) -> None:
        moves = np.atleast_2d(self.moves)
        object.__setattr__(self, "moves", moves)
        if self.longest is None:
            object.__setattr__(self, "longest", float(np.linalg.norm(moves, axis=1).max()))

    @property
    def size(self) -> float:
        """How far any of its points is displaced at most [m]."""
        assert self.longest is not None
        return self.longest + self.error


def displacements(wanted: Sequence[Array], found: Sequence[Array], corners: Sequence[Array]) -> list[Displacement]:
    """How far bodies with these corners (8, 3) of their boxes are from their places, given their poses (4, 4)."""
    if not corners:
        return []
    moves, longest = displaced(*(np.array(each, np.float64) for each in (wanted, found, corners)))
    return [Displacement(own, longest=size) for own, size in zip(moves, longest.tolist(), strict=True)]


def displacement(wanted: Array, found: Array, corners: Array) -> Displacement:
    """How far a body with these corners of its box is from its place, given its poses (4, 4)."""
    return displacements([wanted], [found], [corners])[0]
