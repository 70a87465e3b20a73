"""The kinematic tree as flat arrays, shared by forward kinematics, projection and collision kernels."""

from typing import NamedTuple

from kabo.arrays import Array, Integers

REVOLUTE, PRISMATIC = 0, 1


class KinematicTree(NamedTuple):
    """All joints of one or several robots, parents before children; joint 0 is the world, and never moves.

    Every joint axis is the local z of its frame. Joint j takes `ratio[j] * q[source[j]] + shift[j]` (mimic joints
    share a source). `placement[j]` is parent_T_joint at zero: rotation row-major, then translation.
    """

    parent: Integers  # (J,)
    kind: Integers  # (J,) REVOLUTE or PRISMATIC
    source: Integers  # (J,) index into q; joint 0: 0
    ratio: Array  # (J,) 1 except for mimic joints; joint 0: 0
    shift: Array  # (J,)
    placement: Array  # (J, 12)
    lower: Array  # (n,) limits of q [rad or m]
    upper: Array  # (n,)
    velocity: Array  # (n,) [rad/s or m/s]

    @property
    def size(self) -> int:
        """The number n of values in a configuration."""
        return len(self.lower)
