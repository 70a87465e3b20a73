"""The kinds of constraints between features: which shapes each relates, and what it bounds [K Table 5.1].

The language checks constraints by this table, and kinematics makes rows by it. A new kind is a line here, its rows in
`kinematics/constraints.py`, and its measure in the verifier.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

ShapePair = tuple[str, str]

DIMENSION: Mapping[str, int] = {"point": 0, "line": 1, "plane": 2}  # of each shape that a feature may have


@dataclass(frozen=True)
class Quantity:
    """A quantity that constraints measure and bound: its unit, and the least and the largest value that it can have.

    Args:
        name: its name in messages, which is also that of its constraint.
        unit: metres or radians; files may write radians in degrees.
        least, largest: bounds outside this range are refused with the sentence `outside`.
        at_least, at_largest: the constraint that fixes the quantity to that end of its range, without a bound.
        tolerance: the distance within which a bound counts as equal to an end of the range.
    """

    name: str
    unit: Literal["m", "rad"]
    least: float = -math.inf
    largest: float = math.inf
    outside: str = ""
    at_least: str | None = None
    at_largest: str | None = None
    tolerance: float = 0.0


@dataclass(frozen=True)
class ConstraintKind:
    """One kind of constraint.

    Args:
        shapes: the pairs of shapes that it relates, the lesser dimension first; none: it relates whole bodies.
        quantity: the quantity that it bounds; None if it takes no bounds.
        point_first: files must name the point first.
        directed: kinematics must not swap the features, since their order has a meaning.
    """

    shapes: frozenset[ShapePair]
    quantity: Quantity | None = None
    point_first: bool = False
    directed: bool = False

    @property
    def needs_directions(self) -> bool:
        """Whether no feature of the constraint can be a point."""
        return not any("point" in pair for pair in self.shapes)


_DIRECTIONS = frozenset({("line", "line"), ("line", "plane"), ("plane", "plane")})
_FROM_POINT = frozenset({("point", "point"), ("point", "line"), ("point", "plane")})
_DISTANCE = Quantity("distance", "m", 0.0, outside="a distance is never negative", at_least="coincident")
_HEIGHT = Quantity("height", "m")
_ANGLE = Quantity(
    "angle",
    "rad",
    least=0.0,
    largest=math.pi,
    outside="an angle lies between 0 and 180 deg",
    at_least="aligned",
    at_largest="opposed",
    tolerance=1e-9,
)

CONSTRAINT_KINDS: Mapping[str, ConstraintKind] = {
    "coincident": ConstraintKind(_FROM_POINT | {("line", "line"), ("plane", "plane")}),
    "parallel": ConstraintKind(_DIRECTIONS),
    "aligned": ConstraintKind(_DIRECTIONS),
    "opposed": ConstraintKind(_DIRECTIONS),
    "perpendicular": ConstraintKind(_DIRECTIONS),
    "distance": ConstraintKind(_FROM_POINT, _DISTANCE, point_first=True),
    "height": ConstraintKind(frozenset({("point", "plane")}), _HEIGHT, point_first=True, directed=True),
    "angle": ConstraintKind(_DIRECTIONS, _ANGLE),
    "inside": ConstraintKind(frozenset()),
}
