"""A hand in physics: its motors, and the force with which it presses."""

from dataclasses import dataclass, field

import numpy as np

from kabo.arrays import Array, Integers
from kabo.simulation.kernels.motors import Pressing
from kabo.simulation.turning_fingers import TurningFingers

AS_OPEN = 1e-6  # [m or rad]
HOLDS = 100.0  # how much stiffer joints hold that do not press while others do
BUILDS_UP = 0.1  # [s] until a hand presses with its whole force


@dataclass
class Hand:
    """A gripper's motors and how each presses; `pressing` is None while it follows setpoints."""

    motors: list[int]
    levers: Array  # force or torque of each motor per newton of force on what is held, positive to close
    carrier: int  # the body of the model that carries the tool
    dampings: Array  # of each motor [N s/m or Nm s]
    joints: Integers  # those of the motors, and of what is coupled to them
    motor_of: Integers  # the place in `motors` of what moves each joint
    spread: Array  # the share of its motor's torque that each joint gets
    opened: Array  # the value of each motor when the hand is open
    rates: Integers  # the places of the motors among the velocities of the model
    joint_rates: Integers  # and of the joints
    armatures: Array  # of `joints`, while the hand does not press [kg m², or kg for a joint that slides]
    acting: Pressing = field(init=False)  # the joints that press; others hold their setpoints
    turning: TurningFingers | None = None
    bodies: tuple[int, ...] = ()  # of the model, that it holds
    pressing: float | None = None
    held: list[tuple[Array, float]] = field(
        default_factory=list
    )  # what it took: places (3,) in the carrier's frame [m], with the mass that should be there
    since: float = 0.0  # when it began to press [s]

    def __post_init__(self) -> None:
        self.act(self.opened)

    def act(self, setpoints: Array) -> None:
        """Chooses the joints that press from now on: those that a grasp has moved from where they are open, or all.

        A grasp of a hand with many joints names some of them. The others are where they were: pressed, too, they would
        close the hand in another way than the plan has looked at.
        """
        moved = np.abs(setpoints - self.opened) > AS_OPEN
        some = np.flatnonzero(moved[self.motor_of] | (not moved.any()))
        self.acting = Pressing(self.joints[some], self.joint_rates[some], self.motor_of[some], self.spread[some])

    def locked(self, least: float) -> Array:
        """The armatures of `joints` while it presses: what the others press does not drive the gears of fingers back.

        Joints follow setpoints the more stiffly the greater their armature is; those of light fingers would give way.
        `least` is the least of a joint that does not press [kg m², or kg].
        """
        found, held = self.armatures.copy(), ~np.isin(self.joints, self.acting.joint)
        found[held] = np.maximum(HOLDS * found[held], least)
        return found

    def force(self, time: float) -> float:
        """The force with which it presses at a time [N].

        It builds up, as that of grippers does, so that fingers come to lie flat on what they hold: under a force that is
        there at once a body that is held off its middle turns by a degree, and stays so.
        """
        full = float(self.pressing or 0.0)
        return full * (time - self.since) / BUILDS_UP if self.builds_up(time) else full

    def builds_up(self, time: float) -> bool:
        """Whether it presses with less than its whole force; a hand that is forced open does so at once."""
        return self.pressing is not None and self.pressing > 0.0 and time < self.since + BUILDS_UP


def spread_of(motors: list[int], leader: Integers, ratio: Array) -> tuple[Integers, Integers, Array]:
    """The joints (k,) that motors move, the place of the motor of each in the list, and its share of the torque.

    `leader` (K,) is the motor of each driven joint, and `ratio` (K,) how far the joint moves when its motor moves by one.
    """
    joints = np.flatnonzero(np.isin(leader, motors))
    which = np.array([motors.index(k) for k in leader[joints]], np.int64)
    squares = np.bincount(which, ratio[joints] ** 2, len(motors))
    return joints, which, ratio[joints] / squares[which]
