"""Sensor files and truth files as plain data: what answers which question of a plan, and what only a simulator knows.

Source: docs/how-to/carry_out.md.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import ceil, log
from typing import Literal

from kabo.language.formulas import Place

DEFAULT_ERROR = 1e-3  # probability that the answer of all looks together is wrong
DEFAULT_LOOKS = 100  # at most
DEFAULT_SECONDS = 0.1  # [s] over which a force is averaged
DEFAULT_RATE = 30.0  # [Hz] of a camera

MeasurementKind = Literal["weight", "contact", "told"]


@dataclass(frozen=True)
class Measurement:
    """What an instrument reads.

    Attributes:
        kind: `weight` of a body in a hand [kg], `contact` of two things (yes or no); `told`: what a truth file says.
        things: bodies, robots or `robot.link`.
    """

    kind: MeasurementKind
    things: tuple[str, ...] = ()


@dataclass(frozen=True)
class SensorBinding:
    """What answers one question of a plan.

    Attributes:
        asked: the ground atom or term, as plans spell it.
        outcomes: what may be answered; None: a number.
        measurement: what is read.
        comparison: `<`, `<=`, `>`, `>=` with the `threshold`, for a formula about a number; `not`: the opposite of a
            contact; None otherwise.
        wrong: the probability that the answer of one look is wrong.
        error: up to which probability the answer of all looks together may be wrong.
        looks: how often is looked at most.
    """

    asked: str
    outcomes: tuple[str, ...] | None
    measurement: Measurement
    comparison: str | None = None
    threshold: float = 0.0
    wrong: float = 0.0
    error: float = DEFAULT_ERROR
    looks: int = DEFAULT_LOOKS
    place: Place | None = field(default=None, compare=False, repr=False)

    @property
    def least_looks(self) -> int:
        """How many looks that agree bring the error below its bound: n with rⁿ >= (m - 1) (1 - error) / error.

        r = (1 - wrong) (m - 1) / wrong is how much more probable an answer is if it is true, of m outcomes.
        """
        if self.outcomes is None or self.wrong == 0.0:
            return 1
        others = max(1, len(self.outcomes) - 1)
        ratio = (1.0 - self.wrong) * others / self.wrong
        return max(1, ceil(log(others * (1.0 - self.error) / self.error) / log(ratio) - 1e-9))


@dataclass(frozen=True)
class CameraDescription:
    """What sees bodies: those in `bodies`, at some `rate` [Hz].

    Attributes:
        position, angle: standard deviations along and about each axis [m, rad].
        dropout: the probability that a body is not seen in a picture.
    """

    bodies: tuple[str, ...]
    position: float = 0.0
    angle: float = 0.0
    dropout: float = 0.0
    rate: float = DEFAULT_RATE


@dataclass(frozen=True)
class SensorsDescription:
    """A sensor file: bindings by what is asked, the camera, and how weights are measured.

    Attributes:
        camera: None: the bodies are seen as they are.
        weight_noise: the standard deviation of a weight [kg].
        weight_seconds: over which a force is averaged [s].
    """

    name: str
    bindings: Mapping[str, SensorBinding]
    camera: CameraDescription | None = None
    weight_noise: float = 0.0
    weight_seconds: float = DEFAULT_SECONDS
    file: str = "sensors"


@dataclass(frozen=True)
class TruthDescription:
    """A truth file: what the simulator owns, and neither the plan nor the controller knows.

    Attributes:
        masses: of bodies [kg].
        answers: of formulas (`true`, `false`) and terms that no physics has.
        position, turn: standard deviations by which bodies are off the scene, along x and y and about z [m, rad].
        displaced: of bodies, an offset (x, y, z) [m] and a turn about z [rad] that are given.
    """

    name: str = "truth"
    masses: Mapping[str, float] = field(default_factory=dict)
    answers: Mapping[str, str] = field(default_factory=dict)
    position: float = 0.0
    turn: float = 0.0
    displaced: Mapping[str, tuple[tuple[float, float, float], float]] = field(default_factory=dict)
