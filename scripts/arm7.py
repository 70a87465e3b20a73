"""A 7-axis arm with the kinematics, limits and speeds of a KUKA LBR iiwa 7: 0.36, 0.42, 0.40 and 0.126 m.

At zero the arm stands straight up. Turning and bending joints alternate; at each bend the lower link carries a
cheek on one side and the upper one a cheek on the other, which gives the arm its zigzag.
"""

import math

from scripts.robot_files import LEFT, RIGHT, UP, Joint, RobotModel
from scripts.solids import Detail, Solid, bolt_circle, bore, cut, cylinder, hub, revolved, union, upright_slab

BOLT = 0.003  # radius of the screw holes
GAP = 0.002  # between the cheeks of a bend
# Height of each joint above the one before; limits in degrees, speeds in degrees per second.
HEIGHTS = (0.1475, 0.2125, 0.2045, 0.2155, 0.1845, 0.2155, 0.081)
AXES = (UP, LEFT, UP, RIGHT, UP, LEFT, UP)
LIMITS = (170.0, 120.0, 170.0, 120.0, 170.0, 120.0, 175.0)
SPEEDS = (98.0, 98.0, 100.0, 130.0, 140.0, 180.0, 180.0)
FLANGE = 0.045


def arm7(detail: Detail) -> RobotModel:
    """The arm, with link solids in their own frames."""
    links: dict[str, Solid | None] = {
        "base_link": _base(detail),
        "link_1": _below_bend(0.0, HEIGHTS[1], 0.064, 0.066, -1.0, detail),
        "link_2": _above_bend(HEIGHTS[2], 0.064, 0.066, 1.0, detail),
        "link_3": _below_bend(0.002, HEIGHTS[3], 0.06, 0.062, -1.0, detail),
        "link_4": _above_bend(HEIGHTS[4], 0.058, 0.062, 1.0, detail),
        "link_5": _below_bend(0.002, HEIGHTS[5], 0.054, 0.05, -1.0, detail),
        "link_6": _wrist(detail),
        "link_7": _flange(detail),
        "tool0": None,
    }
    return RobotModel("arm7", links, _joints())


def _joints() -> list[Joint]:
    joints = []
    for number, (height, axis, limit, speed) in enumerate(
        zip(HEIGHTS, AXES, LIMITS, SPEEDS, strict=True), start=1
    ):
        parent = "base_link" if number == 1 else f"link_{number - 1}"
        bounds = (-math.radians(limit), math.radians(limit))
        joints.append(
            Joint(
                f"joint_{number}",
                parent,
                f"link_{number}",
                (0.0, 0.0, height),
                axis,
                "revolute",
                bounds,
                math.radians(speed),
            )
        )
    return [*joints, Joint("flange", "link_7", "tool0", (0.0, 0.0, FLANGE), kind="fixed")]


def _base(d: Detail) -> Solid:
    """Mounting flange with its bores, and a waisted column."""
    foot = cut(cylinder(0.1, (0.0, 0.018), 0.003, d), [bolt_circle(0.09, 8, BOLT, (-0.01, 0.03), d)])
    column = revolved(
        [
            (0.04, 0.01, 0.0),
            (0.078, 0.01, 0.0),
            (0.074, 0.07, 0.03),
            (0.068, 0.11, 0.02),
            (0.068, 0.145, 0.004),
            (0.04, 0.145, 0.0),
        ],
        d,
    )
    return union([foot, column])


def _cheek(ends: list[tuple[float, float, float]], side: float, width: float, d: Detail) -> Solid:
    """Half of a bend: a slab on one side of the x-z plane."""
    span = (GAP / 2.0, width) if side > 0.0 else (-width, -GAP / 2.0)
    return upright_slab(ends, span, 0.012, d)


def _cap(z: float, radius: float, side: float, width: float, d: Detail) -> Solid:
    """A screwed cover on the outer face of a cheek."""
    low, high = width - 0.01, width + 0.005
    cover = cylinder(radius, (low, high), 0.003, d)
    cover = cut(cover, [bolt_circle(radius - 0.009, 6, BOLT, (high - 0.004, high + 0.01), d)])
    return cover.rotate((-90.0 if side > 0.0 else 90.0, 0.0, 0.0)).translate((0.0, 0.0, z))


def _pin(radius: float, d: Detail) -> Solid:
    """The bearing that joins the two cheeks of a bend."""
    return hub((0.0, 0.0), radius, (-0.004, 0.01), 0.001, d)


def _below_bend(start: float, bend: float, tube: float, head: float, side: float, d: Detail) -> Solid:
    """A link that turns around its own length and carries the next bend on one side."""
    shoulder = bend - head - 0.016
    column = cylinder(tube, (start, shoulder), 0.005, d)
    cheek = _cheek([(0.0, bend, head), (0.0, shoulder - 0.03, tube - 0.008)], side, head, d)
    return union([column, cheek, _cap(bend, head * 0.7, side, head, d)])


def _above_bend(length: float, tube: float, head: float, side: float, d: Detail) -> Solid:
    """A link that bends: a cheek on the hub below, then the column for the next turning axis."""
    column = cylinder(tube, (head + 0.016, length), 0.005, d)
    cheek = _cheek([(0.0, 0.0, head), (0.0, head + 0.046, tube - 0.008)], side, head, d)
    return union([column, cheek, _pin(head * 0.6, d), _cap(0.0, head * 0.7, side, head, d)])


def _wrist(d: Detail) -> Solid:
    """The last bend, short, ending in the bearing of axis 7."""
    cheek = _cheek([(0.0, 0.0, 0.05), (0.0, 0.012, 0.046)], 1.0, 0.05, d)
    body = cylinder(0.044, (0.034, 0.087), 0.006, d, top_radius=0.04)
    bridge = upright_slab([(0.0, 0.012, 0.042), (0.0, 0.03, 0.038)], (0.004, 0.046), 0.008, d)
    return union([cheek, body, bridge, _pin(0.03, d), _cap(0.0, 0.034, 1.0, 0.05, d)])


def _flange(d: Detail) -> Solid:
    """The media flange: seven threaded holes and a shallow centring recess."""
    disc = revolved(
        [
            (0.015, 0.01, 0.0),
            (0.036, 0.01, 0.002),
            (0.036, 0.02, 0.002),
            (0.041, 0.023, 0.001),
            (0.041, FLANGE, 0.002),
            (0.015, FLANGE, 0.0),
        ],
        d,
    )
    holes = bolt_circle(0.025, 7, BOLT, (FLANGE - 0.012, FLANGE + 0.01), d)
    return cut(disc, [holes, bore(0.0157, (FLANGE - 0.003, FLANGE + 0.01), d)])
