"""Constraints: shapes, bounds, roles and features."""

import pytest

from tests.language.conftest import Kitchen

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
