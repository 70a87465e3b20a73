"""A 5-axis arm on a four-wheeled platform that drives in x, y and yaw, with a parallel gripper of its own.

Made like a KUKA youBot (platform, turret, three parallel bends, a roll), with longer links: shoulder 0.36 m high
and 0.03 m in front of axis 1, upper arm 0.26 m, forearm 0.24 m, and 0.19 m from the last bend to the tool centre.
At zero the arm stands straight up.
"""

import math

from scripts.robot_files import FORWARD, LEFT, UP, Joint, RobotModel
from scripts.solids import Detail, Solid, block, bolt_circle, cut, cylinder, hub, union, upright_slab

MOUNT = 0.12  # axis 1 in front of the middle of the platform
DECK, TURRET, SHOULDER_OFFSET, SHOULDER_HEIGHT = 0.16, 0.24, 0.03, 0.12
UPPER_ARM, FOREARM, ROLL, HAND = 0.26, 0.24, 0.07, 0.02
FINGER_TRAVEL = 0.045
BOLT = 0.0025


def mobile5(detail: Detail) -> RobotModel:
    """The robot, with link solids in their own frames."""
    finger = _finger(detail)
    links: dict[str, Solid | None] = {
        "world_link": None,
        "slide_x": None,
        "slide_y": None,
        "base_link": _platform(detail),
        "arm_link_1": _turret(detail),
        "arm_link_2": _upper_arm(detail),
        "arm_link_3": _forearm(detail),
        "arm_link_4": _wrist(detail),
        "arm_link_5": _roll(detail),
        "gripper_base": _palm(detail),
        "left_finger": finger,
        "right_finger": finger,
    }
    return RobotModel("mobile5", links, [*_base_joints(), *_arm_joints(), *_gripper_joints()])


def _base_joints() -> list[Joint]:
    origin = (0.0, 0.0, 0.0)
    return [
        Joint("base_x", "world_link", "slide_x", origin, FORWARD, "prismatic", (-5.0, 5.0), 0.8),
        Joint("base_y", "slide_x", "slide_y", origin, LEFT, "prismatic", (-5.0, 5.0), 0.8),
        Joint("base_yaw", "slide_y", "base_link", origin, UP, "revolute", (-math.pi, math.pi), 1.5),
    ]


def _arm_joints() -> list[Joint]:
    places = [
        ("base_link", (MOUNT, 0.0, TURRET), UP, 169.0),
        ("arm_link_1", (SHOULDER_OFFSET, 0.0, SHOULDER_HEIGHT), LEFT, 90.0),
        ("arm_link_2", (0.0, 0.0, UPPER_ARM), LEFT, 150.0),
        ("arm_link_3", (0.0, 0.0, FOREARM), LEFT, 110.0),
        ("arm_link_4", (0.0, 0.0, ROLL), UP, 169.0),
    ]
    return [
        Joint(
            f"arm_joint_{k}",
            parent,
            f"arm_link_{k}",
            origin,
            axis,
            "revolute",
            (-math.radians(limit), math.radians(limit)),
            math.radians(90.0),
        )
        for k, (parent, origin, axis, limit) in enumerate(places, start=1)
    ]


def _gripper_joints() -> list[Joint]:
    origin, limits = (0.0, 0.0, 0.05), (0.0, FINGER_TRAVEL)
    return [
        Joint("gripper_mount", "arm_link_5", "gripper_base", (0.0, 0.0, HAND), kind="fixed"),
        Joint("finger_joint", "gripper_base", "left_finger", origin, LEFT, "prismatic", limits, 0.1),
        Joint(
            "finger_joint_2",
            "gripper_base",
            "right_finger",
            origin,
            LEFT,
            "prismatic",
            limits,
            0.1,
            mimic="finger_joint",
            rpy=(0.0, 0.0, math.pi),
        ),
    ]


def _platform(d: Detail) -> Solid:
    """Deck, four wheels, the column of the arm."""
    deck = block((-0.22, 0.22), (-0.15, 0.15), (0.045, DECK), 0.02, d)
    column = cylinder(0.06, (DECK - 0.02, TURRET - 0.008), 0.006, d).translate((MOUNT, 0.0, 0.0))
    wheels = [
        hub((x, 0.05), 0.05, span, 0.006, d) for x in (-0.14, 0.14) for span in ((-0.19, -0.146), (0.146, 0.19))
    ]
    screws = bolt_circle(0.05, 6, BOLT, (DECK - 0.01, DECK + 0.003), d).translate((-0.10, 0.0, 0.0))
    return cut(union([deck, column, *wheels]), [screws])


def _turret(d: Detail) -> Solid:
    """The turning column and one cheek of the shoulder."""
    column = cylinder(0.056, (0.0, 0.055), 0.005, d)
    cheek = upright_slab([(SHOULDER_OFFSET, SHOULDER_HEIGHT, 0.046), (0.0, 0.04, 0.05)], (-0.05, -0.002), 0.01, d)
    motor = hub((SHOULDER_OFFSET, SHOULDER_HEIGHT), 0.034, (-0.068, -0.04), 0.006, d)
    return union([column, cheek, motor])


def _upper_arm(d: Detail) -> Solid:
    """A tapered shell on the other side of the shoulder."""
    shell = upright_slab([(0.0, 0.0, 0.046), (0.0, UPPER_ARM, 0.038)], (0.002, 0.044), 0.01, d)
    cover = hub((0.0, 0.0), 0.034, (0.035, 0.05), 0.003, d)
    screws = bolt_circle(0.026, 6, BOLT, (-0.01, 0.01), d).rotate((-90.0, 0.0, 0.0)).translate((0.0, 0.05, 0.0))
    pins = [hub((0.0, z), r, (-0.005, 0.01), 0.001, d) for z, r in ((0.0, 0.03), (UPPER_ARM, 0.024))]
    return cut(union([shell, cover, *pins]), [screws])


def _forearm(d: Detail) -> Solid:
    """A slimmer shell, back on the first side."""
    shell = upright_slab([(0.0, 0.0, 0.038), (0.0, FOREARM, 0.032)], (-0.04, -0.002), 0.009, d)
    covers = [hub((0.0, z), r, (-0.046, -0.03), 0.003, d) for z, r in ((0.0, 0.028), (FOREARM, 0.022))]
    return union([shell, *covers])


def _wrist(d: Detail) -> Solid:
    """Hub of the last bend and the housing of the roll axis."""
    cheek = upright_slab([(0.0, 0.0, 0.032), (0.0, 0.03, 0.028)], (0.002, 0.036), 0.008, d)
    housing = cylinder(0.03, (0.036, ROLL - 0.002), 0.004, d)
    neck = cylinder(0.024, (0.018, 0.051), 0.003, d)
    pin = hub((0.0, 0.0), 0.02, (-0.005, 0.01), 0.001, d)
    return union([cheek, housing, neck, pin])


def _roll(d: Detail) -> Solid:
    """The output disc of the roll axis."""
    return cut(cylinder(0.03, (0.0, HAND), 0.003, d), [bolt_circle(0.022, 6, BOLT, (HAND - 0.01, HAND + 0.01), d)])


def _palm(d: Detail) -> Solid:
    """The gripper's body, wide across the fingers, with its rails."""
    body = block((-0.02, 0.02), (-0.052, 0.052), (0.0, 0.042), 0.006, d)
    rail = block((-0.012, 0.012), (-0.056, 0.056), (0.036, 0.048), 0.003, d)
    return union([body, rail])


def _finger(d: Detail) -> Solid:
    """A finger whose inner face is the plane y = 0; 0.06 m long."""
    carriage = block((-0.012, 0.012), (0.0, 0.012), (0.0, 0.018), 0.002, d)
    blade = block((-0.01, 0.01), (0.0, 0.008), (0.01, 0.06), 0.002, d)
    return union([carriage, blade])
