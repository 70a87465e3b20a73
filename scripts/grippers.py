"""Parallel grippers of one design: a palm, and two fingers that slide apart along y.

The mount frame is the origin, z points to the finger tips. The joint value is the distance of each finger's inner
face from the middle: to hold a body of width w, close to w / 2.
"""

import math
from dataclasses import dataclass

from scripts.robot_files import LEFT, Joint, RobotModel
from scripts.solids import Detail, Solid, block, bolt_circle, cut, cylinder, union


@dataclass(frozen=True)
class Size:
    """Sizes of a gripper [m]."""

    name: str
    adapter: float  # radius of the mounting disc
    palm: tuple[float, float]  # half height (x) and half width (y)
    rail: float  # where the palm ends and the fingers begin (z)
    tip: float  # where the fingers end (z)
    finger: tuple[float, float]  # half height (x) and thickness (y)
    travel: float  # of each finger


WIDE = Size("gripper_wide", 0.04, (0.03, 0.078), 0.07, 0.145, (0.012, 0.012), 0.06)
SMALL = Size("gripper_small", 0.032, (0.022, 0.055), 0.055, 0.115, (0.009, 0.009), 0.04)
SLIM = Size(
    "gripper_slim", 0.032, (0.022, 0.04), 0.05, 0.14, (0.0045, 0.0065), 0.02
)  # for bores: holds by opening
BOLT = 0.0025


def gripper(size: Size, detail: Detail) -> RobotModel:
    """The gripper of a size, with link solids in their own frames."""
    finger = _finger(size, detail)
    origin, limits = (0.0, 0.0, size.rail), (0.0, size.travel)
    joints = [
        Joint("finger_joint", "palm", "left_finger", origin, LEFT, "prismatic", limits, 0.15),
        Joint(
            "finger_joint_2",
            "palm",
            "right_finger",
            origin,
            LEFT,
            "prismatic",
            limits,
            0.15,
            mimic="finger_joint",
            rpy=(0.0, 0.0, math.pi),
        ),
    ]
    return RobotModel(
        size.name, {"palm": _palm(size, detail), "left_finger": finger, "right_finger": finger}, joints
    )


def _palm(size: Size, d: Detail) -> Solid:
    """Mounting disc, body and the rail that guides the fingers."""
    height, width = size.palm
    disc = cylinder(size.adapter, (0.0, 0.014), 0.002, d)
    holes = bolt_circle(size.adapter - 0.008, 6, BOLT, (-0.01, 0.003), d)
    body = block((-height, height), (-width, width), (0.01, size.rail - 0.012), 0.008, d)
    rail = block((-height * 0.6, height * 0.6), (-width, width), (size.rail - 0.02, size.rail - 0.002), 0.003, d)
    return cut(union([disc, body, rail]), [holes])


def _finger(size: Size, d: Detail) -> Solid:
    """A finger whose inner face is the plane y = 0: a carriage on the rail and a blade with a chamfered tip."""
    height, thickness = size.finger
    length = size.tip - size.rail
    carriage = block((-height * 1.25, height * 1.25), (0.0, thickness * 1.3), (0.0, length * 0.3), 0.002, d)
    blade = block((-height, height), (0.0, thickness), (length * 0.1, length), 0.003, d)
    return union([carriage, blade])
