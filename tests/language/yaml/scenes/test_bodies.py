"""Bodies and regions: shapes, families, strokes, poses."""

import pytest

from tests.language.conftest import Kitchen

WRONG_BODIES = [
    (
        "mesh: bottle.stl",
        "mesh: «bottel.stl»",
        'mesh "bottel.stl": there is no such file',
        'did you mean "bottle.stl"?',
    ),
    (
        "mesh: bottle.stl",
        "mesh: bottle.stl\n    «box»: [1, 1, 1]",
        "a body has one shape, this one has mesh and box",
        None,
    ),
    ("    scale: 0.001", "    scale: «0»", "the scale must be greater than 0", None),
    ("    scale: 0.001", "    mass: «-1»", "the mass must be greater than 0", None),
    ("    scale: 0.001", "    movable: «yes»", '`movable` must be true or false, not "yes"', None),
    (
        "    scale: 0.001",
        "    «colour»: red",
        'unknown key "colour" of a model',
        "there are mesh, box, cylinder, sphere, capsule, scale, pose, movable, mass, features, grasps, placements, srdf",
    ),
    ("[0.9, 1.6, 0.04]", "«[0.9, 0, 0.04]»", "the sides of a box must be greater than 0", None),
    ("[0.9, 1.6, 0.04]", "«[0.9, 1.6]»", "the whole sides of a box must have 3 numbers, not 2", None),
    ("[0.9, 1.6, 0.04]", "«0.9»", "the whole sides of a box must be a list of 3 numbers: [0, 0, 0]", None),
    ("radius: 0.2,", "radius: «-0.2»,", "the radius must be greater than 0", None),
    ("{radius: 0.2, height: 0.01}", "«{radius: 0.2}»", 'a cylinder needs the key "height"', None),
    ("box: [0.9, 1.6, 0.04], pose", "box: [0.9, 1.6, 0.04], «scale»: 2, pose", "only a mesh has a scale", None),
    (
        "  table: {box: [0.9, 1.6, 0.04], pose: {position: [0, 0, -0.02]}}",
        "  table: {box: [0.9, 1.6, 0.04]}\n  thing: «{mass: 1}»",
        "a body needs a shape: one of mesh, box, cylinder, sphere, capsule",
        None,
    ),
    (
        "approach: {along: tool.approach, distance: [0.05, 0.15]}",
        "approach: {along: «tool.tcp», distance: [0.05, 0.15]}",
        '"tool.tcp" is a point; a motion follows a line',
        None,
    ),
    (
        "approach: {along: tool.approach, distance: [0.05, 0.15]}",
        "approach: {along: «approach», distance: [0.05, 0.15]}",
        '"approach" is no feature: write tool.approach or world.up',
        None,
    ),
    (
        "approach: {along: tool.approach, distance: [0.05, 0.15]}",
        "approach: {along: tool.approach, distance: «[0.15, 0.05]»}",
        "a distance [min, max] needs 0 <= min <= max",
        None,
    ),
    (
        "approach: {along: tool.approach, distance: [0.05, 0.15]}",
        "approach: «{distance: 0.1}»",
        "`approach` needs exactly one of along and against",
        None,
    ),
    (
        "      side:\n        constraints:",
        "      side:\n        robots: [«rihgt»]\n        constraints:",
        'unknown robot "rihgt"',
        "there are left",
    ),
    (
        "      side:\n        constraints:",
        "      side:\n        «constraint»: []\n        constraints:",
        'unknown key "constraint" of a grasp family',
        'did you mean "constraints"?',
    ),
    (
        "rpy: [0, 0, 90 deg]",
        "quaternion: «[0, 0, 0, 2]»",
        "a quaternion must have length 1, this one has 2",
        "normalised: [0, 0, 0, 1]",
    ),
    (
        "rpy: [0, 0, 90 deg]",
        "quaternion: «[0, 0, 0]»",
        "a quaternion (x, y, z, w) must have 4 numbers, not 3",
        None,
    ),
    (
        "rpy: [0, 0, 90 deg]",
        "quaternion: [0, 0, 0, 1], «rpy»: [0, 0, 0]",
        "a pose has either a quaternion or rpy, not both",
        None,
    ),
    (
        "rpy: [0, 0, 90 deg]",
        "«yaw»: 3",
        'unknown key "yaw" of a pose',
        "there are frame, position, quaternion, rpy",
    ),
    (
        "rpy: [0, 0, 90 deg]",
        "position: [0, 0, «90 deg»]",
        "every number of a position is no angle: only angles have the suffix deg",
        None,
    ),
]


@pytest.mark.parametrize(("old", "new", "message", "hint"), WRONG_BODIES, ids=[row[2] for row in WRONG_BODIES])
def test_a_wrong_body_is_reported_at_its_place(
    kitchen: Kitchen, old: str, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("scene", old, new, message, hint)
