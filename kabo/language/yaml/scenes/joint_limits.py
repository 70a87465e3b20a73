"""Limits of a robot's joints: `limits`, `velocity`, `acceleration`, `jerk` [docs/reference/scenes.md#motion]."""

from collections.abc import Mapping as MappingType
from dataclasses import dataclass, field

from kabo.language.formulas import Place
from kabo.language.scene_description import RateLimit, RateLimits
from kabo.language.yaml.documents import Mapping, Scalar, Sequence, YamlNode
from kabo.language.yaml.values import Reader

RATES = ("velocity", "acceleration", "jerk")
LIMIT_KEYS = ("position", *RATES)


@dataclass(frozen=True)
class JointLimits:
    """The limits that a robot's entry gives: `positions` by joint, `rates` by their names in `RATES`."""

    positions: MappingType[str, tuple[float, float]]
    rates: MappingType[str, RateLimits]
    places: MappingType[str, Place]  # of the joints in `limits`


@dataclass
class _Found:
    positions: dict[str, tuple[float, float]] = field(default_factory=dict)
    every: dict[str, RateLimit] = field(default_factory=dict)  # by rate
    joints: dict[str, dict[str, RateLimit]] = field(default_factory=lambda: {rate: {} for rate in RATES})
    places: dict[str, Place] = field(default_factory=dict)


def read_joint_limits(reader: Reader, robot: Mapping) -> JointLimits:
    """The limits in a robot's entry: a number in `velocity`, `acceleration` or `jerk` counts for all joints."""
    found = _Found()
    for rate in RATES:
        _read_rate(reader, rate, robot.get(rate), found)
    for joint, key, value in reader.entries(robot.get("limits"), "the limits"):
        found.places[joint] = key.place
        if isinstance(value, Mapping):
            _read_long_form(reader, joint, value, found)
        else:
            _read_position(reader, joint, value, found)
    rates = {rate: RateLimits(found.every.get(rate), found.joints[rate]) for rate in RATES}
    return JointLimits(found.positions, rates, found.places)


def _read_rate(reader: Reader, rate: str, node: YamlNode | None, found: _Found) -> None:
    if isinstance(node, Sequence):
        text = f"`{rate}` is a number for all joints, or a mapping of joints to numbers"
        reader.findings.add(node.place, text, f"write {rate}: {{joint: number}}")
    elif isinstance(node, Scalar) and not node.empty:
        value = reader.rate(node, f"the {rate} of a robot")
        if value is not None:
            found.every[rate] = RateLimit(value, node.place)
    else:
        for joint, key, entry in reader.entries(node, f"`{rate}`"):
            _read_joint(reader, rate, joint, key.place, entry, found)


def _read_joint(reader: Reader, rate: str, joint: str, place: Place, node: YamlNode, found: _Found) -> None:
    value = reader.rate(node, f'the {rate} of "{joint}"')
    if value is not None:
        found.joints[rate][joint] = RateLimit(value, place, node.place)


def _read_long_form(reader: Reader, joint: str, mapping: Mapping, found: _Found) -> None:
    reader.keys(mapping, LIMIT_KEYS, f'the limits of "{joint}"')
    if "position" in mapping.entries:
        _read_position(reader, joint, mapping.entries["position"][1], found)
    for rate in RATES:
        if rate not in mapping.entries:
            continue
        key, node = mapping.entries[rate]
        if joint in found.joints[rate]:
            hint = f"write it in `{rate}` or in `limits`, not in both"
            reader.findings.add(key.place, f'the {rate} of "{joint}" is given twice', hint)
        else:
            _read_joint(reader, rate, joint, found.places[joint], node, found)


def _read_position(reader: Reader, joint: str, node: YamlNode, found: _Found) -> None:
    values = reader.numbers(node, f'the limits of "{joint}"', 2, angle=True)
    if values is not None and values[0] > values[1]:
        reader.findings.add(node.place, f'the limits of "{joint}" are crossed', "the lower one comes first")
    elif values is not None:
        found.positions[joint] = values[0], values[1]
