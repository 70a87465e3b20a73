"""Scene files: names, models, frames, mates, allowed contacts."""
# ruff: noqa: E501 (messages stand on one line, as they are printed)

import pytest

from kabo.errors import InputError
from kabo.language import load_scene_description
from tests.language.conftest import SCENE, Kitchen

WRONG_SCENES = [
    (
        "epsilon: 0.02",
        "epsilon: «2cm»",
        'epsilon must be a number, this is "2cm"',
        "lengths are metres: write 0.02",
    ),
    ("epsilon: 0.02", "epsilon: «0»", "epsilon must be greater than 0", None),
    (
        "home: [0, -90 deg, 0.5]",
        "home: [0, «5mm», 0.5]",
        'every number of the configuration "home" must be a number, this is "5mm"',
        "angles are rad, or 45deg; lengths are metres: 0.005",
    ),
    ("epsilon: 0.02", "epsilon: «nan»", 'epsilon must be a number, this is "nan"', None),
    ("epsilon: 0.02", "epsilon: «1e999»", "epsilon is too large to be a number", None),
    ("epsilon: 0.02", "epsilon: «20 deg»", "epsilon is no angle: only angles have the suffix deg", None),
    ("epsilon: 0.02", "epsilon: «0,02»", 'epsilon must be a number, this is "0,02"', "write 0.5, not 0,5"),
    ("epsilon: 0.02", "epsilon: 0.02\n«object»: {}", 'unknown key "object" of a scene', 'did you mean "objects"?'),
    (
        "support: table",
        "support: «tabel»",
        'unknown body "tabel" as the support of a region',
        'did you mean "table"?',
    ),
    (
        "  - [left.base_link, table]",
        "  - [left.base_link, «tabel»]",
        '"tabel" is no robot, robot.link or body of the scene',
        'did you mean "table"?; a link is written with its robot: left.tabel',
    ),
    (
        "  - [left.base_link, table]",
        "  - [«right.base_link», table]",
        '"right.base_link" is no robot, robot.link or body of the scene',
        "there are left, table, tray, bottle_1",
    ),
    (
        "  - [left.base_link, table]",
        "  - [«table.link», left]",
        '"table.link" is no robot, robot.link or body of the scene',
        'did you mean "table"?',
    ),
    (
        "  - [left.base_link, table]",
        "  - [left.base_link, «tabel*»]",
        '"tabel*" is no robot, robot.link or body of the scene',
        'did you mean "table"?; a link is written with its robot: left.tabel*',
    ),
    (
        "  - [left.base_link, table]",
        "  - «left.base_link»",
        "an allowed contact is a pair: [robot.link, body]",
        None,
    ),
    ("  tray:", "  «left»:", '"left" is already the name of a robot, body or region', "it is declared in line 4"),
    ("  tray:", "  «Tray»:", '"Tray" cannot be the name of a body', 'write "tray": names match [a-z][a-z0-9_]*'),
    ("  tray:", "  «world»:", '"world" is a frame and cannot be the name of a body', None),
    (
        "frame: table, rpy",
        "frame: «shelf», rpy",
        'unknown frame "shelf" of "tray"',
        "a region is no frame: name the frame of its pose",
    ),
    ("frame: table, rpy", "frame: «left», rpy", '"left" is a robot: name one of its links, "left.link"', None),
    ("frame: table, rpy", "frame: «table.link», rpy", '"table" is no robot: its frame is called "table"', None),
    (
        "frame: table, rpy",
        "frame: «tray», rpy",
        "the frames form a circle: tray → tray",
        "give one of them a pose in the frame of something else",
    ),
    ("frame: table, rpy", "frame: «Table», rpy", '"Table" is no frame: world, an object, or robot.link', None),
    (
        "pose: {position: [0, 0, -0.02]}",
        "pose: {frame: «tray»}",
        "the frames form a circle: table → tray → table",
        "give one of them a pose in the frame of something else",
    ),
    ("    model: arm", "    model: «arn»", 'unknown model "arn"', 'did you mean "arm"?'),
    (
        "motion_constraints:",
        "mates: {m: {moving: bottle, fixed: «botle», constraints: []}}\nmotion_constraints:",
        'unknown model "botle" in a mate',
        'did you mean "bottle"?',
    ),
    (
        "motion_constraints:",
        'mates: {m: {moving: bottle, fixed: bottle, constraints: ["aligned(moving.axis, «fixed.axle»)"]}}\nmotion_constraints:',
        '"bottle" has no feature "axle"',
        "there are axis, base",
    ),
    (
        "motion_constraints:",
        "mates: {m: {moving: bottle, fixed: bottle, constraints: [], insertion: {along: «this.axis», distance: 1}}}\nmotion_constraints:",
        'unknown role "this" in "this.axis"',
        "there are moving, fixed, world",
    ),
    (
        "motion_constraints:",
        "packages: {meshes: «nowhere»}\nmotion_constraints:",
        'package "meshes": there is no folder "nowhere"',
        None,
    ),
    (
        "motion_constraints:",
        "packages: {no-such-thing: «installed»}\nmotion_constraints:",
        'package "no-such-thing" is not installed',
        "the robots of example-robot-data come with pip install 'kabo[robots]'",
    ),
    (
        "- angle(this.axis, world.up) <= 10 deg",
        "- angle(«support.top», world.up) <= 10 deg",
        'unknown role "support" in "support.top"',
        "there are tool, this, world",
    ),
]


@pytest.mark.parametrize(("old", "new", "message", "hint"), WRONG_SCENES, ids=[row[2] for row in WRONG_SCENES])
def test_a_wrong_scene_is_reported_at_its_place(
    kitchen: Kitchen, old: str, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("scene", old, new, message, hint)


def test_patterns_of_allowed_contacts_fit_bodies(kitchen: Kitchen) -> None:
    kitchen.write(scene=SCENE.replace("[left.base_link, table]", "[left.base_link, 't*']"))
    scene = load_scene_description(kitchen.folder / "scene.yaml")
    assert {("left.base_link", "table"), ("left.base_link", "tray")} <= set(scene.allowed_contacts)


def test_patterns_of_allowed_contacts_fit_robots(kitchen: Kitchen) -> None:
    kitchen.write(scene=SCENE.replace("[left.base_link, table]", "['*.base_link', table]"))
    scene = load_scene_description(kitchen.folder / "scene.yaml")
    assert {(f"{robot}.base_link", "table") for robot in scene.robots} <= set(scene.allowed_contacts)
    said = '"x*.base_link" is no robot, robot.link or body of the scene'
    kitchen.expect("scene", "[left.base_link, table]", "[«'x*.base_link'», table]", said, "there are left, table")


def test_packages_that_are_installed_are_found_by_their_names(
    kitchen: Kitchen, monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """`share/NAME` below the prefix of the interpreter; but not for those who may read one folder only."""
    away = tmp_path_factory.mktemp("away")
    (away / "share" / "robots").mkdir(parents=True)
    monkeypatch.setattr("sys.prefix", str(away))
    kitchen.write(scene=SCENE + "packages: {robots: installed}\n")
    scene = load_scene_description(kitchen.folder / "scene.yaml")
    assert scene.packages == {"robots": away / "share" / "robots"}
    with pytest.raises(InputError, match="outside of the folder"):
        load_scene_description(kitchen.folder / "scene.yaml", within=kitchen.folder)
