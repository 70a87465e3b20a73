"""The measures of a scene's constraints, in plain numpy: lengths and angles between features, with their bounds.

Every constraint becomes measures, each a length or an angle with bounds. Lines and planes may coincide or be parallel in
either sense; `aligned` and `opposed` fix the sense [docs/explanation/sampling.md#which-constraints; K Table 5.1].
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from kabo.arrays import Array
from kabo.language.scene_description import Constraint, Feature, FeatureName

LENGTH_TOLERANCE, ANGLE_TOLERANCE = 1e-3, 1e-3  # [m], [rad] by which a constraint may be violated


@dataclass(frozen=True)
class Role:
    """The body in a role of constraints: its features, and its pose world_T (4, 4)."""

    features: Mapping[str, Feature]
    world_T: Array


@dataclass(frozen=True)
class Measure:
    """A length [m] or angle [rad] with its bounds."""

    kind: Literal["length", "angle"]
    value: float
    lower: float
    upper: float

    @property
    def excess(self) -> float:
        """The amount by which the value is outside of its bounds; negative inside."""
        return max(self.lower - self.value, self.value - self.upper)

    @property
    def tolerance(self) -> float:
        """The amount by which the bounds may be violated."""
        return LENGTH_TOLERANCE if self.kind == "length" else ANGLE_TOLERANCE


@dataclass(frozen=True)
class _Placed:
    kind: str
    origin: Array
    direction: Array


WORLD = Role(
    {
        "origin": Feature("point", (0.0, 0.0, 0.0)),
        "up": Feature("line", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        "floor": Feature("plane", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    },
    np.eye(4),
)


class UnknownFeatureError(Exception):
    """A constraint names a role or feature that does not exist."""


def missed(
    constraints: Sequence[Constraint], roles: Mapping[str, Role], length: float = LENGTH_TOLERANCE
) -> tuple[Constraint, Measure] | None:
    """The constraint that is violated most beyond its tolerance, with the measure; None if all hold.

    Lengths have the tolerance `length` [m]. `inside` is not checked here: it is a predicate on whole bodies.
    """
    worst: tuple[Constraint, Measure] | None = None
    most = 1.0
    for constraint in constraints:
        for measure in measures(constraint, roles):
            over = measure.excess / (length if measure.kind == "length" else measure.tolerance)
            if over > most:
                most, worst = over, (constraint, measure)
    return worst


def measures(constraint: Constraint, roles: Mapping[str, Role]) -> Iterator[Measure]:
    """The measures of a constraint."""
    if constraint.kind == "inside":
        return
    a, b = _placed(constraint.first, roles), _placed(constraint.second, roles)
    low = -np.inf if constraint.lower is None else constraint.lower
    high = np.inf if constraint.upper is None else constraint.upper
    if constraint.kind == "distance":
        yield Measure("length", _distance(a, b), low, high)
    elif constraint.kind == "height":
        point, plane = (a, b) if b.kind == "plane" else (b, a)
        yield Measure("length", float((point.origin - plane.origin) @ plane.direction), low, high)
    elif constraint.kind == "angle":
        yield Measure("angle", _angle(a.direction, b.direction), low, high)
    elif constraint.kind == "coincident":
        yield from _coincident(a, b)
    else:
        yield _directed(constraint.kind, a, b)


def _placed(name: FeatureName, roles: Mapping[str, Role]) -> _Placed:
    role = WORLD if name.owner == "world" else roles.get(name.owner)
    feature = None if role is None or name.feature is None else role.features.get(name.feature)
    if role is None or feature is None:
        raise UnknownFeatureError(str(name))
    rotation = role.world_T[:3, :3]
    direction = np.zeros(3) if feature.direction is None else rotation @ np.asarray(feature.direction)
    return _Placed(feature.kind, rotation @ np.asarray(feature.origin) + role.world_T[:3, 3], direction)


def _angle(first: Array, second: Array) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second))


def _either_sense(first: Array, second: Array) -> float:
    angle = _angle(first, second)
    return min(angle, np.pi - angle)


def _distance(a: _Placed, b: _Placed) -> float:
    """The distance of a point from a point, a line or a plane."""
    if a.kind != "point":
        a, b = b, a
    between = a.origin - b.origin
    if b.kind == "point":
        return float(np.linalg.norm(between))
    along = float(between @ b.direction)
    return abs(along) if b.kind == "plane" else float(np.linalg.norm(between - along * b.direction))


def _coincident(a: _Placed, b: _Placed) -> Iterator[Measure]:
    if "point" in (a.kind, b.kind):
        yield Measure("length", _distance(a, b), 0.0, 0.0)
        return
    yield Measure("angle", _either_sense(a.direction, b.direction), 0.0, 0.0)
    yield Measure("length", _distance(_Placed("point", a.origin, a.direction), b), 0.0, 0.0)


def _directed(kind: str, a: _Placed, b: _Placed) -> Measure:
    """The measure of `parallel`, `aligned`, `opposed` or `perpendicular`.

    A line parallel to a plane is at right angles to its normal; `aligned`, `opposed` and `perpendicular` put the line
    along the normal.
    """
    mixed = {a.kind, b.kind} == {"line", "plane"}
    if kind == "aligned":
        return Measure("angle", _angle(a.direction, b.direction), 0.0, 0.0)
    if kind == "opposed":
        return Measure("angle", np.pi - _angle(a.direction, b.direction), 0.0, 0.0)
    if (kind == "parallel") != mixed:
        return Measure("angle", _either_sense(a.direction, b.direction), 0.0, 0.0)
    return Measure("angle", _angle(a.direction, b.direction), np.pi / 2, np.pi / 2)
