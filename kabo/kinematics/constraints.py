"""Geometric constraints as flat scalar rows, the form that projection and proofs use.

Source: K Table 5.1, docs/explanation/sampling.md.

A constraint between two features becomes as many scalar rows as it removes degrees of freedom, so that the
Jacobian has the right null space [K 5.2.2]. Angular rows are scaled to metres by a lever arm.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array
from kabo.kinematics.kernels import rows as columns
from kabo.language.constraint_kinds import CONSTRAINT_KINDS, DIMENSION, ConstraintKind

Numbers = Sequence[float] | Array
Vector = tuple[float, float, float]
Rows = Array  # (R, WIDTH): columns in kernels/rows.py

LEVER_ARM = 0.15  # [m/rad] the size of objects in a gripper, so that angular rows weigh as much as the others
ROW_TOLERANCE = 1e-6  # [m or rad] within which a row counts as fulfilled
_AZIMUTH = ConstraintKind(frozenset({("line", "line"), ("line", "plane"), ("plane", "plane")}), directed=True)


@dataclass(frozen=True)
class FrameFeature:
    """A point, a directed line or a plane that moves with a joint of a tree (0: the world).

    `origin` [m] and `direction` (unit: along the line, normal of the plane) are in the joint's frame.
    """

    joint: int
    kind: Literal["point", "line", "plane"]
    origin: Vector
    direction: Vector | None = None

    @property
    def along(self) -> Vector:
        """The direction of a line or plane.

        Raises:
            ValueError: the feature is a point.
        """
        if self.direction is None:
            raise ValueError("a point has no direction")
        return self.direction

    def __post_init__(self) -> None:
        if not math.isfinite(sum(self.origin)):
            raise ValueError(f"the origin of a feature is not finite: {self.origin}")
        if self.kind != "point":
            length = 0.0 if self.direction is None else math.hypot(*self.direction)
            if not abs(length - 1.0) <= 1e-6:
                raise ValueError(f"the direction of a {self.kind} must be a unit vector, not {self.direction}")


def rows_of(
    kind: str, first: FrameFeature, second: FrameFeature, lower: float | None = None, upper: float | None = None
) -> Rows:
    """The rows (R, WIDTH) of one constraint between two features.

    Source: K Table 5.1, docs/explanation/sampling.md#which-constraints.

    Args:
        kind: coincident, parallel, aligned, opposed, perpendicular, distance, height, angle, or azimuth. An azimuth is
            the angle of the first direction about the second line; it serves only to spread samples.
        first, second: the two features; their order matters for `height` and `azimuth` only.
        lower, upper: the bounds of a distance or height [m] or an angle [rad]; None means no bound.

    Raises:
        ValueError: the kind is undefined for these shapes, or bounds are missing, superfluous or crossed.
    """
    if kind not in _MAKERS:
        raise ValueError(f"unknown constraint {kind}")
    known = _AZIMUTH if kind == "azimuth" else CONSTRAINT_KINDS[kind]
    if known.quantity is not None:
        if lower is None and upper is None:
            raise ValueError(f"{kind} needs a bound")
        if lower is not None and upper is not None and not lower <= upper:
            raise ValueError(f"the bounds of {kind} are crossed: {lower} > {upper}")
    elif kind != "azimuth" and (lower is not None or upper is not None):
        raise ValueError(f"{kind} takes no bounds")
    if known.needs_directions and "point" in (first.kind, second.kind):
        raise ValueError(f"{kind} needs directions; a point has none")
    if not known.directed and DIMENSION[first.kind] > DIMENSION[second.kind]:
        first, second = second, first
    return np.array(_MAKERS[kind](first, second, lower, upper))


def stacked(parts: Sequence[Rows]) -> Rows:
    """The conjunction of several constraints: all their rows, (R, WIDTH); (0, WIDTH) for no constraint."""
    return np.ascontiguousarray(np.concatenate([np.empty((0, columns.WIDTH)), *parts]))


def _row(
    kind: int,
    first: FrameFeature,
    second: FrameFeature,
    *,
    origins: tuple[Numbers, Numbers] | None = None,
    directions: tuple[Numbers, Numbers] | None = None,
    bounds: tuple[float, float] = (0.0, 0.0),
) -> Array:
    origin, target = origins or (first.origin, second.origin)
    along, normal = directions or (first.direction or (0.0,) * 3, second.direction or (0.0,) * 3)
    scale = 1.0 if kind < columns.DIRECTION else LEVER_ARM
    return np.array(
        [kind, first.joint, *origin, *along, second.joint, *target, *normal, *bounds, scale, ROW_TOLERANCE],
        np.float64,
    )


def normals(direction: ArrayLike) -> Array:
    """Two unit vectors (2, 3) that complete a direction to a right-handed frame: null(d) of [K Table 5.1]."""
    a, b, c = np.asarray(direction, np.float64).tolist()
    length = math.hypot(a, b, c)
    d = a / length, b / length, c / length
    x = columns.any_normal(*d)
    return np.array([x, columns.crossed(*d, *x)])


def _on_planes(first: FrameFeature, second: FrameFeature, directions: Array) -> list[Array]:
    """Rows that hold where the first origin lies on the planes through the second origin with given normals."""
    return [_row(columns.PLANE, first, second, directions=(first.direction or (0.0,) * 3, n)) for n in directions]


def _span(b: FrameFeature) -> Array:
    """The directions in which a point on this line or plane cannot move: normals (k, 3)."""
    return normals(b.along) if b.kind == "line" else np.array([b.along])


def _coincident(a: FrameFeature, b: FrameFeature, *_: object) -> list[Array]:
    if a.kind == "point":
        return _on_planes(a, b, np.eye(3) if b.kind == "point" else _span(b))
    if a.kind != b.kind:
        raise ValueError(f"a {a.kind} and a {b.kind} cannot coincide; name a point of one, and parallel")
    return _on_planes(a, b, _span(b)) + _parallel(a, b)


def _same_line(a: FrameFeature, b: FrameFeature) -> list[Array]:
    return [_row(columns.DIRECTION, a, b, directions=(n, b.along)) for n in normals(a.along)]


def _parallel(a: FrameFeature, b: FrameFeature, *_: object) -> list[Array]:
    if a.kind == b.kind:
        return _same_line(a, b)
    return [_row(columns.DIRECTION, a, b)]


def _perpendicular(a: FrameFeature, b: FrameFeature, *_: object) -> list[Array]:
    if a.kind == b.kind:
        return [_row(columns.DIRECTION, a, b)]
    return _same_line(a, b)


def _aligned(a: FrameFeature, b: FrameFeature, *_: object, sense: float = 1.0) -> list[Array]:
    direction = tuple(sense * np.asarray(a.direction))
    return [
        _row(columns.ALIGNED, a, b, origins=(direction, b.origin), directions=(n, b.along))
        for n in normals(direction)
    ]


def _opposed(a: FrameFeature, b: FrameFeature, *_: object) -> list[Array]:
    return _aligned(a, b, sense=-1.0)


def _distance(a: FrameFeature, b: FrameFeature, lower: float | None, upper: float | None) -> list[Array]:
    if a.kind != "point":
        raise ValueError(f"distance is measured from a point, not from a {a.kind}")
    kind = {"point": columns.POINT, "line": columns.LINE, "plane": columns.GAP}[b.kind]
    bounds = (max(lower or 0.0, 0.0), np.inf if upper is None else upper)
    if bounds[1] == 0.0:
        return _coincident(a, b)
    if bounds[1] < 0.0:
        raise ValueError("a distance is never negative")
    return [_row(kind, a, b, bounds=bounds)]


def _height(a: FrameFeature, b: FrameFeature, lower: float | None, upper: float | None) -> list[Array]:
    if a.kind != "point" or b.kind != "plane":
        raise ValueError(f"height is that of a point above a plane, not of a {a.kind} above a {b.kind}")
    return [_row(columns.PLANE, a, b, bounds=_limits(lower, upper))]


def _angle(a: FrameFeature, b: FrameFeature, lower: float | None, upper: float | None) -> list[Array]:
    low, high = max(lower or 0.0, 0.0), np.pi if upper is None else min(upper, np.pi)
    if low > high:
        raise ValueError("an angle lies between 0 and 180 degrees")
    if high == 0.0:
        return _aligned(a, b)
    if low == np.pi:
        return _opposed(a, b)
    return [_row(columns.ANGLE, a, b, bounds=(low, high))]


def _azimuth(a: FrameFeature, b: FrameFeature, lower: float | None, upper: float | None) -> list[Array]:
    bounds = (-np.pi if lower is None else lower, np.pi if upper is None else upper)
    return [_row(columns.AZIMUTH, a, b, origins=(a.origin, tuple(normals(b.along)[0])), bounds=bounds)]


def _limits(lower: float | None, upper: float | None) -> tuple[float, float]:
    return -np.inf if lower is None else lower, np.inf if upper is None else upper


_MAKERS: dict[str, Callable[..., list[Array]]] = {
    "coincident": _coincident,
    "parallel": _parallel,
    "aligned": _aligned,
    "opposed": _opposed,
    "perpendicular": _perpendicular,
    "distance": _distance,
    "height": _height,
    "angle": _angle,
    "azimuth": _azimuth,
}
