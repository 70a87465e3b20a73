"""What a model of physics needs beyond a scene, with defaults for what nobody has written down."""

from dataclasses import dataclass, fields

from kabo.given import require_flag, require_number


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
            ArgumentError: one is not a positive finite number.
        """
        for each in fields(self):
            value = getattr(self, each.name)
            if each.name == "welds":
                require_flag(each.name, value)
            elif value is not None or each.default is not None:
                require_number(each.name, value, above=0.0)


USUAL = PhysicsSettings()
