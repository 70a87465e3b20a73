"""What motors give their joints: accelerations that are wanted, and torques."""

from typing import NamedTuple

from kabo.arrays import Array, Integers
from kabo.compilation import kernel

COMES_BACK = 1.0  # [rad/s or m/s], of a joint that is far from its setpoint


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


class Pressing(NamedTuple):
    """The joints (A,) of a hand that press: places among driven joints, places among velocities, motors, shares.

    `motor` is the place among the hand's motors, of whose torque a joint gets its `share`.
    """

    joint: Integers
    rate: Integers
    motor: Integers
    share: Array


@kernel  # Joints, Setpoints, (Q,) f8, (V,) f8, f8 [1/s] -> writes wanted (V,)
def wanted_accelerations(joints, setpoints, positions, velocities, stiffness, wanted):
    """Those of the setpoints, and a correction of what joints are off: a spring and damper, critically damped.

    Joints come back no faster than `COMES_BACK`: what is far off would ask for more than motors have, and swing for ever.
    """
    for k in range(joints.leader.shape[0]):
        m, ratio = joints.leader[k], joints.ratio[k]
        off = ratio * setpoints.position[m] + joints.shift[k] - positions[joints.value[k]]
        late = ratio * setpoints.speed[m] - velocities[joints.rate[k]]
        back = min(max(0.5 * stiffness * off, -COMES_BACK), COMES_BACK)
        wanted[joints.rate[k]] = ratio * setpoints.change[m] + 2.0 * stiffness * (late + back)


@kernel  # Joints, (K,) f8, (M,) f8, (M,) f8 -> writes control (M,) f8, some of applied (V,) f8
def drive(joints, torques, limits, gains, control, applied):
    """Gives joints their torques, less where a motor with all that follow it is beyond its limit.

    What a motor's joint gets is its control; followers get theirs as forces that are applied. So what drives coupled joints
    reaches each by itself: a mechanism does not give way under the force of a hand, whereas the coupling of the simulation
    would, and one finger would press what it holds off the hand's middle.
    """
    motors = limits.shape[0]
    control[:] = 0.0
    for k in range(joints.leader.shape[0]):
        control[joints.leader[k]] += joints.ratio[k] * torques[k]
    for k in range(joints.leader.shape[0] - 1, -1, -1):
        m = joints.leader[k]
        share = limits[m] / abs(control[m]) if abs(control[m]) > limits[m] else 1.0
        if k >= motors:
            applied[joints.rate[k]] = share * torques[k] * gains[m]
        else:
            control[k] = share * torques[k]


@kernel  # Pressing, (M,) f8, f8 [N], (M,) f8, (M,) i8, (V,) f8, (V,) f8, (V,) f8 -> writes some of torques (K,) f8
def press(pressing, levers, force, dampings, rates, velocities, bias, passive, torques):
    """Gives joints that press what the force of their hand asks for, damped, whatever their setpoints are.

    `levers` are the torques of the hand's motors per newton, `dampings` theirs, `rates` their places among velocities.
    """
    for a in range(pressing.joint.shape[0]):
        m, rate = pressing.motor[a], pressing.rate[a]
        pressed = levers[m] * force - dampings[m] * velocities[rates[m]]
        torques[pressing.joint[a]] = bias[rate] - passive[rate] + pressed * pressing.share[a]
