"""Round shapes, exactly: what is added to a convex set of corners, so that a sphere is one point with a radius."""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array


class Rounding(NamedTuple):
    """A ball and a flat disc that are added to a hull of corners: hull(corners) + ball(radius) + disc(axis).

    A sphere is one corner with a radius, a capsule two; a cylinder is two corners, the centres of its ends, with a
    disc across its axis.
    """

    radius: float = 0.0  # of the ball [m]
    disc: float = 0.0  # radius of the disc [m]
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)  # unit, across the disc; in the frame of the corners

    def reach(self, directions: Array) -> Array:
        """How far it reaches in each of the unit directions (H, 3), in the same frame (H,) [m]."""
        if not self.disc:
            return np.full(len(directions), self.radius)
        return np.asarray(self.radius + self.disc * np.linalg.norm(np.cross(directions, self.axis), axis=1))

    def turned(self, rotation: Array) -> "Rounding":
        """This rounding in another frame: the axis is multiplied by a rotation (3, 3)."""
        x, y, z = (rotation @ self.axis).tolist()
        return Rounding(self.radius, self.disc, (x, y, z))
