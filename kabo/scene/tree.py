"""The kinematic tree as flat arrays: what forward kinematics, projection and the collision kernel share."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

REVOLUTE, PRISMATIC = 0, 1


class KinematicTree(NamedTuple):
    """All joints of one or several robots, parents before children; joint 0 is the world, and never moves.

    Every joint axis is the local z of its frame. Joint j takes `ratio[j] * q[source[j]] + shift[j]` (mimic joints
    share a source). `placement[j]` is parent_T_joint at zero: rotation row-major, then translation.
    """

    parent: NDArray[np.int64]  # (J,)
    kind: NDArray[np.int64]  # (J,) REVOLUTE or PRISMATIC
    source: NDArray[np.int64]  # (J,) index into q; joint 0: 0
    ratio: NDArray[np.float64]  # (J,) 1 except for mimic joints; joint 0: 0
    shift: NDArray[np.float64]  # (J,)
    placement: NDArray[np.float64]  # (J, 12)
    lower: NDArray[np.float64]  # (n,) limits of q [rad or m]
    upper: NDArray[np.float64]  # (n,)
    velocity: NDArray[np.float64]  # (n,) [rad/s or m/s]

    @property
    def size(self) -> int:
        """The number n of values in a configuration."""
        return len(self.lower)
