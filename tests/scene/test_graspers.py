"""Grippers of two makes in one scene: each grasp family is for those robots only whose hand it tells how to close."""

from pathlib import Path

import pytest

from kabo.scene import load_scene
from tests.support.small_robots import ARM

SCENE = """\
scene: two_makes
epsilon: 0.01
robots:
  one: {urdf: one.urdf, gripper: {joints: [finger], open: {finger: 0.04}, closed: {finger: 0}}}
  two: {urdf: two.urdf, base: {position: [5, 0, 0]}, gripper: {joints: [jaw], open: {jaw: 0.04}, closed: {jaw: 0}}}
  bare: {urdf: one.urdf, base: {position: [9, 0, 0]}, joints: [shoulder, elbow, turn]}
objects:
  can:
    box: [0.05, 0.05, 0.1]
    movable: true
    grasps:
      top: {constraints: ["aligned(this.axis, world.up)"], «KEYS»}
"""


@pytest.mark.parametrize(
    ("keys", "users"),
    [
        ("fingers: {finger: 0.02}", ("one", "bare")),
        ("fingers: {jaw: 0.02}", ("two", "bare")),
        ("fingers: {jaw: 0.02}, robots: [two]", ("two",)),
        ("fingers: {jaw: 0.02}, robots: [one, two]", ("two",)),
        ("fingers: {finger: 0.02, jaw: 0.03}", None),
        ("lift: {along: world.up, distance: [0.03, 0.1]}", None),
    ],
)
def test_a_family_is_for_those_whose_hand_it_closes(tmp_path: Path, keys: str, users: tuple[str, ...] | None):
    (tmp_path / "one.urdf").write_text(ARM)
    (tmp_path / "two.urdf").write_text(ARM.replace('"finger"', '"jaw"'))
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE.replace("«KEYS»", keys))
    assert load_scene(path).bodies["can"].grasps["top"].robots == users
