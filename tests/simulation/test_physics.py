"""The model of physics beside what is known without it: places by pinocchio, masses by trimesh, forces by statics."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

import kabo
from kabo.scene import Scene, link_poses
from kabo.simulation import Physics, physics_model
from kabo.simulation.masses import of_mesh
from kabo.streams import stream_key, uniforms

mujoco = pytest.importorskip("mujoco")
DOMAINS = Path(__file__).parents[2] / "domains"
PANDA = """
scene: panda
epsilon: 0.01
packages: {example-robot-data: installed}
robots:
  arm:
    urdf: package://example-robot-data/robots/panda_description/urdf/panda.urdf
    base: {position: [0.2, -0.1, 0.3], rpy: [0, 0, 40 deg]}
    joints: [panda_joint1, panda_joint2, panda_joint3, panda_joint4, panda_joint5, panda_joint6, panda_joint7]
    gripper:
      joints: [panda_finger_joint1]
      open: {panda_finger_joint1: 0.04}
      closed: {panda_finger_joint1: 0.0}
      touch_links: [panda_leftfinger, panda_rightfinger]
      force: 30
    configurations:
      home: [0, -0.6, 0, -2.2, 0, 1.7, 0.8]
objects:
  floor: {box: [2, 2, 0.1], pose: {position: [0, 0, -0.05]}}
"""


def scene_of(name: str, folder: Path) -> Scene:
    if name != "panda":
        return kabo.load_scene(DOMAINS / name)
    (folder / "scene.yaml").write_text(PANDA)
    return kabo.load_scene(folder / "scene.yaml")


@pytest.mark.parametrize("name", ["panda", "bartender/four_bottles.yaml", "waiter/two_cups.yaml"])
def test_links_are_where_pinocchio_has_them(name: str, tmp_path: Path) -> None:
    scene = scene_of(name, tmp_path)
    physics = Physics(scene)
    for robot in scene.robots.values():
        drawn = uniforms(stream_key("physics", name, robot.name), 0, 20, robot.tree.size)
        low, high = np.maximum(robot.tree.lower, -3.0), np.minimum(robot.tree.upper, 3.0)
        for row in low + drawn * (high - low):
            physics.place({robot.name: tuple(row.tolist())})
            assert np.allclose(physics.configuration(robot.name), row, atol=1e-9)
            for link, pose in link_poses(robot, row).items():
                assert np.allclose(physics.pose(f"{robot.name}.{link}"), pose, atol=1e-7), link


def test_bodies_are_where_the_scene_has_them_with_their_masses(tmp_path: Path) -> None:
    scene = scene_of("bartender/four_bottles.yaml", tmp_path)
    physics = Physics(scene)
    for name in scene.movable:
        assert np.allclose(physics.pose(name)[:3, 3], scene.start.objects[name].position, atol=1e-9)
        assert physics.model.body(name).mass[0] == pytest.approx(scene.bodies[name].mass)


@pytest.mark.parametrize(
    "shape", [trimesh.creation.box((0.1, 0.2, 0.3)), trimesh.creation.annulus(0.02, 0.05, 0.1)]
)
def test_masses_of_meshes_are_those_of_trimesh(shape: trimesh.Trimesh) -> None:
    shape.apply_transform(trimesh.transformations.random_rotation_matrix(rand=np.array([0.1, 0.5, 0.9])))
    shape.apply_translation([0.3, -0.2, 0.1])
    found = of_mesh(kabo.Mesh(np.asarray(shape.vertices), np.asarray(shape.faces)), 700.0)
    shape.density = 700.0
    assert found is not None
    assert found.mass == pytest.approx(shape.mass)
    assert np.allclose(found.centre, shape.center_mass)
    assert np.allclose(found.inertia, shape.moment_inertia, rtol=1e-9, atol=1e-12)


def test_the_model_needs_no_file_beside_it(tmp_path: Path) -> None:
    model = physics_model(scene_of("panda", tmp_path))
    (tmp_path / "model.xml").write_text(model.xml)
    loaded = mujoco.MjModel.from_xml_path(str(tmp_path / "model.xml"))
    assert loaded.nu == len(model.motors) == 8
    finger = next(motor for motor in model.motors if motor.gripper)
    assert [name for name, _, _ in finger.followers] == ["arm:panda_finger_joint2"]
    names = {loaded.geom(k).name for k in range(loaded.ngeom)}
    assert names == set(model.things)


def test_an_arm_stands_still_against_gravity_and_its_hand_presses_with_its_force(tmp_path: Path) -> None:
    scene = scene_of("panda", tmp_path)
    physics = Physics(scene)
    before = physics.configuration("arm")
    for _ in range(300):
        physics.step()
    assert np.allclose(physics.configuration("arm")[:7], before[:7], atol=1e-4)
    physics.grip("arm")
    for _ in range(1500):
        physics.step()
    left = physics.configuration("arm")[7]
    assert left < 0.002  # nothing was between the fingers
    assert physics.pressing("arm") == 30.0


@pytest.mark.parametrize("seed", range(3))
def test_an_arm_that_is_far_from_its_setpoint_comes_back_and_rests(seed: int) -> None:
    """A correction that asks for more than all motors have swung the arm for ever."""
    scene = kabo.load_scene(Path(__file__).parents[2] / "examples" / "two_cans" / "scene.yaml")
    physics, robot = Physics(scene), scene.robots["arm"]
    places = physics._own["arm"][0][: robot.planned]
    wanted = physics.data.qpos[places].copy()
    physics.data.qpos[places] += np.random.default_rng(seed).uniform(-0.6, 0.6, robot.planned)
    for _ in range(4000):
        physics.step()
    assert np.abs(physics.data.qpos[places] - wanted).max() < 1e-3
    assert np.abs(physics.velocities("arm")).max() < 1e-3
