"""The numbers on which a refusal rests: what a constraint or a limit requires, and what was found."""

from dataclasses import dataclass
from typing import Literal

CLEARANCE = "clearance"  # the name of the measure of a distance that is to be kept


@dataclass(frozen=True)
class Measure:
    """A value that a refused attempt requires, and the value that was found.

    Whoever refuses an attempt because of a number hands one of these to `Refusal.measures`; of many attempts the one
    that came nearest is told.

    Args:
        name: the constraint or limit as its file names it: `inside(cup, shelf)`, `arm.joint_4`.
        said: the clause for users, with both values and the difference.
        required, found: the values [m or rad].
        unit: their unit.
        proven: no sample can do better.
        epsilon: epsilon alone decides: with exact geometry the attempt passes.
    """

    name: str
    said: str
    required: float
    found: float
    unit: Literal["m", "rad"] = "m"
    proven: bool = False
    epsilon: bool = False

    @property
    def missing(self) -> float:
        """How far the value found is from the one required [m or rad]."""
        return abs(self.found - self.required)

    @property
    def decides_alone(self) -> bool:
        """Whether the attempt passes if only epsilon were finer, or less distance were kept."""
        return self.epsilon or self.name == CLEARANCE

    @property
    def text(self) -> str:
        """The clause, with what is known about its certainty."""
        return (
            self.said + (", proven" if self.proven else "") + (", only because of epsilon" if self.epsilon else "")
        )


def millimetres(metres: float) -> str:
    """A length as users read it: to a tenth of a millimetre, without trailing zeros."""
    return f"{round(1000.0 * metres, 1) + 0.0:g} mm"


def excess(metres: float) -> str:
    """A length by which something is missed, as users read it: one that is told as zero is `less than 0.1 mm`."""
    told = millimetres(metres)
    return "less than 0.1 mm" if told == millimetres(0.0) else told


def degrees(radians: float) -> str:
    """An angle as users read it: to a tenth of a degree, without trailing zeros."""
    return f"{round(radians * 57.29577951308232, 1) + 0.0:g} deg"


def value(number: float, unit: str) -> str:
    """A length or an angle as users read it."""
    return millimetres(number) if unit == "m" else degrees(number)
