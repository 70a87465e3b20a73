"""SRDF files of a scene: tools from HPP's grippers, features and grasp families from its handles.

Source: docs/how-to/robots.md.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path

from kabo.language.names import NAME, proper_name
from kabo.language.robot_files.srdf import read_srdf
from kabo.language.scene_description import (
    Constraint,
    ContactPattern,
    Feature,
    FeatureName,
    GraspFamily,
    Stroke,
    Vector,
)
from kabo.language.semantic_description import HandlingFrame, SemanticDescription
from kabo.language.source import missing_file_reason
from kabo.language.yaml.documents import Scalar, Sequence, YamlNode
from kabo.language.yaml.paths import read_file_path
from kabo.language.yaml.values import Reader

AXES = ("x", "y", "z")
TOOL_POINT, TOOL_APPROACH, TOOL_CLOSING = "tcp", "approach", "closing"  # of the first gripper: its point, x and y
TOOL_FEATURES = frozenset((TOOL_POINT, TOOL_APPROACH, TOOL_CLOSING))
HANDLE_ROOM = 0.1  # [m] by which the approach to a handle may be longer than its clearance


def read_semantics(
    reader: Reader, node: YamlNode | None, packages: Mapping[str, Path]
) -> SemanticDescription | None:
    """The SRDF file that a node names; None if it is absent. What is wrong in the file is reported."""
    path = read_file_path(reader, node, "SRDF", packages)
    if path is None or node is None or missing_file_reason(path) is not None:
        return None
    described, found = read_srdf(path, node.place)
    for finding in found:
        reader.findings.include(finding)
    return described


def tool_of(
    semantics: SemanticDescription | None, frame: str | None
) -> tuple[str | None, dict[str, Feature | None]]:
    """The tool frame and the features that HPP's grippers give; those of grippers on other links are left out.

    A robot without a tool of its own gets the first gripper's link, with its point as `tcp`, its x axis as `approach`
    and its y axis as `closing`.
    """
    features: dict[str, Feature | None] = {}
    grippers = semantics.grippers if semantics is not None else ()
    if frame is None and grippers:
        frame, first = grippers[0].link, grippers[0]
        features[TOOL_POINT] = Feature("point", first.position)
        features[TOOL_APPROACH] = Feature("line", first.position, _axis(first, 0))
        features[TOOL_CLOSING] = Feature("line", first.position, _axis(first, 1))
    for gripper in grippers:
        if gripper.link == frame:
            features.update(frame_features(gripper))
    return frame, features


def frame_features(frame: HandlingFrame) -> dict[str, Feature | None]:
    """The features of a gripper or handle: its point by its name, and its axes as lines `NAME_x`, `NAME_y`, `NAME_z`."""
    name = spelled(frame.name)
    features: dict[str, Feature | None] = {name: Feature("point", frame.position)}
    for number, axis in enumerate(AXES):
        features[f"{name}_{axis}"] = Feature("line", frame.position, _axis(frame, number))
    return features


def handle_grasps(handles: Iterable[HandlingFrame]) -> dict[str, GraspFamily]:
    """A grasp family for each handle of an object: the tool's frame on the handle's, as far as its mask says."""
    families = {}
    for handle in handles:
        name = spelled(handle.name)
        places = [("coincident", TOOL_POINT, name)]
        if handle.mask[4] or handle.mask[5]:
            places.append(("aligned", TOOL_APPROACH, f"{name}_x"))
        if handle.mask[3]:
            places.append(("aligned", TOOL_CLOSING, f"{name}_y"))
        constraints = tuple(
            Constraint(kind, FeatureName("tool", ours), FeatureName("this", theirs), place=handle.place)
            for kind, ours, theirs in places
        )
        stroke = Stroke(FeatureName("tool", TOOL_APPROACH), 1, handle.clearance, handle.clearance + HANDLE_ROOM)
        families[name] = GraspFamily(name, constraints, approach=stroke)
    return families


def spelled(name: str) -> str:
    """A name of an SRDF file as kabo spells names: lower case, with `_` for all else."""
    return name if NAME.fullmatch(name) else proper_name(name)


def _axis(frame: HandlingFrame, number: int) -> Vector:
    """The x, y or z axis of a frame."""
    x, y, z, w = frame.quaternion
    columns = (
        (1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)),
        (2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)),
        (2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)),
    )
    a, b, c = columns[number]
    return a + 0.0, b + 0.0, c + 0.0


# ------------------------------------------------------------------------------------------------ groups, contacts
def read_group(reader: Reader, node: YamlNode | None, semantics: SemanticDescription | None) -> str | None:
    """The group of the SRDF file that `joints: NAME` means; None if the joints are a list, or absent."""
    if not isinstance(node, Scalar) or node.empty or node.refused:
        return None
    if semantics is None:
        hint = "write a list of joints, or name the robot's SRDF file: srdf: FILE"
        reader.findings.add(
            node.place, f'"{node.text}" would be a group of joints, but the robot has no SRDF', hint
        )
    elif node.text not in semantics.groups:
        near = reader.findings.near(node.text, semantics.groups)
        reader.findings.add(node.place, f'unknown group "{node.text}" of {semantics.path.name}', near)
    else:
        return node.text
    return None


def read_own_contacts(reader: Reader, node: YamlNode | None) -> tuple[ContactPattern, ...]:
    """The pairs of links of one robot that may touch: names, patterns with `*`, groups."""
    items = reader.items(node, "the allowed contacts")
    if isinstance(node, Sequence) and len(items) == 2 and all(isinstance(item, Scalar) for item in items):
        items = [node]  # a list of one may be written without brackets
    found = []
    for item in items:
        if not isinstance(item, Sequence) or len(item.items) != 2:
            reader.findings.add(item.place, "an allowed contact of a robot is a pair: [link, link]")
            continue
        first, second = (reader.text(each, "a link") for each in item.items)
        if first is not None and second is not None:
            found.append(ContactPattern(first, second, item.place))
    return tuple(found)
