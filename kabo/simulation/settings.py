"""What a model of physics needs beyond a scene, with defaults for what nobody has written down."""

from dataclasses import dataclass, fields
from typing import Final

from kabo.given import require_flag, require_number

# The least and the greatest value of each number, far beyond what hands and things are like: physics counts with all.
_SPANS: Final = {
    "timestep": (1e-6, 0.1, "s"),
    "friction": (1e-6, 1e3, ""),
    "body_density": (1e-3, 1e6, "kg/m³"),
    "link_density": (1e-3, 1e6, "kg/m³"),
    "rotor_inertia": (1e-12, 1e4, ""),
    "grip_force": (1e-6, 1e6, "N"),
    "contact_precision": (1e-6, 1.0, "m"),
}


@dataclass(frozen=True)
class PhysicsSettings:
    """How a scene becomes a model of physics [SI].

    Attributes:
        timestep: of the simulation [s].
        friction: the coefficient between bodies, and between bodies and links that are no fingers.
        body_density: of bodies without a mass [kg/m³].
        link_density: of links without an inertia in their URDF [kg/m³]: hollow, with motors.
        rotor_inertia: what a geared motor adds to its joint [kg m², or kg for a joint that slides].
        grip_force: of grippers whose scene gives no force [N], the sum of the normal forces: planning takes it that nothing
            slips from these.
        contact_precision: how far convex parts of meshes may bridge hollows in contacts [m]; None: as the parts that
            are stored for planning, drawn tight.
        welds: whether what is gripped is fixed to the hand, as by a gripper that locks, in place of friction.
    """

    timestep: float = 0.001
    friction: float = 0.8
    body_density: float = 1000.0
    link_density: float = 600.0
    rotor_inertia: float = 0.05
    grip_force: float = 100.0
    contact_precision: float | None = None
    welds: bool = False

    def __post_init__(self) -> None:
        """Checks the numbers.

        Raises:
            ArgumentError: one is no number within its span.
        """
        for each in fields(self):
            value = getattr(self, each.name)
            if each.name == "welds":
                require_flag(each.name, value)
            elif value is not None or each.default is not None:
                least, most, unit = _SPANS[each.name]
                require_number(each.name, value, least, most, unit=unit)


USUAL = PhysicsSettings()
