"""`hulls: [links]`: robots whose link meshes are not closed are asked about by the hulls of their links."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from kabo.errors import InputError, MeshError
from kabo.geometry import Solid
from kabo.geometry_server import GeometryServer, SceneEnclosures
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


TWO = """<robot name="one">
  <link name="base"/>
  <link name="arm">
    <collision><origin xyz="0 %g 0"/><geometry><mesh filename="arm.stl"/></geometry></collision>
    <collision><geometry><mesh filename="%s.stl"/></geometry></collision>
    <collision><origin xyz="0 0 1"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="arm"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
</robot>
"""


def test_of_a_link_of_several_meshes_only_the_open_ones_become_hulls(tmp_path: Path) -> None:
    server(tmp_path)
    ring = trimesh.creation.annulus(r_min=0.3, r_max=0.4, height=0.1)
    ring.export(tmp_path / "ring.stl")
    (tmp_path / "one.urdf").write_text(TWO % (1, "ring"))
    (tmp_path / "scene.yaml").write_text(SCENE % ", hulls: [arm]")
    scene = load_scene(load_scene_description(tmp_path / "scene.yaml"))
    whole, sound, ball = SceneEnclosures(scene, 0.004).elements("r.arm")
    own = scene.robots["r"].links["arm"].elements
    assert sound is own[1] and ball is own[2]  # the ring keeps its hole, the sphere is round
    assert whole.mesh.vertices[:, 1].min() == pytest.approx(0.9)  # the hull is that of the channel alone
    assert Solid(whole.mesh.vertices, whole.mesh.faces).insides(np.array([[0.0, 1.0, 0.0]])).all()
    made = GeometryServer(scene)
    assert not made.collides("r", [1.0])  # the sphere of the scene is in the middle of the ring


def test_of_a_mesh_with_a_closed_frame_beside_an_open_housing_only_the_housing_becomes_a_hull(
    tmp_path: Path,
) -> None:
    """As Baxter's torso, one file: its frame stands around the shoulders, which the hull of all would fill."""
    server(tmp_path)
    frame = trimesh.creation.annulus(r_min=0.42, r_max=0.5, height=0.1)
    housing = trimesh.creation.box([0.2, 0.2, 0.2])
    housing.apply_translation([0.0, 0.0, 0.5])
    housing.update_faces(np.arange(12) > 0)
    trimesh.util.concatenate([frame, housing]).export(tmp_path / "arm.stl")
    (tmp_path / "one.urdf").write_text(TWO % (0, "arm"))
    (tmp_path / "scene.yaml").write_text(SCENE % ", hulls: [arm]")
    scene = load_scene(load_scene_description(tmp_path / "scene.yaml"))
    kept, hull = SceneEnclosures(scene, 0.004).elements("r.arm")[:2]
    assert len(kept.mesh.faces) == len(frame.faces) and len(hull.mesh.faces) == 12
    parts = SceneEnclosures(scene, 0.004).of("r.arm").parts
    middle, inside = np.array([0.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.5])
    within = [
        [bool((ConvexHull(part).equations @ [*point, 1.0] <= 0.0).all()) for part in parts if len(part) > 3]
        for point in (middle, inside)
    ]
    assert [any(each) for each in within] == [False, True]


def test_where_all_meshes_are_closed_each_becomes_its_own_hull(tmp_path: Path) -> None:
    server(tmp_path)
    trimesh.creation.annulus(r_min=0.1, r_max=0.2, height=0.1).export(tmp_path / "arm.stl")
    trimesh.creation.annulus(r_min=0.1, r_max=0.2, height=0.1).export(tmp_path / "ring.stl")
    (tmp_path / "one.urdf").write_text(TWO % (1, "ring"))
    (tmp_path / "scene.yaml").write_text(SCENE % ", hulls: [arm]")
    scene = load_scene(load_scene_description(tmp_path / "scene.yaml"))
    first, second, ball = SceneEnclosures(scene, 0.004).elements("r.arm")
    for each, middle in ((first, 1.0), (second, 0.0)):
        solid = Solid(each.mesh.vertices, each.mesh.faces)
        assert solid.insides(np.array([[0.0, middle, 0.0], [0.0, 0.5, 0.0]])).tolist() == [True, False]
    assert ball.kind == "sphere"


def test_a_flat_mesh_among_others_is_within_the_hull_of_the_whole_link(tmp_path: Path) -> None:
    server(tmp_path)
    sheet = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], process=False)
    sheet.export(tmp_path / "sheet.stl")
    (tmp_path / "one.urdf").write_text(TWO % (0, "sheet"))
    (tmp_path / "scene.yaml").write_text(SCENE % ", hulls: [arm]")
    scene = load_scene(load_scene_description(tmp_path / "scene.yaml"))
    (whole,) = SceneEnclosures(scene, 0.004).elements("r.arm")
    inner = np.array([[0.9, 0.01, 0.0], [0.0, 0.0, 1.05]])
    assert Solid(whole.mesh.vertices, whole.mesh.faces).insides(inner).all()


def test_a_gripper_without_joints_needs_no_open_and_closed_and_unknown_links_are_told(tmp_path: Path) -> None:
    made = server(tmp_path, ", hulls: [arm], gripper: {joints: [], touch_links: [arm]}")
    gripper = made.scene.robots["r"].gripper
    assert gripper is not None and (gripper.joints, dict(gripper.open)) == ((), {})
    with pytest.raises(InputError, match='did you mean "arm"'):
        server(tmp_path, ", hulls: [amr]")
    with pytest.raises(InputError, match='a gripper needs the key "open"'):
        server(tmp_path, ", gripper: {joints: [slide], touch_links: [arm]}")
