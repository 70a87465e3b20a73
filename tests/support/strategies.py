"""Bodies, gaps and poses for geometric laws: distances are known by construction, and shapes are as bad as they get.

A pair of shapes touches the plane z = 0 at the origin from above and from below; sliding the upper one along z by a
gap makes that gap its distance, whatever the shapes are: points, needles, plates, slivers, wedges, boxes, blobs.
"""

from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st

KINDS = ("point", "needle", "spike", "lance", "plate", "sliver", "wedge", "box", "blob")
IDENTITY = np.array([1.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0])
DEPTH = 1e-3  # of every thick shape straight above the origin [m]
GAPS = (-5e-4, -1e-6, -1e-12, 0.0, 1e-12, 1e-10, 5e-10)  # metres; those about clearance and epsilon are added


@dataclass(frozen=True)
class Shape:
    """A convex vertex set with z >= 0 whose hull contains the origin."""

    vertices: np.ndarray  # (V <= 24, 3)
    flat: bool  # all of it lies in z = 0
    thick: bool  # contains the segment from the origin to (0, 0, DEPTH)


@dataclass(frozen=True)
class Touching:
    """Two shapes on either side of z = 0, in a frame that may lie anywhere."""

    upper: np.ndarray
    lower: np.ndarray
    placement: np.ndarray  # (12,) the frame's pose in the world
    overlap: float | None  # the distance per metre of a negative gap: 0 if the shapes meet, None if not known

    def distances(self, gaps: np.ndarray) -> np.ndarray:
        """The true distance for every gap; NaN where the construction does not tell."""
        below = np.nan if self.overlap is None else self.overlap
        return np.where(gaps >= 0, gaps, np.where(gaps < 0, -gaps * below, gaps))


def placement_of(quaternion, translation) -> np.ndarray:
    """A pose (12,) whose rotation has rational entries: those of an integer quaternion."""
    w, x, y, z = quaternion
    n = w * w + x * x + y * y + z * z
    R = np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )
    return np.concatenate([(R / n).ravel(), translation])


def _ring(rng, size, pairs):
    """Points in z = 0 about the origin: each with its mirror image, so that the origin is in their hull exactly."""
    half = np.zeros((pairs, 3))
    half[:, :2] = rng.uniform(-size, size, (pairs, 2))
    return np.concatenate([half, -half])


def shape(kind: str, rng: np.random.Generator) -> Shape:
    """A random shape of a kind, a tenth of a millimetre to ten metres large."""
    size, origin = 10.0 ** rng.uniform(-4, 1), np.zeros((1, 3))
    height = max(2 * DEPTH, 10.0 ** rng.uniform(-4, 1))
    top = np.array([[0.0, 0.0, height]])
    if kind == "point":
        return Shape(origin, flat=True, thick=False)
    if kind == "needle":
        return Shape(_ring(rng, size, 1), flat=True, thick=False)
    if kind == "spike":
        return Shape(np.concatenate([origin, top]), flat=False, thick=True)
    if kind == "lance":
        far = np.array([[*rng.uniform(-size, size, 2), height * rng.choice([1e-9, 1e-4, 1.0])]])
        return Shape(np.concatenate([origin, far]), flat=False, thick=False)
    if kind == "plate":
        return Shape(_ring(rng, size, int(rng.integers(2, 13))), flat=True, thick=False)
    if kind == "sliver":
        thin = _ring(rng, size, 1)
        thin[:, 2] = 10.0 ** rng.uniform(-12, -5, 2)
        return Shape(np.concatenate([_ring(rng, size, 1), thin]), flat=False, thick=False)
    if kind == "wedge":
        sides = _ring(rng, size, 5)
        sides[:, 2] = np.linalg.norm(sides[:, :2], axis=1) * 10.0 ** rng.uniform(-10, -2)
        return Shape(np.concatenate([_ring(rng, size, 1), sides, top]), flat=False, thick=True)
    if kind == "box":
        x, y = 10.0 ** rng.uniform(-4, 1, 2)
        corners = np.array([[i * x, j * y, k * height] for i in (-1, 1) for j in (-1, 1) for k in (0, 1)])
        return Shape(corners, flat=False, thick=True)
    cloud = rng.uniform(-size, size, (int(rng.integers(3, 14)), 3))
    cloud[:, 2] = np.abs(cloud[:, 2])
    foot = [origin, _ring(rng, size, 1), _ring(rng, size, 3)][int(rng.integers(3))]
    return Shape(np.concatenate([foot, cloud, top]), flat=False, thick=True)


def touching(first: str, second: str, placement: np.ndarray, rng: np.random.Generator) -> Touching:
    """A pair of shapes of two kinds in a placed frame; the lower one is a shape upside down, turned about z."""
    upper, lower = shape(first, rng), shape(second, rng)
    overlap = 0.0 if upper.thick or lower.thick else 1.0 if upper.flat and lower.flat else None
    turn = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    return Touching(upper.vertices, lower.vertices @ turn.T, placement, overlap)


def gaps_about(*values: float) -> np.ndarray:
    """The gaps that a predicate with these thresholds should be asked about [m]."""
    near = [v + d for v in values for d in (-1e-6, -1e-9, -1e-12, 0.0, 1e-12, 1e-9, 1e-6)]
    return np.unique(np.concatenate([GAPS, near, *([0.5 * v, 3.0 * v] for v in values)]))


@st.composite
def rational_placements(draw):
    """Rotations with rational entries (signed permutations among them) and offsets up to a hundred metres."""
    quaternion = draw(st.tuples(*[st.integers(-4, 4)] * 4).map(lambda q: q if any(q) else (1, 0, 0, 0)))
    offset = draw(st.sampled_from([0.0, 0.0, 1.0, 10.0, 57.0]))
    return placement_of(quaternion, np.array(draw(st.tuples(*[st.integers(-64, 64)] * 3))) / 64 * offset)


@st.composite
def touching_pairs(draw, count=5):
    """`count` pairs of all kinds of shapes, two of which are drawn; numbers come from a drawn seed."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    placement, kinds = draw(rational_placements()), [draw(st.sampled_from(KINDS)) for _ in range(2)]
    others = rng.choice(KINDS, (count - 1, 2))
    return [touching(*kinds, placement, rng)] + [touching(*k, placement, rng) for k in others]


def healthy_part(rng: np.random.Generator, size: float) -> np.ndarray:
    """A part with a volume: the corners of a cube shaken, and a few points more."""
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * rng.uniform(
        0.5, 1.0, (8, 1)
    )
    more = rng.uniform(-0.7, 0.7, (int(rng.integers(0, 17)), 3))
    return np.concatenate([corners, more]) * size * rng.uniform(0.2, 1.0, 3)
