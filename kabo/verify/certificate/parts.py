"""The convex parts in a certificate, and the proof, triangle by triangle, that they enclose a mesh."""

import hashlib
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.plan import BodyParts
from kabo.scene import Element, Mesh
from kabo.verify.certificate.cover import uncovered

MAX_COORDINATE = 1e6  # [m] a part with a vertex farther away is refused
AXIS_TOLERANCE = 1e-12  # by which the length of a disc's axis may differ from 1


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
        rounds = np.frombuffer(given.rounds, "<f8").astype(np.float64).reshape(-1, 5)
        rounds = rounds if len(rounds) else np.tile([0.0, 0.0, 0.0, 0.0, 1.0], (len(given.sizes), 1))
        if (
            len(rounds) != len(given.sizes)
            or not ((rounds[:, :2] >= 0.0) & (rounds[:, :2] <= MAX_COORDINATE)).all()
        ):
            raise ValueError("a part's rounding that is no radius")
        self.balls, self.discs, self.axes = rounds[:, 0], rounds[:, 1], rounds[:, 2:]
        if not (np.abs(np.linalg.norm(self.axes, axis=1) - 1.0) <= AXIS_TOLERANCE).all():
            raise ValueError("the axis of a part's disc does not have length 1")
        self.rounded = bool(rounds[:, :2].any())
        # A disc of radius s across n reaches s |e x n| along a coordinate axis e.
        across = np.hypot(self.axes[:, [1, 2, 0]], self.axes[:, [2, 0, 1]])
        reach = self.balls[:, None] + self.discs[:, None] * across
        self.lower = np.minimum.reduceat(self.vertices, self.starts[:-1]) - reach
        self.upper = np.maximum.reduceat(self.vertices, self.starts[:-1]) + reach

    @property
    def all(self) -> tuple[int, int]:
        """The pair (0, number of parts), the range of all parts."""
        return 0, len(self.lower)

    @cached_property
    def radius(self) -> float:
        """How far any point of the parts may be from the origin of the body's frame [m]."""
        return float((np.linalg.norm(self.vertices, axis=1) + self.of_vertices(self.balls + self.discs)).max())

    def of_vertices(self, values: Array, low: int = 0, high: int | None = None) -> Array:
        """Values of parts, once for each vertex of the parts low to high - 1."""
        counts = np.diff(self.starts[low : (len(self.lower) if high is None else high) + 1])
        return np.repeat(values[low:high], counts, axis=0)

    def bulges(self, low: int, high: int, axes: Array) -> Array:
        """How far ball and disc reach beyond each vertex of parts along axes (P, 3) of the body's frame: (V, P) [m]."""
        across = np.linalg.norm(np.cross(axes[None], self.axes[low:high, None]), axis=2)
        lengths = np.linalg.norm(axes, axis=1)
        own = self.balls[low:high, None] * lengths + self.discs[low:high, None] * across
        return np.repeat(own, np.diff(self.starts[low : high + 1]), axis=0)

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

    def missing(self, elements: Sequence[Element]) -> str | None:
        """What of a body's elements the parts do not cover; None if they cover all. Results are cached.

        A box or a round element may be a part by itself; what is not must be covered triangle by triangle, round
        elements with the mesh that lies around them.
        """
        for element in elements:
            if not self._has(element) and (triangle := self._uncovered(element.mesh)) is not None:
                return f"triangle {triangle} sticks out"
        return None

    def _has(self, element: Element) -> bool:
        """Whether a part has the element's corners, and at least its ball and its disc."""
        if element.corners is None:
            return False
        ball, disc, axis = element.rounding or (0.0, 0.0, (0.0, 0.0, 1.0))
        for part in range(len(self.lower)):
            own = self.range(part, part + 1)
            if own.shape == element.corners.shape and (own == element.corners).all():
                across = disc == 0.0 or (self.axes[part] == axis).all()
                if self.balls[part] >= ball and self.discs[part] >= disc and across:
                    return True
        return False

    def _uncovered(self, mesh: Mesh) -> int | None:
        key = mesh.digest, hashlib.sha256(self.vertices.tobytes() + self.starts.tobytes()).hexdigest()
        if key not in _COVERED:
            if len(_COVERED) >= MAX_COVERED:
                _COVERED.clear()
            parts = [self.range(i, i + 1) for i in range(len(self.lower))]
            _COVERED[key] = uncovered(mesh.vertices, mesh.faces, parts)
        return _COVERED[key]
