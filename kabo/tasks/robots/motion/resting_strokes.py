"""Strokes next to where a motion rests: approaches, lifts, lowerings and retreats.

There bodies touch, or nearly do. So the motion leaves exactly along the first straight piece of its path, and is near its
path the more closely the nearer it is to the rest. Farther away corners are rounded, while the tool keeps its line.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.motion.blending import CORNER_SHARE
from kabo.tasks.robots.motion.parts import MotionPart
from kabo.tasks.robots.motion.tool_lines import STRAIGHT_SHARE, ToolLine, tool_line

CLOSENESS = 0.01  # rad by which a joint may leave the path, for each rad of the way from the rest
INNER_DEVIATION = 3e-4  # rad, L2, by which the motion passes by corners of the stroke's path
ROUNDING = 1e-8  # rad
CURVED = 5e-6  # rad by which the motion may leave the chords of a curve where it rests


@dataclass(frozen=True)
class RestingStroke:
    """A part of a route, its corners from the rest on, and their distances from it along the path [rad, L2]."""

    part: MotionPart
    corners: tuple[int, ...]
    distances: tuple[float, ...]
    line: ToolLine | None

    def greatest_trims(self, places: Array, bends: Array) -> Array:
        """The greatest trims (m,) [rad, L2] of the corners of the route with which the stroke keeps its shape.

        Args:
            places: of the corners along the path (m,) [rad, L2].
            bends: the norm of the turn at each corner (m,).
        """
        found, own, far = np.full(len(places), np.inf), list(self.corners[1:-1]), self.corners[-1]
        inner = INNER_DEVIATION / CORNER_SHARE / np.maximum(bends[own], ROUNDING)
        found[own] = np.minimum(np.array(self.distances[1:-1]) / 2, inner)
        found[far] = (1.0 - STRAIGHT_SHARE) * self.distances[-1]
        return found

    @property
    def rest(self) -> Array:
        """Where the motion rests (n,)."""
        return np.array(self.part.stretch.path[-1 if self.backward else 0, self.part.columns])

    @property
    def backward(self) -> bool:
        """Whether the motion rests at the end of the part, not at its beginning."""
        return self.corners[0] > self.corners[-1]

    def kept(self, q: Array) -> bool:
        """Whether configurations (k, n) of the robot, from the rest on, keep the line of the tool."""
        return self.line is None or self.line.kept(q)


def resting_stroke(
    part: MotionPart, corners: Sequence[int], distances: Array, *, backward: bool
) -> RestingStroke | None:
    """The stroke that a part is, seen from one of its ends; None of a part that is none."""
    if part.stretch.group != "arm":
        return None
    line = tool_line(part, backward=backward)
    if line is None and not part.touches:
        return None
    return RestingStroke(part, tuple(corners), tuple(distances.tolist()), line)
