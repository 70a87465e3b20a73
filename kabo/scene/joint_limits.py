"""The limits of velocity, acceleration and jerk that a scene gives the joints of a robot, checked against its URDF.

What it does not give is by default (kabo/scene/motion_limits.py) [docs/reference/scenes.md#motion].
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.language.formulas import Place
from kabo.language.scene_description import RateLimits, RobotDescription
from kabo.scene.motion_limits import ONSET, RAMP

DEFAULT_VELOCITY = math.pi  # [rad/s or m/s] where neither URDF nor scene gives a velocity limit
MIN_VELOCITY = 1e-6  # [rad/s or m/s]: rounding of plans is faster than a joint below; 0 in a URDF stands for none
RATES = ("velocity", "acceleration", "jerk")


@dataclass(frozen=True)
class JointRates:
    """What a scene says of some joints [rad or m, and s]."""

    velocity: Mapping[str, float]
    acceleration: Mapping[str, float]
    jerk: Mapping[str, float]


def joint_rates(
    description: RobotDescription,
    names: tuple[str, ...],
    planned: int,
    urdf_velocity: Mapping[str, float | None],
) -> JointRates:
    """The limits that a scene gives; a number for all joints makes a gripper slower than by default, never faster.

    Args:
        description: the robot's entry.
        names: the joints, first the `planned` ones, then the gripper's.
        planned: the number of planned joints.
        urdf_velocity: the limits of the URDF; None where it has none.

    Raises:
        InputError: names that are no joint's, velocities above the URDF's, each at its place; a URDF whose limit of
            velocity is below `MIN_VELOCITY`.
    """
    given = {rate: getattr(description, rate) for rate in RATES}
    wrong = list(_unknown(description, given, names))
    wrong += _too_fast(given["velocity"], names, urdf_velocity, description)
    wrong += _too_slow(urdf_velocity, description)
    if wrong:
        raise InputError(wrong)
    velocity, acceleration, jerk = {}, {}, {}
    for k, name in enumerate(names):
        own, gripper = urdf_velocity[name], k >= planned
        fastest = _limit(given["velocity"], name, own, at_most=own) or own or DEFAULT_VELOCITY
        velocity[name] = fastest
        usual = fastest / RAMP
        hardest = _limit(given["acceleration"], name, None, at_most=usual if gripper else None)
        if hardest is not None:
            acceleration[name] = hardest
        usual = (usual if hardest is None else hardest) / ONSET
        sharpest = _limit(given["jerk"], name, None, at_most=usual if gripper else None)
        if sharpest is not None:
            jerk[name] = sharpest
    return JointRates(velocity, acceleration, jerk)


def _limit(limits: RateLimits, name: str, otherwise: float | None, *, at_most: float | None) -> float | None:
    """The limit of a joint by its name, or else the one of all joints, but `at_most`."""
    if name in limits.joints:
        return limits.joints[name].value
    if limits.every is None:
        return otherwise
    return limits.every.value if at_most is None else min(limits.every.value, at_most)


def _unknown(
    description: RobotDescription, given: Mapping[str, RateLimits], names: tuple[str, ...]
) -> Iterator[Diagnostic]:
    """The names that are no joint's, those in `limits` once each."""
    robot = description.place
    places = dict.fromkeys(description.limits, robot) | dict(description.limit_places)
    for name in places:
        if name not in names:
            yield _error(places[name] or robot, f'unknown joint "{name}" in the limits', _near(name, names))
    for rate, limits in given.items():
        for name, limit in limits.joints.items():
            if name not in names and name not in places:
                text = f'unknown joint "{name}" in the {rate} limits'
                yield _error(limit.place or robot, text, _near(name, names))


def _near(name: str, names: tuple[str, ...]) -> str:
    return did_you_mean(name, names) or f"there are {', '.join(names)}"


def _too_fast(
    limits: RateLimits,
    names: tuple[str, ...],
    urdf_velocity: Mapping[str, float | None],
    description: RobotDescription,
) -> list[Diagnostic]:
    found = []
    for name, limit in limits.joints.items():
        own = urdf_velocity.get(name)
        if own is not None and limit.value > own * (1.0 + 1e-9):
            text = f'velocity {limit.value:g} of "{name}" is above the {own:g} of its URDF'
            found.append(_error(limit.value_place or description.place, text, _NARROWER))
    every = limits.every
    known = [own for name in names if (own := urdf_velocity.get(name)) is not None]
    if every is not None and len(known) == len(names) and every.value > max(known, default=every.value):
        text = f"velocity {every.value:g} is above those of all joints in the URDF: {max(known):g} at most"
        found.append(_error(every.place or description.place, text, _NARROWER))
    return found


def _too_slow(urdf_velocity: Mapping[str, float | None], description: RobotDescription) -> Iterator[Diagnostic]:
    for name, own in urdf_velocity.items():
        if own is not None and own < MIN_VELOCITY:
            text = f'the URDF limits the velocity of "{name}" to {own:g}, {MIN_VELOCITY:g} is the least'
            hint = "write a velocity that the joint can have, or 0 where it is not known"
            yield _error(description.place, text, hint)


_NARROWER = "a scene can only make a robot slower; change the URDF if it is wrong"


def _error(place: Place | None, text: str, hint: str | None) -> Diagnostic:
    at = place or Place("scene", 1, 1)
    return Diagnostic(at.file, at.line, at.column, text, hint, at.length)
