"""Bases that drive: `moves` in the base of a robot, and the floor region that it names.

Source: docs/reference/scenes.md#mobile-bases.
"""

from collections.abc import Mapping as MappingType

from kabo.language.findings import Findings
from kabo.language.scene_description import (
    BASE_JOINTS,
    DriveDescription,
    PoseDescription,
    RegionDescription,
    RobotDescription,
)
from kabo.language.yaml.documents import Mapping, YamlNode
from kabo.language.yaml.scenes.poses import read_pose
from kabo.language.yaml.values import Reader

MOVES = "moves"
DRIVE_KEYS = ("kind", "within", "joints", "speed", "turn_speed", "turn", "travel")
UNPLANNED_DRIVES = ("differential", "car", "ackermann", "diff_drive", "nonholonomic")
_KNOWN = "kabo plans bases of the kind planar, which go in every direction and turn on the spot"


def read_base(reader: Reader, node: YamlNode | None) -> tuple[PoseDescription, DriveDescription | None]:
    """The pose of a robot's base, and how the base drives; None if it stands."""
    pose = read_pose(reader, node, (MOVES,))
    if not isinstance(node, Mapping) or MOVES not in node.entries:
        return pose, None
    return pose, _drive(reader, node)


def _drive(reader: Reader, base: Mapping) -> DriveDescription | None:
    mapping = reader.mapping(reader.require(base, MOVES, "a base"), "`moves`")
    if mapping is None:
        return None
    reader.keys(mapping, DRIVE_KEYS, "`moves`")
    _check_kind(reader, mapping.get("kind"))
    within = reader.text(reader.require(mapping, "within", "`moves`"), "the floor region of a base")
    speed = reader.positive(mapping.get("speed"), "the speed of a base")
    turn_speed = _turn_speed(reader, mapping.get("turn_speed"))
    turn = reader.numbers(mapping.get("turn"), "`turn` [from, to]", 2, angle=True)
    if turn is not None and turn[0] > turn[1]:
        reader.findings.add(mapping.key("turn").place, "`turn` is crossed: write [from, to]")
    joints = _joints(reader, mapping.get("joints"))
    travel = reader.text(mapping.get("travel"), "`travel`")
    if within is None:
        return None
    usual = DriveDescription(within)
    return DriveDescription(
        within, joints, speed or usual.speed, turn_speed or usual.turn_speed,
        usual.turn if turn is None else (turn[0], turn[1]), travel, mapping.entries["within"][1].place,
    )  # fmt: skip


def _check_kind(reader: Reader, node: YamlNode | None) -> None:
    word = reader.text(node, "`kind`")
    if node is None or word is None or word == "planar":
        return
    if word in UNPLANNED_DRIVES:
        text = f"a base of the kind {word} cannot go sideways, and kabo plans no such motion"
        fix = "write `kind: planar` if a controller follows x, y and yaw; else let the base stand"
        reader.findings.add(node.place, text, fix)
    else:
        reader.findings.add(node.place, f'unknown kind "{word}" of a base that moves', _KNOWN)


def _turn_speed(reader: Reader, node: YamlNode | None) -> float | None:
    value = reader.number(node, "the turn_speed of a base", angle=True)
    if node is not None and value is not None and value <= 0.0:
        reader.findings.add(node.place, "the turn_speed of a base is not above 0")
    return value


def _joints(reader: Reader, node: YamlNode | None) -> tuple[str, str, str]:
    if node is None:
        return BASE_JOINTS
    words = [reader.text(item, "the name of a joint") for item in reader.items(node, "the joints of a base")]
    names = [word for word in words if word is not None]
    if len(names) == len(words) and (len(names) != 3 or len(set(names)) != 3):
        reader.findings.add(node.place, "a base that moves has three joints: [x, y, yaw]")
    return (names[0], names[1], names[2]) if len(names) == 3 else BASE_JOINTS


def check_floors(
    robots: MappingType[str, RobotDescription],
    regions: MappingType[str, RegionDescription],
    poses: MappingType[str, PoseDescription],
    findings: Findings,
) -> None:
    """Reports floor regions that do not exist, that hang on a robot that drives, and unknown travel configurations.

    `poses` are those of all things by their names.
    """
    for name, robot in robots.items():
        drive = robot.drive
        if drive is None or drive.place is None:
            continue
        if drive.within not in regions:
            hint = findings.near(drive.within, regions.keys()) or _how(regions)
            findings.add(drive.place, f'unknown region "{drive.within}" as the floor of "{name}"', hint)
        elif (carrier := _carrier(drive.within, robots, poses)) is not None:
            text = f'the floor "{drive.within}" of "{name}" hangs on "{carrier}", which drives itself'
            findings.add(drive.place, text, "name the frame of a body, or world, in the pose of the region")
        if drive.travel is not None and drive.travel not in robot.configurations:
            hint = findings.near(drive.travel, robot.configurations.keys())
            findings.add(drive.place, f'"{name}" has no configuration "{drive.travel}" to travel in', hint)


def _how(regions: MappingType[str, RegionDescription]) -> str | None:
    return None if regions else "a floor is a region: regions: {hall: {box: [6, 4, 2]}}"


def _carrier(
    region: str, robots: MappingType[str, RobotDescription], poses: MappingType[str, PoseDescription]
) -> str | None:
    """The robot with a moving base on whose link a region hangs; None if there is none."""
    here, seen = region, set[str]()
    while here in poses and here not in seen:
        seen.add(here)
        here = poses[here].frame.partition(".")[0]
        if here in robots and robots[here].drive is not None:
            return here
    return None
