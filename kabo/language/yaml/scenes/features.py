"""Features: the points, directed lines and planes that constraints relate [docs/reference/scenes.md]."""

import math
from collections.abc import Mapping as MappingType

from kabo.language.scene_description import Feature, Shape, Vector
from kabo.language.yaml.documents import Mapping, YamlNode
from kabo.language.yaml.values import Reader

FEATURE_KEYS = ("point", "line", "plane")
_ZERO: Vector = (0.0, 0.0, 0.0)
_UP: Vector = (0.0, 0.0, 1.0)

WORLD_FEATURES: MappingType[str, Feature] = {
    "origin": Feature("point", _ZERO),
    "up": Feature("line", _ZERO, _UP),
    "floor": Feature("plane", _ZERO, _UP),
}


def given_features(shape: Shape | None) -> dict[str, Feature]:
    """The implicit features of a primitive shape, such as its origin and axes; none for a mesh or no shape."""
    if shape is None or shape.size is None:
        return {}
    features = {"center": Feature("point", _ZERO)}
    if shape.kind in ("box", "cylinder"):
        half = shape.size[2] / 2
        features["top"] = Feature("plane", (0.0, 0.0, half), _UP)
        features["bottom"] = Feature("plane", (0.0, 0.0, -half), _UP)
    if shape.kind in ("box", "cylinder", "capsule"):
        features["axis"] = features["up"] = Feature("line", _ZERO, _UP)
    if shape.kind == "box":
        features["x_axis"] = Feature("line", _ZERO, (1.0, 0.0, 0.0))
        features["y_axis"] = Feature("line", _ZERO, (0.0, 1.0, 0.0))
    return features


def read_features(reader: Reader, node: YamlNode | None) -> dict[str, Feature | None]:
    """The features in a mapping by their names; None for each faulty feature, which is reported."""
    features: dict[str, Feature | None] = {}
    for name, key, value in reader.entries(node, "features"):
        reader.check_name(key, "a feature")
        mapping = reader.mapping(value, "a feature")
        features[name] = None
        if mapping is None:
            continue
        reader.keys(mapping, FEATURE_KEYS, "a feature")
        if len(mapping.entries) != 1:
            reader.findings.add(key.place, "a feature is exactly one of point, line and plane")
            continue
        features[name] = _read_feature(reader, mapping)
    return features


def sound_features(features: MappingType[str, Feature | None]) -> dict[str, Feature]:
    """The features that were read without errors; faulty features, which are None in `features`, are left out."""
    return {name: feature for name, feature in features.items() if feature is not None}


def _read_feature(reader: Reader, mapping: Mapping) -> Feature | None:
    if "point" in mapping.entries:
        point = reader.position(mapping.get("point"), "a point")
        return None if point is None else Feature("point", point)
    kind, key = ("line", "along") if "line" in mapping.entries else ("plane", "normal")
    inner = reader.mapping(mapping.get(kind), f"a {kind}")
    if inner is None:
        return None
    reader.keys(inner, ("through", key), f"a {kind}")
    origin = reader.position(reader.require(inner, "through", f"a {kind}"), "`through`")
    direction = _direction(reader, reader.require(inner, key, f"a {kind}"), key)
    if origin is None or direction is None:
        return None
    return Feature("line" if kind == "line" else "plane", origin, direction)


def _direction(reader: Reader, node: YamlNode | None, key: str) -> Vector | None:
    vector = reader.vector(node, f"`{key}`")
    if vector is None or node is None:
        return None
    largest = max(abs(value) for value in vector)
    if largest == 0.0:
        reader.findings.add(node.place, f"`{key}` is zero and gives no direction")
        return None
    x, y, z = (value / largest for value in vector)
    length = math.hypot(x, y, z)
    return (x / length + 0.0, y / length + 0.0, z / length + 0.0)
