"""Links weigh what their URDF says, where it says so: forces beside those of pinocchio, which reads the file itself."""

from pathlib import Path

import numpy as np
import pinocchio
import pytest

import kabo
from kabo.language.recorded_paths import installed_folder
from kabo.scene import Scene
from kabo.simulation import Physics
from kabo.simulation.bearable import BORNE, GUESSED, PointMasses, bearable_share
from kabo.streams import stream_key, uniforms

mujoco = pytest.importorskip("mujoco")
FOREIGN = installed_folder("example-robot-data")
SCENE = """
scene: weighed
epsilon: 0.01
packages: {{example-robot-data: installed}}
robots:
  arm: {{urdf: "{}", base: {{position: [0.2, -0.1, 0.3], rpy: [0, 0, 40 deg]}}}}
"""
TWO_LINKS = """<robot name="weighed">
  <link name="base"/>
  <link name="near">{}<visual><geometry><box size="0.1 0.1 0.4"/></geometry></visual></link>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="near"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="90"/>
  </joint>
</robot>
"""
INERTIAL = (
    '<inertial><origin xyz="0 0 0.1"/><mass value="{}"/>'
    '<inertia ixx="0.01" iyy="0.01" izz="{}" ixy="0" ixz="0" iyz="0"/></inertial>'
)


def scene_of(urdf: str, folder: Path) -> Scene:
    path = folder / "scene.yaml"
    path.write_text(SCENE.format(urdf))
    return kabo.load_scene(path)


@pytest.mark.skipif(FOREIGN is None, reason="example-robot-data is not installed")
@pytest.mark.parametrize(
    "urdf", ["ur_description/urdf/ur5_joint_limited_robot.urdf", "talos_data/robots/talos_left_arm.urdf"]
)
def test_forces_are_those_that_pinocchio_finds_in_the_same_file(urdf: str, tmp_path: Path) -> None:
    assert FOREIGN is not None
    physics = Physics(scene_of(f"package://example-robot-data/robots/{urdf}", tmp_path))
    robot = physics.scene.robots["arm"]
    oracle = pinocchio.buildModelFromUrdf(str(FOREIGN / "robots" / urdf))
    data, order = oracle.createData(), [oracle.joints[oracle.getJointId(name)].idx_q for name in robot.joint_names]
    for row in uniforms(stream_key("weighed", urdf), 0, 10, robot.tree.size):
        physics.place({"arm": tuple((4.0 * row - 2.0).tolist())})
        q = np.zeros(oracle.nq)
        q[order] = 4.0 * row - 2.0
        borne = pinocchio.computeGeneralizedGravity(oracle, data, q)[order]
        rates = physics._own["arm"][1]
        assert np.allclose(physics.data.qfrc_bias[rates], borne, atol=1e-4)
        inertia = np.zeros((physics.model.nv, physics.model.nv))
        mujoco.mj_fullM(physics.model, physics.data, inertia)
        found = inertia[np.ix_(rates, rates)] - np.diag(physics.model.dof_armature[rates])
        assert np.allclose(found, pinocchio.crba(oracle, data, q)[np.ix_(order, order)], atol=1e-4)


@pytest.mark.parametrize(
    ("inertial", "weight"),
    [
        (INERTIAL.format("2.5", "0.01"), 2.5),
        ("", None),
        (INERTIAL.format("0", "0"), None),
        (INERTIAL.format("-1", "0.01"), None),
        (INERTIAL.format("nan", "0.01"), None),
        (INERTIAL.format("heavy", "0.01"), None),
        (INERTIAL.format("2.5", "inf"), None),
        ('<inertial><mass value="2.5"/></inertial>', None),
        ("<inertial/>", None),
    ],
)
def test_an_inertia_that_cannot_be_is_guessed_from_the_shape(
    inertial: str, weight: float | None, tmp_path: Path
) -> None:
    guessed = 0.1 * 0.1 * 0.4  # [m³]
    (tmp_path / "robot.urdf").write_text(TWO_LINKS.format(inertial))
    physics = Physics(scene_of("robot.urdf", tmp_path))
    mass = float(physics.model.body("arm:turn").mass[0])
    density = physics.settings.link_density
    assert mass == pytest.approx(guessed * density if weight is None else weight)


@pytest.mark.parametrize("heavy", [0.0, 1.0, 5.0, 500.0])
def test_guessed_links_keep_a_weight_where_given_ones_are_too_heavy_for_a_motor(heavy: float) -> None:
    """A hand that its URDF makes too heavy for a wrist is no reason to take the upper arm for a feather."""
    robot = kabo.load_scene(Path(__file__).parents[2] / "domains/bartender/four_bottles.yaml").robots["left"]
    joints = robot.model.njoints
    masses, guessed = np.ones(joints), np.ones(joints, bool)
    masses[-1], guessed[-1] = heavy, False
    share = bearable_share(robot, PointMasses(masses, np.zeros((joints, 3)), guessed))
    alone = bearable_share(robot, PointMasses(np.where(guessed, masses, 0.0), np.zeros((joints, 3)), guessed))
    assert GUESSED / BORNE * alone * (1.0 - 1e-12) <= share <= alone
