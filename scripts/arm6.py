"""A 6-axis industrial arm with a spherical wrist: kinematics, limits and speeds of a Stäubli TX90.

Shoulder 0.478 m above the mounting face and 0.05 m in front of axis 1, upper arm 0.425 m, forearm 0.425 m and
0.05 m to the side, flange 0.1 m beyond the wrist centre. At zero the arm stands straight up. The upper arm runs
beside shoulder and forearm, so that the elbow folds freely.
"""

import math

from scripts.robot_files import LEFT, UP, Joint, RobotModel
from scripts.solids import (
    Detail,
    Solid,
    block,
    bolt_circle,
    bore,
    cut,
    cylinder,
    hub,
    revolved,
    union,
    upright_slab,
)

SHOULDER_HEIGHT, SHOULDER_OFFSET, UPPER_ARM, FOREARM, SIDE, FLANGE = 0.478, 0.05, 0.425, 0.425, 0.05, 0.1
BOLT = 0.003  # radius of the screw holes


def arm6(detail: Detail) -> RobotModel:
    """The arm, with link solids in their own frames."""
    makers = {
        "base_link": _base,
        "link_1": _shoulder,
        "link_2": _upper_arm,
        "link_3": _elbow,
        "link_4": _forearm,
        "link_5": _wrist,
        "link_6": _flange,
    }
    links: dict[str, Solid | None] = {name: make(detail) for name, make in makers.items()}
    return RobotModel("arm6", {**links, "tool0": None}, _joints())


def _joints() -> list[Joint]:
    def turning(
        number: int,
        origin: tuple[float, float, float],
        axis: tuple[float, float, float],
        lower: float,
        upper: float,
        speed: float,
    ) -> Joint:
        parent = "base_link" if number == 1 else f"link_{number - 1}"
        limits = (math.radians(lower), math.radians(upper))
        return Joint(
            f"joint_{number}", parent, f"link_{number}", origin, axis, "revolute", limits, math.radians(speed)
        )

    return [
        turning(1, (0.0, 0.0, SHOULDER_HEIGHT), UP, -180.0, 180.0, 400.0),
        turning(2, (SHOULDER_OFFSET, 0.0, 0.0), LEFT, -130.0, 147.5, 400.0),
        turning(3, (0.0, SIDE, UPPER_ARM), LEFT, -145.0, 145.0, 430.0),
        turning(4, (0.0, 0.0, 0.0), UP, -270.0, 270.0, 540.0),
        turning(5, (0.0, 0.0, FOREARM), LEFT, -115.0, 140.0, 475.0),
        turning(6, (0.0, 0.0, 0.0), UP, -270.0, 270.0, 760.0),
        Joint("flange", "link_6", "tool0", (0.0, 0.0, FLANGE), kind="fixed"),
    ]


def _base(d: Detail) -> Solid:
    """Mounting flange, column, and the connector box behind."""
    foot = cut(cylinder(0.105, (0.0, 0.02), 0.003, d), [bolt_circle(0.095, 8, BOLT, (-0.01, 0.03), d)])
    column = revolved(
        [
            (0.04, 0.01, 0.0),
            (0.082, 0.01, 0.0),
            (0.082, 0.20, 0.03),
            (0.074, 0.24, 0.01),
            (0.074, 0.264, 0.004),
            (0.04, 0.264, 0.0),
        ],
        d,
    )
    box = block((-0.125, -0.04), (-0.048, 0.048), (0.045, 0.165), 0.01, d)
    sockets = [
        bore(0.014, (-0.003, 0.02), d).rotate((0.0, -90.0, 0.0)).translate((-0.125, y, z))
        for y in (-0.02, 0.02)
        for z in (0.085, 0.13)
    ]
    return union([foot, column, cut(box, sockets)])


def _shoulder(d: Detail) -> Solid:
    """Turret on axis 1, hub of axis 2, and the cover of its motor."""
    turret = cylinder(0.076, (-0.206, -0.03), 0.006, d)
    body = upright_slab([(SHOULDER_OFFSET, 0.0, 0.084), (0.0, -0.09, 0.07)], (-0.07, 0.07), 0.012, d)
    bearing = hub((SHOULDER_OFFSET, 0.0), 0.0765, (0.04, 0.132), 0.002, d)
    motor = hub((SHOULDER_OFFSET, 0.0), 0.055, (-0.112, -0.05), 0.01, d)
    screws = (
        bolt_circle(0.045, 6, BOLT, (-0.003, 0.02), d)
        .rotate((-90.0, 0.0, 0.0))
        .translate((SHOULDER_OFFSET, -0.112, 0.0))
    )
    return cut(union([turret, body, bearing, motor]), [screws])


def _upper_arm(d: Detail) -> Solid:
    """A tapered shell beside the shoulder, with a cover on each joint."""
    shell = upright_slab([(0.0, 0.0, 0.084), (0.0, UPPER_ARM, 0.07)], (0.13, 0.192), 0.016, d)
    covers = [hub((0.0, z), r, (0.18, 0.2), 0.004, d) for z, r in ((0.0, 0.06), (UPPER_ARM, 0.048))]
    screws = [
        bolt_circle(r, 6, BOLT, (-0.02, 0.003), d).rotate((-90.0, 0.0, 0.0)).translate((0.0, 0.2, z))
        for z, r in ((0.0, 0.05), (UPPER_ARM, 0.039))
    ]
    return cut(union([shell, *covers]), screws)


def _elbow(d: Detail) -> Solid:
    """Hub of axis 3 and the housing of axis 4."""
    bearing = hub((0.0, 0.0), 0.062, (-0.03, 0.082), 0.004, d)
    body = upright_slab([(0.0, 0.0, 0.058), (0.0, 0.10, 0.048)], (-0.05, 0.03), 0.014, d)
    housing = cylinder(0.05, (0.05, 0.165), 0.006, d)
    cap = hub((0.0, 0.0), 0.0435, (-0.062, -0.03), 0.006, d)
    screws = bolt_circle(0.035, 6, BOLT, (-0.003, 0.01), d).rotate((-90.0, 0.0, 0.0)).translate((0.0, -0.062, 0.0))
    return cut(union([bearing, body, housing, cap]), [screws])


def _forearm(d: Detail) -> Solid:
    """A tapered tube from the housing of axis 4 to the fork of axis 5."""
    tube = revolved(
        [
            (0.025, 0.168, 0.0),
            (0.049, 0.168, 0.003),
            (0.049, 0.19, 0.02),
            (0.044, 0.27, 0.06),
            (0.042, 0.355, 0.008),
            (0.02, 0.355, 0.0),
        ],
        d,
    )
    neck = block((-0.034, 0.034), (-0.047, 0.047), (0.33, 0.372), 0.008, d)
    cheeks = [
        upright_slab([(0.0, FOREARM, 0.035), (0.0, 0.365, 0.033)], span, 0.005, d)
        for span in ((-0.049, -0.029), (0.029, 0.049))
    ]
    pins = [hub((0.0, FOREARM), 0.022, span, 0.002, d) for span in ((-0.052, -0.04), (0.04, 0.052))]
    return union([tube, neck, *cheeks, *pins])


def _wrist(d: Detail) -> Solid:
    """The body between the cheeks of the fork, and the nose that carries axis 6."""
    body = hub((0.0, 0.0), 0.034, (-0.027, 0.027), 0.005, d)
    nose = cylinder(0.026, (0.0, 0.055), 0.002, d)
    bell = cylinder(0.032, (0.044, 0.076), 0.004, d)
    return union([body, nose, bell])


def _flange(d: Detail) -> Solid:
    """The tool flange: seven threaded holes and a shallow centring recess, as ISO 9409-1 has them."""
    disc = revolved(
        [
            (0.015, 0.078, 0.0),
            (0.034, 0.078, 0.002),
            (0.034, 0.086, 0.001),
            (0.04, 0.088, 0.001),
            (0.04, FLANGE, 0.002),
            (0.015, FLANGE, 0.0),
        ],
        d,
    )
    holes = bolt_circle(0.025, 7, BOLT, (FLANGE - 0.012, FLANGE + 0.01), d)
    recess = bore(0.0157, (FLANGE - 0.003, FLANGE + 0.01), d)
    return cut(disc, [holes, recess])
