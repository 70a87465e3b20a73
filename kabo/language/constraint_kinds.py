"""The kinds of constraints between features: related shapes and bounded quantities [K Table 5.1].

The language checks constraints by this table, and kinematics computes residuals by it. To add a kind, add a line
here, its residuals in `kinematics/constraints.py`, and its measure in the verifier.
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
        name: the name of the quantity in messages, which is also the name of the constraint that bounds it.
        unit: metres or radians; files may give radians in degrees.
        least, largest: the range of the quantity; bounds outside this range are refused with the message
            `outside`.
        at_least, at_largest: the constraint without bounds that fixes the quantity to `least`, or to `largest`.
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
        shapes: the pairs of shapes that the constraint can relate, the lesser dimension first; empty if it relates
            whole bodies.
        quantity: the quantity that the constraint bounds; None if it takes no bounds.
        point_first: whether files must name the point before the other feature.
        directed: whether the order of the features has a meaning, so that kinematics must not swap them.
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
