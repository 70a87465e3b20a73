"""Sensors of robots: cameras with a frame, a field of view and a range [docs/how-to/sensing.md]."""

import math

from kabo.language.scene_description import FARTHEST, SensorDescription
from kabo.language.yaml.documents import Mapping, Scalar, YamlNode
from kabo.language.yaml.scenes.poses import read_local_pose
from kabo.language.yaml.values import Reader

SENSOR_KEYS = ("frame", "pose", "field_of_view", "range", "allowed")
VIEW_KEYS = ("horizontal", "vertical")
_FAR_BEGINNING = (
    10.0  # m: a robot's camera that sees nothing nearer is more likely one with a range in millimetres
)
_WIDEST = math.pi  # rad: at half a turn a field of view is no cone any more


def read_sensors(reader: Reader, node: YamlNode | None) -> dict[str, SensorDescription]:
    """The sensors in a mapping by their names; those with errors, which are reported, are left out."""
    found: dict[str, SensorDescription] = {}
    for name, key, value in reader.entries(node, "the sensors"):
        sound = reader.check_name(key, "a sensor")
        mapping = reader.mapping(value, "a sensor") or Mapping(value.source, key.start, key.end)
        sensor = _read_sensor(reader, name, mapping)
        if sound and sensor is not None:
            found[name] = sensor
    return found


def _read_sensor(reader: Reader, name: str, mapping: Mapping) -> SensorDescription | None:
    reader.keys(mapping, SENSOR_KEYS, "a sensor")
    frame = reader.text(reader.require(mapping, "frame", "a sensor"), "the frame of a sensor")
    angles = _field_of_view(reader, reader.require(mapping, "field_of_view", "a sensor"))
    span = _range(reader, reader.require(mapping, "range", "a sensor"))
    local = read_local_pose(reader, mapping.get("pose"), "the pose of a sensor in its frame")
    allowed = [
        reader.text(item, "the name of a link") for item in reader.items(mapping.get("allowed"), "`allowed`")
    ]
    if frame is None or angles is None or span is None or None in allowed:
        return None
    links = tuple(link for link in allowed if link is not None)
    return SensorDescription(
        name, frame, angles, span, local.position, local.quaternion, links, (mapping.get("frame") or mapping).place
    )


def _field_of_view(reader: Reader, node: YamlNode | None) -> tuple[float, ...] | None:
    """One angle (a cone), or the horizontal and the vertical angle of a pyramid [rad]."""
    if not isinstance(node, Mapping):
        angle = _angle(reader, node, "`field_of_view`")
        return None if angle is None else (angle,)
    reader.keys(node, VIEW_KEYS, "a field of view")
    both = [_angle(reader, reader.require(node, key, "a field of view"), f"`{key}`") for key in VIEW_KEYS]
    return None if both[0] is None or both[1] is None else (both[0], both[1])


def _angle(reader: Reader, node: YamlNode | None, what: str) -> float | None:
    value = None if node is None else _number(reader, node, what)
    if value is None or node is None or value < _WIDEST:
        return value
    in_radians = isinstance(node, Scalar) and not node.text.strip().endswith("deg")
    hint = f"angles are radians: write {value:g} deg" if in_radians and value < 180.0 else None
    reader.findings.add(
        node.place, f"{what} lies between 0 and 180 deg, this is {math.degrees(value):g} deg", hint
    )
    return None


def _number(reader: Reader, node: YamlNode, what: str) -> float | None:
    value = reader.number(node, what, angle=True)
    if value is not None and value <= 0.0:
        reader.findings.add(node.place, f"{what} must be greater than 0")
        return None
    return value


def _range(reader: Reader, node: YamlNode | None) -> tuple[float, float] | None:
    """The least and the greatest distance [m]."""
    values = reader.numbers(node, "`range`", 2)
    if values is None or node is None:
        return None
    near, far = values
    if not 0.0 < near < far <= FARTHEST:
        hint = f"write [{far:g}, {near:g}]" if 0.0 < far < near <= FARTHEST else None
        text = f"`range` is [least, greatest] distance of what is seen, above 0 m and at most {FARTHEST:g} m"
        reader.findings.add(node.place, text, hint)
        return None
    if near >= _FAR_BEGINNING:
        text = f"a sensor with this `range` sees nothing that is nearer than {near:g} m"
        hint = f"lengths are metres: if these are millimetres, write [{near / 1000:g}, {far / 1000:g}]"
        reader.findings.add(node.place, text, hint, warning=True)
    return near, far
