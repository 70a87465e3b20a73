"""Refused calls that epsilon alone decides, and one that no epsilon changes: a hand that touches what it shall take."""

import re
from pathlib import Path

import pytest

from kabo.explain.explain import explain
from kabo.language import load_problem
from kabo.language.recorded_paths import installed_folder
from kabo.planner.result import Result
from kabo.planner.solve import solve
from tests.explain.foreign import cups

pytestmark = pytest.mark.skipif(
    installed_folder("example-robot-data") is None, reason="the extra `robots` is not installed"
)
SUCTION = """<robot name="suction">
  <link name="bellows"><collision>
    <origin xyz="0 0 0.05"/><geometry><box size="0.02 0.02 0.1"/></geometry></collision></link>
</robot>
"""
JAWS_OPEN = """      open: {jaw: 0.055}
      closed: {jaw: 0.0}
      touch_links: [left_jaw, right_jaw]
"""


def sucked(folder: Path, before: float) -> Path:
    """The problem of a cup that a suction cup on the flange takes from above; at the grasp it is `before` above [m]."""
    path = cups(folder, at={"cup": (0.5, -0.25, 0.05)}, epsilon=0.01)
    scene = (folder / "scene.yaml").read_text()
    for old, new in (
        ("jaws.urdf", "suction.urdf"),
        (JAWS_OPEN, "      joints: []\n      touch_links: [bellows]\n"),
        ("0, 0, 0.13]", f"0, 0, {0.1 + before:.9g}]"),
        ("[[palm, ee_link], [palm, ", "[[bellows, ee_link], [bellows, "),
        ("in [0.06, 0.08]", "= 0.1"),
        ("\n        fingers: {jaw: 0.034}", ""),
    ):
        assert old in scene, old
        scene = scene.replace(old, new)
    (folder / "scene.yaml").write_text(scene)
    (folder / "suction.urdf").write_text(SUCTION)
    return path


def reasons(result: Result) -> str:
    assert result.plan is None and result.reason is not None
    return "\n".join(result.reason.details)


def test_two_that_touch_are_not_refused_because_of_epsilon(tmp_path: Path) -> None:
    """Rounding has the exact meshes a few nanometres apart, for which no epsilon does that a command takes."""
    path = sucked(tmp_path, 1e-8)
    said = reasons(solve(load_problem(path), max_samples=20_000, timeout=600.0))
    assert "blocked by cup" in said and "epsilon" not in said
    found = explain(load_problem(path), max_samples=20_000, timeout=600.0, changes=0)
    assert "only because of epsilon" not in str(found), str(found)


def test_two_that_are_nearer_than_epsilon_are_told_with_one_that_does(tmp_path: Path) -> None:
    path = sucked(tmp_path, 0.0005)
    said = reasons(solve(load_problem(path), max_samples=20_000, timeout=600.0))
    found = re.search(r"arm.bellows and cup are 0.5 mm apart, nearer than .* \(try --epsilon ([\d.]+)\)", said)
    assert found is not None, said
    assert solve(load_problem(path), epsilon=float(found[1]), max_samples=20_000, timeout=600.0).status == "solved"
