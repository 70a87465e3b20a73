"""The convex parts in a certificate, and the proof, triangle by triangle, that they enclose a mesh."""

import hashlib
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.plan import BodyParts
from kabo.scene import Mesh
from kabo.verify.certificate.cover import uncovered

MAX_COORDINATE = 1e6  # [m] a part with a vertex farther away is refused


_COVERED: dict[tuple[str, str], int | None] = {}  # results of this process, by digests of mesh and parts
MAX_COVERED = 4096  # results kept, of some 400 bytes each


class Parts:
    """The convex parts that a certificate gives for one body, in the body's frame."""

    def __init__(self, given: BodyParts) -> None:
        """Raises ValueError for an empty part, or a vertex that is not finite or farther away than `MAX_COORDINATE`."""
        self.vertices = np.frombuffer(given.vertices, "<f8").astype(np.float64).reshape(-1, 3)
        self.starts = np.concatenate([[0], np.cumsum(given.sizes)]).astype(int)
        if min(given.sizes, default=0) < 1 or self.starts[-1] != len(self.vertices):
            raise ValueError("a part without vertices, or of more than there are")
        if not (np.abs(self.vertices) <= MAX_COORDINATE).all():
            raise ValueError("a vertex that is no finite number, or far away")
        self._exact: Any = None
        self.lower = np.minimum.reduceat(self.vertices, self.starts[:-1])
        self.upper = np.maximum.reduceat(self.vertices, self.starts[:-1])

    @property
    def all(self) -> tuple[int, int]:
        """The pair (0, number of parts), the range of all parts."""
        return 0, len(self.lower)

    @cached_property
    def radius(self) -> float:
        """The greatest distance of a vertex from the origin of the body's frame [m]."""
        return float(np.linalg.norm(self.vertices, axis=1).max())

    def range(self, low: int, high: int) -> Array:
        """The vertices (V, 3) of parts low to high - 1."""
        return self.vertices[self.starts[low] : self.starts[high]]

    @cached_property
    def ranges(self) -> dict[tuple[int, int], int]:
        """Every range that arises when the range of all parts is halved repeatedly, with its index in `boxes`."""
        found, ahead = [], [self.all]
        while ahead:
            low, high = ahead.pop()
            found.append((low, high))
            if high - low > 1:
                middle = (low + high) // 2
                ahead += [(low, middle), (middle, high)]
        return {own: i for i, own in enumerate(found)}

    @cached_property
    def boxes(self) -> tuple[Array, Array]:
        """The middles and half extents (R, 3) of the boxes around each of `ranges`, in the body's frame."""
        least = np.array([self.lower[low:high].min(axis=0) for low, high in self.ranges])
        most = np.array([self.upper[low:high].max(axis=0) for low, high in self.ranges])
        return 0.5 * (least + most), 0.5 * (most - least)

    def exact(self, integers: Callable[[Array], Any]) -> Any:
        """All vertices, converted to fixed-point integers by the function `integers` at the first call."""
        if self._exact is None:
            self._exact = integers(self.vertices)
        return self._exact

    def missing(self, mesh: Mesh) -> int | None:
        """The index of the first triangle of a mesh that the parts do not cover, or None; results are cached."""
        key = mesh.digest, hashlib.sha256(self.vertices.tobytes() + self.starts.tobytes()).hexdigest()
        if key not in _COVERED:
            if len(_COVERED) >= MAX_COVERED:
                _COVERED.clear()
            parts = [self.range(i, i + 1) for i in range(len(self.lower))]
            _COVERED[key] = uncovered(mesh.vertices, mesh.faces, parts)
        return _COVERED[key]
