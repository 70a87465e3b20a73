"""Robots as `kabo robot` finds them: covers enclose, grippers are measured, homes are free, proofs hold, files load."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from kabo.geometry import Budget, Solid
from kabo.geometry_server import (
    GeometryServer,
    make_robot_model,
    robot_findings,
    robot_scene,
    robot_scene_text,
    robot_summary,
)
from kabo.geometry_server.answers import GeometryStatistics
from kabo.geometry_server.robot_models.covers import covers_of
from kabo.geometry_server.robot_models.link_pairs import LinkPairs
from kabo.geometry_server.robot_models.model import AlwaysPair, Wishes
from kabo.geometry_server.robot_models.overlap_proofs import always_overlap
from kabo.geometry_server.robot_models.self_contacts import SelfContacts, rounded_within
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.language import load_scene_description
from kabo.language.recorded_paths import installed_folder
from kabo.meshes import Mesh
from kabo.scene import Scene, load_scene
from tests.support.small_robots import write_arm

# Two links that overlap whatever the two joints between them do: both are balls around the joints' common centre.
KNOT = """<robot name="knot">
  <link name="base"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="ring"/>
  <link name="core"><collision><geometry><box size="0.06 0.06 0.06"/></geometry></collision></link>
  <link name="tool"/>
  <joint name="a" type="revolute"><parent link="base"/><child link="ring"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="b" type="revolute"><parent link="ring"/><child link="core"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="c" type="fixed"><parent link="core"/><child link="tool"/></joint>
</robot>
"""


def solids() -> list[trimesh.Trimesh]:
    tall = trimesh.creation.cylinder(0.05, 0.6)
    turned = tall.copy()
    turned.apply_transform(trimesh.transformations.random_rotation_matrix(np.array([0.1, 0.7, 0.3])))
    return [
        trimesh.creation.icosphere(radius=0.2),
        trimesh.creation.annulus(0.05, 0.1, 0.3),
        turned,
        trimesh.util.concatenate([trimesh.creation.box([0.1] * 3), trimesh.creation.torus(0.3, 0.02)]),
    ]


@pytest.mark.parametrize("solid", solids())
def test_every_point_of_a_solid_lies_in_one_of_its_covers(solid: trimesh.Trimesh) -> None:
    mesh = Mesh(np.ascontiguousarray(solid.vertices, float), np.ascontiguousarray(solid.faces, np.int64))
    covers = covers_of(mesh)
    assert len(covers) > 1
    rng = np.random.default_rng(3)
    low, high = solid.bounds
    points = low + rng.random((4000, 3)) * (high - low)
    points = np.concatenate([points[Solid(mesh.vertices, mesh.faces).insides(points)], solid.vertices])
    hulls = [trimesh.PointCloud(cover).convex_hull for cover in covers]
    normals = [
        (hull.face_normals, np.einsum("ij,ij->i", hull.face_normals, hull.triangles[:, 0])) for hull in hulls
    ]
    within = np.zeros(len(points), dtype=bool)
    for directions, offsets in normals:
        within |= (points @ directions.T <= offsets + 1e-9).all(axis=1)
    assert within.all()


@pytest.fixture
def arm(tmp_path: Path) -> Scene:
    return _scene(
        tmp_path, write_arm(tmp_path), "gripper: {joints: [finger], open: {finger: 0.04}, closed: {finger: 0}}"
    )


def _scene(folder: Path, urdf: Path, *entries: str) -> Scene:
    text = "\n    ".join([f"urdf: {urdf.name}", *entries])
    (folder / "scene.yaml").write_text(f"scene: s\nepsilon: 0.01\nrobots:\n  r:\n    {text}\n")
    return load_scene(load_scene_description(folder / "scene.yaml"))


def test_the_pairs_that_meet_are_those_of_the_geometry_server(arm: Scene) -> None:
    contacts, server = SelfContacts(arm, "r", 0.01), GeometryServer(arm)
    kinds = set()
    for q in contacts.samples(60, seed=5):
        hit = server.collides("r", q.tolist())
        assert hit == bool(contacts.meeting(q.tolist()))
        kinds.add(hit)
    assert kinds == {True, False}


def test_a_configuration_that_is_found_is_free_for_the_geometry_server(arm: Scene) -> None:
    contacts = SelfContacts(arm, "r", 0.01)
    opened = contacts.samples(200, seed=5)
    opened[:, 3] = 0.04
    blocked = next(q for q in opened if contacts.meeting(q.tolist()))
    found = contacts.free_configuration([blocked], contacts.fine.pairs, blocked)
    assert found is not None
    q, margin = found
    assert not GeometryServer(arm).collides("r", q.tolist()) and margin > 0.0


def test_links_that_overlap_everywhere_are_proven_to(tmp_path: Path) -> None:
    (tmp_path / "knot.urdf").write_text(KNOT)
    scene = _scene(tmp_path, tmp_path / "knot.urdf")
    assert SelfContacts(scene, "r", 0.01).always() == [("base", "core")]
    depth = always_overlap(scene.robots["r"], ("base", "core"))
    assert depth is not None and 0.0 < depth < 0.05


def test_links_that_part_somewhere_are_not_proven_to_overlap(tmp_path: Path) -> None:
    far = KNOT.replace('<link name="core"><collision>', '<link name="core"><collision><origin xyz="0.06 0 0"/>')
    (tmp_path / "knot.urdf").write_text(far)
    scene = _scene(tmp_path, tmp_path / "knot.urdf")
    robot = scene.robots["r"]
    ends = [np.array([a, b]) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
    contacts = SelfContacts(scene, "r", 0.01)
    assert always_overlap(robot, ("base", "core")) is None or all(contacts.meeting(q.tolist()) for q in ends)


def test_a_gripper_is_measured_on_its_meshes(tmp_path: Path) -> None:
    """The fingers are 0.01 m wide, slide by q and 2 q + 0.001: their surfaces are 3 q + 0.001 - 0.01 apart."""
    model = make_robot_model(write_arm(tmp_path), None, name="small", epsilon=0.01)
    assert model.hand.arm == ("shoulder", "elbow", "turn") and model.hand.joints == ("finger",)
    assert model.gripper is not None and model.gripper.opening is not None
    assert model.gripper.open == {"finger": 0.04} and model.gripper.closed == {"finger": 0.0}
    assert model.gripper.opening == pytest.approx((0.111, -0.009), abs=1e-9)
    assert np.abs(model.gripper.closing) == pytest.approx([1.0, 0.0, 0.0])


@pytest.mark.parametrize("palm", ["", '<collision><geometry><box size="0.1 0.03 0.01"/></geometry></collision>'])
def test_a_frame_beyond_the_fingers_as_tool_changes_nothing_that_is_measured(tmp_path: Path, palm: str) -> None:
    """As Baxter's `right_gripper`: seen from there the fingers are behind, and approach still points away from the palm."""
    urdf = write_arm(tmp_path)
    beyond = """<link name="beyond"/><joint name="ahead" type="fixed"><parent link="hand"/><child link="beyond"/>
      <origin xyz="0 0 0.2"/></joint></robot>"""
    hand = f'<link name="hand">{palm}</link>'
    urdf.write_text(urdf.read_text().replace('<link name="hand"/>', hand).replace("</robot>", beyond))
    own, other = (
        make_robot_model(urdf, None, name="small", epsilon=0.01, wishes=Wishes(tip)).gripper
        for tip in ("hand", "beyond")
    )
    assert own is not None and other is not None
    assert other.opening == pytest.approx(own.opening) and own.opening == pytest.approx((0.111, -0.009), abs=1e-9)
    assert own.approach == pytest.approx([0.0, 0.0, 1.0]) and other.approach == pytest.approx(own.approach)
    assert other.closing == pytest.approx(own.closing)
    assert other.point + [0.0, 0.0, 0.2] == pytest.approx(own.point)


def test_links_of_a_hand_that_touch_while_it_is_open_are_allowed_and_a_home_is_found(tmp_path: Path) -> None:
    """The right finger carries a post that the left one meets when the gripper is open, and only then."""
    urdf = write_arm(tmp_path)
    post = (
        '<collision><origin xyz="0.121 0 0"/><geometry><box size="0.01 0.02 0.05"/></geometry></collision></link>'
    )
    text = urdf.read_text()
    end = text.index("</link>", text.index('<link name="right">'))
    urdf.write_text(text[:end] + post + text[end + len("</link>") :])
    model = make_robot_model(urdf, None, name="small", epsilon=0.01)
    assert [(each.first, each.second, each.hand) for each in model.always] == [("left", "right", True)]
    assert model.home is not None
    assert "# they touch, or nearly, while the gripper is open or closes" in robot_scene_text(model, tmp_path)


@pytest.mark.parametrize(("reach", "share"), [(2.2, 0.6), (1.0, None)])
def test_links_that_touch_at_many_configurations_are_told_and_not_allowed(
    tmp_path: Path, reach: float, share: float | None
) -> None:
    """A box at the end of a lever meets the table on which it turns beyond 0.93 rad, with epsilon from 0.85 on."""
    text = KNOT.replace("0.1 0.1 0.1", "0.5 0.5 0.1").replace(
        '<collision><geometry><box size="0.06', ('<collision><origin xyz="0 0 0.15"/><geometry><box size="0.06')
    )
    upper, lower = f'upper="{reach}"', f'lower="-{reach}"'
    (tmp_path / "lever.urdf").write_text(text.replace('upper="1"', upper).replace('lower="-1"', lower))
    model = make_robot_model(tmp_path / "lever.urdf", None, name="lever", epsilon=0.01, wishes=Wishes("tool"))
    assert model.always == ()
    written, told = robot_scene_text(model, tmp_path), "\n".join(robot_summary(model))
    if share is None:
        assert model.often == {} and "many configurations" not in written
        return
    assert dict(model.often) == {("base", "core"): pytest.approx(share, abs=0.05)}
    assert "base and core touch at" in told and "#   - [base, core]" in written
    (tmp_path / "written.yaml").write_text(written)
    assert load_scene(load_scene_description(tmp_path / "written.yaml")).allowed == frozenset()


def test_of_many_pairs_that_touch_the_summary_tells_four_and_the_scene_all(tmp_path: Path) -> None:
    model = replace(make_robot_model(write_arm(tmp_path), None, name="small", epsilon=0.01), often={})
    pairs = tuple(AlwaysPair("left", f"bone_{number}", None) for number in range(70))
    told = [line for line in robot_summary(replace(model, always=pairs)) if "touch" in line]
    assert len(told) == 5 and told[-1] == "  66 more pairs may touch; all are in `allowed_contacts` of the scene"
    assert robot_scene_text(replace(model, always=pairs), tmp_path).count("[left, bone_") == 70
    assert sum("touch" in line for line in robot_summary(replace(model, always=pairs[:4]))) == 4


def test_the_tool_of_a_hand_that_was_not_measured_is_told_to_be_a_guess(tmp_path: Path) -> None:
    model = make_robot_model(write_arm(tmp_path), None, name="small", epsilon=0.01)
    assert model.gripper is not None
    hand = replace(model, gripper=replace(model.gripper, opening=None, unmeasured="it has 36 joints"))
    assert "measured on the meshes" in robot_scene_text(model, tmp_path)
    written = robot_scene_text(hand, tmp_path)
    assert "guessed" in written and "measured on the meshes" not in written


def test_what_is_written_loads_without_a_finding_and_is_the_same_each_time(tmp_path: Path) -> None:
    texts = []
    for _ in range(2):
        model = make_robot_model(write_arm(tmp_path), None, name="small", epsilon=0.01)
        texts.append(robot_scene_text(model, tmp_path))
    assert texts[0] == texts[1]
    (tmp_path / "written.yaml").write_text(texts[0])
    description = load_scene_description(tmp_path / "written.yaml")
    assert robot_findings(description) == []
    assert description.robots["small"].joints == ("shoulder", "elbow", "turn")


def test_a_home_in_collision_is_an_error_with_the_depth(tmp_path: Path) -> None:
    write_arm(tmp_path)
    (tmp_path / "scene.yaml").write_text(
        "scene: s\nepsilon: 0.01\nrobots:\n  r:\n    urdf: small.urdf\n"
        "    configurations: {home: [0, 0, 0, 0], bent: [0, 1, 0, 0]}\n"
    )
    found = robot_findings(load_scene_description(tmp_path / "scene.yaml"))
    said = 'configuration "{}" of robot "r": "r.left" and "r.right" overlap by at least'
    for name, severity in (("home", "error"), ("bent", "warning")):
        (told,) = [each for each in found if each.message.startswith(said.format(name))]
        assert (told.line, told.severity) == (5, severity)
        assert "allowed_contacts: [[left, right]]" in (told.hint or "")


def test_values_are_rounded_into_their_limits() -> None:
    lower, upper = np.array([-1.0471975, 0.00001, -1.0]), np.array([0.0, 0.00002, 1.0])
    got = rounded_within(np.array([[-2.0, 0.0, 0.123456]]), lower, upper)
    assert got.tolist() == [[-1.0471, 0.00001, 0.1235]]
    assert (got >= lower).all() and (got <= upper).all()


@pytest.mark.slow
@pytest.mark.parametrize("urdf", ["panda_description/urdf/panda.urdf", "ur_description/urdf/ur5_gripper.urdf"])
def test_a_foreign_robot_is_ready(tmp_path: Path, urdf: str) -> None:
    folder = installed_folder("example-robot-data")
    assert folder is not None
    model = make_robot_model(folder / "robots" / urdf, None, name="robot", epsilon=0.01)
    assert model.home is not None
    (tmp_path / "written.yaml").write_text(robot_scene_text(model, tmp_path))
    description = load_scene_description(tmp_path / "written.yaml")
    assert robot_findings(description) == []
    scene = load_scene(description)
    assert not GeometryServer(scene).collides("robot", list(scene.start.robots["robot"]))


@pytest.mark.skipif(installed_folder("example-robot-data") is None, reason="example-robot-data is not installed")
def test_a_robot_of_an_installed_package_is_named_by_its_package() -> None:
    named = "package://example-robot-data/robots/ur_description/urdf/ur5_joint_limited_robot.urdf"
    assert named in robot_scene(named, name="arm")


def test_links_without_their_meshes_are_judged_at_any_precision(cans_scene: Scene) -> None:
    """Where parts are finer than the roots of their trees, surfaces could be asked, and these links have none."""
    robot = cans_scene.robots["arm"]
    rows = np.random.default_rng(0).uniform(robot.tree.lower, robot.tree.upper, (100, robot.tree.size))
    met = {}
    for epsilon in (0.01, 0.004):
        surroundings = SceneSurroundings(cans_scene, Budget.share(epsilon), False, GeometryStatistics())
        pairs = LinkPairs(surroundings, robot)
        met[epsilon] = pairs.any_meeting(rows, pairs.pairs)
    assert 0 < met[0.004].sum() < len(rows)
    assert not (met[0.004] & ~met[0.01]).any()


@pytest.fixture(scope="module")
def cans_scene() -> Scene:
    return load_scene(Path(__file__).parents[2] / "examples" / "two_cans" / "scene.yaml")


def test_a_finger_by_itself_is_an_arm(tmp_path: Path) -> None:
    path = tmp_path / "finger.urdf"
    path.write_text(KNOT.replace('name="a"', 'name="finger_base"').replace('name="b"', 'name="finger_tip"'))
    model = make_robot_model(path, None, name="finger", epsilon=0.01)
    assert (model.hand.arm, model.hand.joints) == (("finger_base", "finger_tip"), ())
