"""What a hand holds limits how fast a robot may stop: friction holds it up to an acceleration, and no more.

The place of the body on the path is known, so its acceleration under any clock follows from two derivatives of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.motion import Held
from kabo.scene import Scene, link_pose

STEP = 0.002  # [s] between places on the path
ROUNDING = 1e-3  # share by which differences of places may be off


def load_of(scene: Scene, robot: str, values: Sequence[float], offset: Array, mass: float | None) -> Held | None:
    """What limits a robot that holds a body; None if nothing does.

    Args:
        scene: the scene.
        robot: whose tool holds it.
        values: of all its joints; those of the hand stay.
        offset: the body's place (3,) in the frame of the tool [m].
        mass: of the body [kg].
    """
    own = scene.robots[robot]
    if own.gripper is None or own.tool is None:
        return None
    greatest, frame = own.gripper.greatest_acceleration(mass), own.tool.frame
    if greatest is None:
        return None
    hand = tuple(values[own.planned :])

    def places(rows: Array) -> Array:
        poses = (link_pose(own, (*row.tolist(), *hand), frame) for row in rows)
        return np.array([pose[:3, :3] @ offset + pose[:3, 3] for pose in poses])

    return Held(places, greatest)


@dataclass(frozen=True)
class LoadOnPath:
    """A body along a stretch of a path: times of the motion's clock (k,) [s], and two derivatives (k, 3) of its place."""

    held: Held
    times: Array
    first: Array
    second: Array

    @classmethod
    def along(cls, held: Held, times: Array, rows: Array) -> "LoadOnPath":
        """From configurations (k, n) of the planned joints at evenly spaced times (k >= 3,)."""
        places, step = held.places(rows), float(times[1] - times[0])
        first = np.gradient(places, step, axis=0, edge_order=2)
        second = np.empty_like(places)
        second[1:-1] = (places[2:] - 2.0 * places[1:-1] + places[:-2]) / step**2
        second[0], second[-1] = second[1], second[-2]
        return cls(held, times, first, second)

    def held_under(self, times: Array, rate: Array, change: Array) -> bool:
        """Whether it is held where the clock is at `times` (m,) with some rates (m,) that change (m,) [1/s]."""
        first = np.stack([np.interp(times, self.times, column) for column in self.first.T], axis=1)
        second = np.stack([np.interp(times, self.times, column) for column in self.second.T], axis=1)
        acceleration = second * (rate**2)[:, None] + first * change[:, None] - np.asarray(self.held.gravity)
        return bool((np.linalg.norm(acceleration, axis=1) <= self.held.acceleration * (1.0 + ROUNDING)).all())
