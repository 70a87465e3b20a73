"""What the limits of mimic joints leave to the joints that they follow, in position and in velocity.

A mimic joint takes `multiplier * q + offset` for the value q of its source. It has limits of its own in a URDF, which
narrow those of the source.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from kabo.language.formulas import Place
from kabo.language.robot_files.xml_files import Element
from kabo.scene.urdf_files.elements import Urdf

MAX_VELOCITY = 100.0  # [rad/s or m/s]: this and more in a URDF stands for none, no joint is as fast
LIMITS_ARE_FROM = "they are those of the URDF (and of the joints that mimic it there), or of `limits` in the scene"
LEAST_ROOM = 1e-9  # [rad or m]: a range that is no wider is a single value
DECIMALS = 12  # of a limit that is computed: kabo verify grants 1e-8
LEAST_MULTIPLIER = 1e-9  # of a mimic joint: one below stands still, whatever its source does


@dataclass(frozen=True)
class MimicJoint:
    """A joint that takes `multiplier * q + offset` for the value q of `source`, and its own limits.

    `lower` and `upper` [rad or m] are infinite where the URDF writes none, and so is `velocity` [rad/s or m/s] where it
    gives none that a joint can have. `place` is that of the joint in the URDF.
    """

    name: str
    source: str
    multiplier: float
    offset: float
    lower: float
    upper: float
    velocity: float
    place: Place

    @property
    def range_of_source(self) -> tuple[float, float]:
        """The least and the greatest value of the source at which this joint keeps its limits [rad or m]."""
        if abs(self.multiplier) < LEAST_MULTIPLIER:
            return -math.inf, math.inf
        # Rounded, so that 0.03 at 0.8 q + 0.002 is 0.035 and not a little less, where a scene could not name the end.
        ends = [round((bound - self.offset) / self.multiplier, DECIMALS) for bound in (self.lower, self.upper)]
        return min(ends), max(ends)

    def impossible(self, lower: float, upper: float) -> str:
        """The message that this joint is outside its limits wherever its source is within [lower, upper]."""
        rule = f"{self.multiplier:g} times its value plus {self.offset:g}"
        return (
            f'joint "{self.name}" follows "{self.source}" ({rule}), and is outside its own limits {self.lower:g} to '
            f"{self.upper:g} wherever that is within {lower:g} to {upper:g}"
        )


def mimic_joint(urdf: Urdf, name: str, joint: Element, rule: tuple[str, float, float]) -> MimicJoint:
    """A mimic joint of a checked URDF, with its rule: the joint that moves, multiplier and offset."""
    limit, most = joint.find("limit"), (-math.inf, math.inf, math.inf)
    if limit is not None and joint.get("type") != "fixed":
        velocity = urdf.numbers(limit, "velocity", 1, "0", largest=1e300)[0]
        written = "lower" in limit.attrib or "upper" in limit.attrib
        bounded = written and joint.get("type") in ("revolute", "prismatic")
        low, high = (urdf.numbers(limit, key, 1, "0", largest=1e300)[0] for key in ("lower", "upper"))
        usable = velocity if 0.0 < velocity < MAX_VELOCITY else math.inf
        most = (low, high, usable) if bounded else (-math.inf, math.inf, usable)
    return MimicJoint(name, *rule, *most, urdf.place(joint))


def narrowed(
    source: str, lower: float, upper: float, mimics: Mapping[str, MimicJoint]
) -> tuple[float, float, MimicJoint | None]:
    """The limits of a joint at which those that mimic it keep theirs [rad or m], and one that cannot; None: all can.

    Limits of a mimic joint that would leave its source a single value are not meant, and narrow nothing: in the URDF of
    the PR2 a finger follows its neighbour with the opposite sign, and has the same limits.
    """
    for mimic in _of(source, mimics):
        low, high = mimic.range_of_source
        low, high = max(lower, low), min(upper, high)
        if low > high + LEAST_ROOM:
            return lower, upper, mimic
        if high > low + LEAST_ROOM:
            lower, upper = low, high
    return lower, upper, None


def slowed(source: str, velocity: float | None, mimics: Mapping[str, MimicJoint]) -> float | None:
    """The velocity of a joint at which those that mimic it keep theirs [rad/s or m/s]; None: nothing limits it."""
    most = math.inf if velocity is None else velocity
    for mimic in _of(source, mimics):
        if abs(mimic.multiplier) >= LEAST_MULTIPLIER:
            most = min(most, mimic.velocity / abs(mimic.multiplier))
    return most if most < MAX_VELOCITY else velocity


def _of(source: str, mimics: Mapping[str, MimicJoint]) -> Iterator[MimicJoint]:
    return (mimic for mimic in mimics.values() if mimic.source == source)
