"""Constraints: shapes, bounds, roles and features."""

import math

import pytest

from kabo.language import check_files, load_problem
from kabo.language.scene_description import Constraint
from tests.language.conftest import SCENE, Kitchen

WRONG_CONSTRAINTS = [
    ("coincident(«tool.tpc», this.axis)", '"left" has no feature "tpc"', 'did you mean "tcp"?'),
    ("coincident(tool.tcp, «this.axle»)", '"bottle_1" has no feature "axle"', "there are axis, base"),
    ("coincident(«tol.tcp», this.axis)", 'unknown role "tol" in "tol.tcp"', 'did you mean "tool"?'),
    ("«coincide»(tool.tcp, this.axis)", 'unknown constraint "coincide"', 'did you mean "coincident"?'),
    (
        "«parallel(tool.tcp, this.axis)»",
        "parallel does not relate a point and a line",
        "it relates line–line, line–plane, plane–plane",
    ),
    ("coincident(tool.tcp, «this»)", 'name a feature of "this": this.NAME', None),
    ("coincident(tool.tcp, this.axis) «=» 3", "coincident has no bound", None),
    ("«distance(tool.tcp, this.axis)»", "distance needs a bound", "distance(…) <= 0.01, or in [x, y]"),
    (
        "distance(tool.tcp, this.axis) = «0»",
        "distance 0 has a word of its own",
        "write coincident(tool.tcp, this.axis)",
    ),
    (
        "distance(tool.tcp, this.axis) <= «0»",
        "distance 0 has a word of its own",
        "write coincident(tool.tcp, this.axis)",
    ),
    (
        "distance(tool.tcp, this.axis) in [«0», 0]",
        "distance 0 has a word of its own",
        "write coincident(tool.tcp, this.axis)",
    ),
    ("distance(tool.tcp, this.axis) <= «-1»", "a distance is never negative", None),
    ("distance(tool.tcp, this.axis) «<» 1", 'a bound is written with "=", "<=", ">=" or in [x, y]', 'write "<="'),
    ("distance(tool.tcp, this.axis) <= «10 deg»", "distance is in metres: only angles have the suffix deg", None),
    (
        "«distance(this.axis, tool.tcp) <= 1»",
        "distance does not relate a line and a point",
        "the point stands first: distance(tool.tcp, this.axis)",
    ),
    ("«angle(tool.approach, this.axis)»", "angle needs a bound", "angle(…) <= 10 deg, or in [x, y]"),
    (
        "angle(tool.approach, this.axis) = «0 deg»",
        "angle 0 has a word of its own",
        "write aligned(tool.approach, this.axis)",
    ),
    (
        "angle(tool.approach, this.axis) = «180 deg»",
        "angle 180 deg has a word of its own",
        "write opposed(tool.approach, this.axis)",
    ),
    ("angle(tool.approach, this.axis) <= «200 deg»", "an angle lies between 0 and 180 deg", None),
    (
        "angle(tool.approach, this.axis) in [«20 deg», 10 deg]",
        "the lower bound is greater than the upper one",
        None,
    ),
    ("«height(tool.tcp, this.axis) = 0.1»", "height does not relate a point and a line", "it relates point–plane"),
    ("inside(«this.axis», world)", "inside takes whole bodies: inside(this, region)", None),
    ("inside(this, «region»)", 'unknown role "region" in "region"', "there are tool, this, world"),
    ("height(tool.tcp, this.base) «!=» 1", 'a bound is written with "=", "<=", ">=" or in [x, y]', None),
    ("distance(tool.tcp, this.axis) <= «1e999»", "this number is too large", None),
    ("coincident(tool.tcp «this».axis)", 'unexpected "this", expected ","', None),
]


@pytest.mark.parametrize(("new", "message", "hint"), WRONG_CONSTRAINTS, ids=[row[1] for row in WRONG_CONSTRAINTS])
def test_a_wrong_constraint_is_reported_at_its_place(
    kitchen: Kitchen, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("scene", "coincident(tool.tcp, this.axis)", new, message, hint)


def _read(kitchen: Kitchen, text: str) -> Constraint:
    kitchen.write(scene=SCENE.replace("coincident(tool.tcp, this.axis)", text))
    scene = load_problem(kitchen.problem).scene
    assert scene is not None
    return scene.bodies["bottle_1"].grasps["side"].constraints[0]


@pytest.mark.parametrize(
    ("text", "lower", "upper"),
    [
        ("distance(tool.tcp, this.axis) = 0.1", 0.1, 0.1),
        ("distance(tool.tcp, this.axis) <= 0.1", None, 0.1),
        ("distance(tool.tcp, this.axis) >= 0", 0.0, None),
        ("height(tool.tcp, this.base) = 0", 0.0, 0.0),
        ("height(tool.tcp, this.base) in [-0.1, 2e-2]", -0.1, 0.02),
        ("angle(tool.approach, this.axis) = 90 deg", math.pi / 2, math.pi / 2),
        ("angle(tool.approach, this.axis) in [0, 1.5]", 0.0, 1.5),
        ("angle(tool.approach, this.base) >= 170deg", math.radians(170), None),
        ("parallel(tool.approach, this.axis)", None, None),
    ],
)
def test_bounds_are_in_metres_and_radians(
    kitchen: Kitchen, text: str, lower: float | None, upper: float | None
) -> None:
    constraint = _read(kitchen, text)
    assert (constraint.lower, constraint.upper) == (lower, upper)


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("coincident(this.axis, tool.tcp)", "tool.tcp"),
        ("coincident(tool.tcp, this.axis)", "tool.tcp"),
        ("aligned(this.base, tool.approach)", "tool.approach"),
        ("aligned(this.axis, tool.approach)", "this.axis"),
    ],
)
def test_features_stand_in_the_order_point_line_plane(kitchen: Kitchen, text: str, first: str) -> None:
    assert str(_read(kitchen, text).first) == first


def test_tool_features_are_those_of_any_robot_that_could_use_them(kitchen: Kitchen) -> None:
    two = SCENE.replace(
        "  left:\n    model: arm\n", "  right: {urdf: arm.urdf, tool: {frame: x}}\n  left:\n    model: arm\n"
    )
    kitchen.write(scene=two)
    assert check_files([kitchen.problem]) == []
    kitchen.write(scene=two.replace("      side:\n", "      side:\n        robots: right\n"))
    messages = [each.message for each in check_files([kitchen.problem])]
    assert messages == ['"right" has no feature "tcp"'] * 2 + ['"right" has no feature "approach"']
