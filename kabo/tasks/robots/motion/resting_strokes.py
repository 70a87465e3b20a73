"""Strokes next to where a motion rests: approaches, lifts, lowerings and retreats.

There bodies touch, or nearly do. So the motion leaves exactly along the first straight piece of its path, and is near its
path the more closely the nearer it is to the rest. Farther away corners are rounded, while the tool keeps its line.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array, Booleans
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

    def greatest_trims(self, bends: Array) -> Iterator[tuple[int, float]]:
        """The corners of the stroke at which the motion may be rounded, each with the greatest trim [rad, L2].

        `bends` (m,): the norm of the turn at each corner of the route.
        """
        whole = self.distances[-1]
        for number, distance in zip(self.corners[1:-1], self.distances[1:-1], strict=True):
            yield number, min(distance / 2, INNER_DEVIATION / CORNER_SHARE / max(bends[number], ROUNDING))
        if 0 < self.corners[-1] < len(bends) - 1:
            yield self.corners[-1], (1.0 - STRAIGHT_SHARE) * whole

    def steady(self, starts: Array, ends: Array, away: Array, *, curved: bool = False) -> Booleans:
        """Whether the motion is near enough (N,) to pieces of the stroke's path from `starts` to `ends` (N, n).

        `away` (N,): how far it is from each of them [rad or m].
        """
        rest = np.array(self.part.stretch.path[-1 if self.backward else 0, self.part.columns])
        nearest = np.minimum(np.linalg.norm(starts - rest, axis=1), np.linalg.norm(ends - rest, axis=1))
        return np.asarray(away <= CLOSENESS * nearest + (CURVED if curved else ROUNDING))

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
