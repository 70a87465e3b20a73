"""Poses, and the tree of frames that they form [docs/reference/scenes.md]."""

import math
import re
from collections.abc import Mapping as MappingType
from dataclasses import dataclass

from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.scene_description import PoseDescription, Quaternion, Vector
from kabo.language.yaml.documents import Mapping, YamlNode
from kabo.language.yaml.values import Reader

POSE_KEYS = ("frame", "position", "quaternion", "rpy")
_UNIT_TOLERANCE = 1e-6
_LONGEST_CIRCLE = 12
_FRAME = re.compile(r"[a-z][a-z0-9_]*(\.\S+)?")


def quaternion_of_rpy(rpy: Vector) -> Quaternion:
    """The rotation of URDF's roll, pitch, yaw [rad] (about fixed x, then y, then z) as (x, y, z, w)."""
    (sr, sp, sy), (cr, cp, cy) = ([fun(angle / 2) for angle in rpy] for fun in (math.sin, math.cos))
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def read_pose(reader: Reader, node: YamlNode | None, beside: tuple[str, ...] = ()) -> PoseDescription:
    """The pose that a mapping describes, with defaults for absent keys; keys `beside` are read elsewhere.

    The `place` of the pose, used in messages, is that of the frame's name, or of the mapping if it names no frame.
    """
    mapping = reader.mapping(node, "a pose")
    if mapping is None:
        return PoseDescription(place=None if node is None else node.place)
    reader.keys(mapping, (*POSE_KEYS, *beside), "a pose")
    frame_node = mapping.get("frame")
    frame = reader.text(frame_node, "a frame") or "world"
    if frame_node is not None and not _FRAME.fullmatch(frame):
        reader.findings.add(frame_node.place, f'"{frame}" is no frame: world, an object, or robot.link')
        frame = "world"
    position = reader.position(mapping.get("position"), "a position") or (0.0, 0.0, 0.0)
    return PoseDescription(frame, position, _orientation(reader, mapping), (frame_node or mapping).place)


def read_local_pose(reader: Reader, node: YamlNode | None, what: str) -> PoseDescription:
    """A pose in a frame that is known otherwise, so that it has none of its own; where it is absent, the same frame."""
    mapping = reader.mapping(node, what)
    if mapping is None:
        return PoseDescription()
    reader.keys(mapping, POSE_KEYS[1:], what)
    kept = {key: entry for key, entry in mapping.entries.items() if key in POSE_KEYS[1:]}
    return read_pose(reader, Mapping(mapping.source, mapping.start, mapping.end, kept, mapping.flow))


def _orientation(reader: Reader, mapping: Mapping) -> Quaternion:
    if "quaternion" in mapping.entries and "rpy" in mapping.entries:
        message = "a pose has either a quaternion or rpy, not both"
        reader.findings.add(mapping.key("rpy").place, message)
    if (node := mapping.get("quaternion")) is not None:
        values = reader.numbers(node, "a quaternion (x, y, z, w)", 4)
        if values is not None:
            length = math.hypot(*values)
            if abs(length - 1.0) <= _UNIT_TOLERANCE:
                x, y, z, w = (value / length for value in values)
                return (x, y, z, w)
            hint = "no rotation is [0, 0, 0, 1]"
            if 1e-9 < length < math.inf:
                hint = f"normalised: [{', '.join(f'{value / length:.7g}' for value in values)}]"
            reader.findings.add(node.place, f"a quaternion must have length 1, this one has {length:.7g}", hint)
    elif (node := mapping.get("rpy")) is not None:
        angles = reader.numbers(node, "rpy (roll, pitch, yaw)", 3, angle=True)
        if angles is not None:
            return quaternion_of_rpy((angles[0], angles[1], angles[2]))
    return (0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Framed:
    """A thing with a pose; `place` is the place where the file names its frame."""

    frame: str
    place: Place


def check_frames(
    things: MappingType[str, Framed], robots: MappingType[str, object], regions: MappingType[str, object],
    findings: Findings,
) -> None:  # fmt: skip
    """Reports frames that do not exist, and frames that depend on each other in a cycle.

    Args:
        things: everything that has a pose, robots included.
        robots: the robots of the scene.
        regions: the regions of the scene, which cannot be used as frames.
        findings: the collection that receives findings.
    """
    for name, thing in things.items():
        owner, dot, _ = thing.frame.partition(".")
        if owner == "world" and not dot:
            continue
        if owner not in things or owner in regions:
            known = [*(each for each in things if each not in regions), "world"]
            hint = findings.near(owner, known)
            if owner in regions:
                hint = "a region is no frame: name the frame of its pose"
            findings.add(thing.place, f'unknown frame "{thing.frame}" of "{name}"', hint)
        elif dot and owner not in robots:
            findings.add(thing.place, f'"{owner}" is no robot: its frame is called "{owner}"')
        elif not dot and owner in robots:
            findings.add(thing.place, f'"{owner}" is a robot: name one of its links, "{owner}.link"')
    _report_circles(things, findings)


def _report_circles(things: MappingType[str, Framed], findings: Findings) -> None:
    finished: set[str] = set()
    for start in things:
        chain: dict[str, None] = {}
        here = start
        while here in things and here not in finished:
            if here in chain:
                names = list(chain)
                circle = [*names[names.index(here) :], here]
                shown = circle if len(circle) <= _LONGEST_CIRCLE else [*circle[:_LONGEST_CIRCLE], "…"]
                hint = "give one of them a pose in the frame of something else, or in the world"
                findings.add(things[here].place, f"the frames form a circle: {' → '.join(shown)}", hint)
                break
            chain[here] = None
            here = things[here].frame.partition(".")[0]
        finished.update(chain)
