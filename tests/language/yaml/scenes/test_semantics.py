"""SRDF files of scenes: HPP's grippers and handles, groups, patterns of allowed contacts."""

from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.language import load_scene_description
from kabo.scene import load_scene
from tests.support.small_robots import write_arm

GRIPPER = """<robot name="small">
  <group name="fingers"><link name="left"/><link name="right"/></group>
  <gripper name="grip" clearance="0.01"><position>0 0 0.1 0 -0.7071068 0 0.7071068</position><link name="hand"/></gripper>
</robot>
"""
HANDLE = """<robot name="beam">
  <handle name="Side 0" clearance="0.02"><position>0.1 0 0 0 0 0 1</position><link name="beam"/></handle>
  <handle name="turn" clearance="0"><position>0 0 0 0 0 0 1</position><mask>1 1 1 0 1 1</mask><link name="beam"/></handle>
</robot>
"""


def _scene(folder: Path, contacts: str = "[]", own: str = "[]") -> Path:
    write_arm(folder)
    (folder / "small.srdf").write_text(GRIPPER)
    (folder / "beam.srdf").write_text(HANDLE)
    path = folder / "scene.yaml"
    path.write_text(
        "scene: s\nepsilon: 0.01\nrobots:\n  r:\n    urdf: small.urdf\n    srdf: small.srdf\n"
        f"    allowed_contacts: {own}\n"
        "objects:\n  beam: {box: [0.3, 0.05, 0.05], pose: {position: [2, 0, 0]}, movable: true, srdf: beam.srdf}\n"
        f"allowed_contacts: {contacts}\n"
    )
    return path


def test_a_gripper_is_a_tool_whose_x_axis_approaches(tmp_path: Path) -> None:
    robot = load_scene_description(_scene(tmp_path)).robots["r"]
    assert robot.tool_frame == "hand"
    assert robot.tool_features["tcp"].origin == (0.0, 0.0, 0.1)
    assert robot.tool_features["approach"].direction == pytest.approx((0.0, 0.0, 1.0), abs=1e-6)
    assert robot.tool_features["closing"].direction == pytest.approx((0.0, 1.0, 0.0), abs=1e-6)
    assert set(robot.tool_features) == {"tcp", "approach", "closing", "grip", "grip_x", "grip_y", "grip_z"}


def test_a_handle_is_a_grasp_family_as_far_as_its_mask_says(tmp_path: Path) -> None:
    beam = load_scene_description(_scene(tmp_path)).bodies["beam"]
    assert beam.features["side_0"].origin == (0.1, 0.0, 0.0)
    kinds = {name: [(c.kind, str(c.second)) for c in family.constraints] for name, family in beam.grasps.items()}
    assert kinds["side_0"] == [
        ("coincident", "this.side_0"),
        ("aligned", "this.side_0_x"),
        ("aligned", "this.side_0_y"),
    ]
    assert kinds["turn"] == [("coincident", "this.turn"), ("aligned", "this.turn_x")]
    stroke = beam.grasps["side_0"].approach
    assert stroke is not None and (stroke.minimum, stroke.maximum) == pytest.approx((0.02, 0.12))


@pytest.mark.parametrize(
    ("contacts", "pairs"),
    [
        ("[[r.*, beam]]", {"base", "upper", "lower", "hand", "left", "right"}),
        ("[[r.*er, beam]]", {"upper", "lower"}),
        ("[[r.fingers, beam]]", {"left", "right"}),
        ("[[r.left, beam]]", {"left"}),
        ("[[r, beam]]", {"base", "upper", "lower", "hand", "left", "right"}),
    ],
)
def test_patterns_and_groups_stand_for_links(tmp_path: Path, contacts: str, pairs: set[str]) -> None:
    scene = load_scene(load_scene_description(_scene(tmp_path, contacts)))
    assert scene.allowed == {frozenset((f"r.{link}", "beam")) for link in pairs}


def test_contacts_of_a_robot_are_of_its_own_links(tmp_path: Path) -> None:
    scene = load_scene(load_scene_description(_scene(tmp_path, own="[[base, fingers]]")))
    assert scene.allowed == {frozenset(("r.base", "r.left")), frozenset(("r.base", "r.right"))}


@pytest.mark.parametrize("contacts", ["[[r.lft, beam]]", "[[r.lef?t, beam]]", "[[r.fingrs, beam]]"])
def test_a_word_that_fits_nothing_is_an_error_at_its_place(tmp_path: Path, contacts: str) -> None:
    with pytest.raises(InputError) as raised:
        load_scene(load_scene_description(_scene(tmp_path, contacts)))
    (found,) = raised.value.diagnostics
    assert (found.line, found.column) == (10, 20) and "did you mean" in (found.hint or "")
