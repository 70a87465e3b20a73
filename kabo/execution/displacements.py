"""How far bodies are from where they should be: by the corners of the boxes around them.

The difference of two poses is affine in the point: what any point of a body is displaced by lies in the hull of what the
corners of its box are displaced by. A turn and a shift that partly cancel count as little as they move.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from kabo.arrays import Array
from kabo.scene import Mesh


@dataclass(frozen=True, eq=False)
class Displacement:
    """How far a body is from its place.

    Attributes:
        moves: vectors (k, 3) of the world, in whose hull is what any of its points is displaced by [m]; a single one, for
            a body that is only shifted, may be (3,).
        error: how much farther any of its points may be displaced, in any direction [m].
    """

    moves: Array
    error: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "moves", np.atleast_2d(self.moves))

    @property
    def size(self) -> float:
        """How far any of its points is displaced at most [m]."""
        return float(np.sqrt(np.einsum("ki,ki->k", self.moves, self.moves).max())) + self.error


def box_corners(mesh: Mesh) -> Array:
    """The corners (8, 3) of the box around a mesh, in its own frame [m]."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    return np.array(list(product(*zip(low, high, strict=True))))


def moves(wanted: Sequence[Array], found: Sequence[Array], corners: Sequence[Array]) -> Array:
    """What the corners (8, 3) of several bodies' boxes are displaced by (n, 8, 3), given their poses (4, 4) [m]."""
    if not corners:
        return np.zeros((0, 8, 3))
    off = np.stack(found) - np.stack(wanted)
    return np.asarray(np.stack(corners) @ off[:, :3, :3].transpose(0, 2, 1) + off[:, None, :3, 3])


def displacement(wanted: Array, found: Array, corners: Array) -> Displacement:
    """How far a body with these corners of its box is from its place, given its poses (4, 4)."""
    return Displacement(moves([wanted], [found], [corners])[0])
