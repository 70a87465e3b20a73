"""What motors give their joints: accelerations that are wanted, and torques."""

from typing import NamedTuple

from kabo.arrays import Array, Integers
from kabo.compilation import kernel


class Joints(NamedTuple):
    """Joints (K,) that motors drive, followers behind: joint k takes `ratio[k]` times its motor's value, and a shift."""

    value: Integers  # index into the positions of the model
    rate: Integers  # index into its velocities
    leader: Integers  # the motor
    ratio: Array
    shift: Array


class Setpoints(NamedTuple):
    """Of motors (M,): values, velocities, accelerations."""

    position: Array
    speed: Array
    change: Array


@kernel  # Joints, Setpoints, (Q,) f8, (V,) f8, f8 [1/s] -> writes wanted (V,)
def wanted_accelerations(joints, setpoints, positions, velocities, stiffness, wanted):
    """Those of the setpoints, and a correction of what joints are off: a spring and damper, critically damped."""
    for k in range(joints.leader.shape[0]):
        m, ratio = joints.leader[k], joints.ratio[k]
        off = ratio * setpoints.position[m] + joints.shift[k] - positions[joints.value[k]]
        late = ratio * setpoints.speed[m] - velocities[joints.rate[k]]
        wanted[joints.rate[k]] = ratio * setpoints.change[m] + 2.0 * stiffness * late + stiffness * stiffness * off


@kernel  # Joints, (V,) f8 x 3 -> writes torques of motors (M,) x 2
def motor_torques(joints, needed, bias, passive, total, standing):
    """The torques of motors for those that are needed at all joints, and those that only keep joints where they are."""
    total[:], standing[:] = 0.0, 0.0
    for k in range(joints.leader.shape[0]):
        i = joints.rate[k]
        total[joints.leader[k]] += joints.ratio[k] * needed[i]
        standing[joints.leader[k]] += joints.ratio[k] * (bias[i] - passive[i])
