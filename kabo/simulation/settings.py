"""What a model of physics needs beyond a scene, with defaults for what nobody has written down."""

from dataclasses import dataclass

from kabo.errors import Diagnostic, InputError


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
            InputError: one is not a positive finite number.
        """
        numbers = {
            "timestep": self.timestep,
            "friction": self.friction,
            "body_density": self.body_density,
            "link_density": self.link_density,
            "rotor_inertia": self.rotor_inertia,
            "grip_force": self.grip_force,
            "contact_precision": 1.0 if self.contact_precision is None else self.contact_precision,
        }
        for name, value in numbers.items():
            if not 0.0 < value < float("inf"):
                text = f"{name} is {value:g}, which is not a positive number"
                raise InputError([Diagnostic("simulation", 1, 1, text, "see kabo.simulation.PhysicsSettings")])


USUAL = PhysicsSettings()
