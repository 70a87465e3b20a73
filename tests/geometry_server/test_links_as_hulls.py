"""`hulls: [links]`: robots whose link meshes are not closed are asked about by the hulls of their links."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from kabo.errors import InputError, MeshError
from kabo.geometry_server import GeometryServer
from kabo.language.yaml.loading import load_scene_description
from kabo.scene import load_scene

URDF = """<robot name="one">
  <link name="base"/>
  <link name="arm"><collision><geometry><mesh filename="arm.stl"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="arm"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
</robot>
"""
SCENE = """scene: hulls
epsilon: 0.01
robots:
  r: {urdf: one.urdf%s}
objects:
  ball: {sphere: {radius: 0.05}, pose: {position: [1, 0, 0]}}
"""


def server(folder: Path, extra: str = "") -> GeometryServer:
    """A robot that slides an open channel (a box of 0.2 m without its ends) along x."""
    box = trimesh.creation.box((0.2, 0.2, 0.2))
    sides = np.abs(box.face_normals[:, 0]) < 0.5
    trimesh.Trimesh(box.vertices, box.faces[sides], process=False).export(folder / "arm.stl")
    (folder / "one.urdf").write_text(URDF)
    (folder / "scene.yaml").write_text(SCENE % extra)
    return GeometryServer(load_scene(load_scene_description(folder / "scene.yaml")))


def test_a_link_that_is_not_closed_is_refused_and_the_message_says_what_helps(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="hulls"):
        server(tmp_path).collides("r", [0.0])


@pytest.mark.slow
def test_hulls_enclose_the_links_and_hollows_count_as_full(tmp_path: Path) -> None:
    made = server(tmp_path, ", hulls: [arm]")
    reached = [x for x in np.linspace(0.5, 1.5, 101) if made.collides("r", [x])]
    assert made.collides("r", [1.0])  # the ball is in the middle of the channel
    for end, inwards in ((reached[0], 0.85), (reached[-1], 1.15)):
        assert abs(end - 1.0) > 0.15 - 1e-9  # nothing is overlooked
        assert abs(end - inwards) < 0.01 + 1e-9
    assert np.diff(reached).max() < 0.011


def test_a_gripper_without_joints_needs_no_open_and_closed_and_unknown_links_are_told(tmp_path: Path) -> None:
    made = server(tmp_path, ", hulls: [arm], gripper: {joints: [], touch_links: [arm]}")
    gripper = made.scene.robots["r"].gripper
    assert gripper is not None and (gripper.joints, dict(gripper.open)) == ((), {})
    with pytest.raises(InputError, match='did you mean "arm"'):
        server(tmp_path, ", hulls: [amr]")
    with pytest.raises(InputError, match='a gripper needs the key "open"'):
        server(tmp_path, ", gripper: {joints: [slide], touch_links: [arm]}")
