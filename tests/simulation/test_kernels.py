"""The kernels of physics beside MuJoCo's own functions, and beside the same in numpy."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.arrays import Array
from kabo.execution.kernels.origins import origins_of
from kabo.execution.link_origins import LinkOrigins
from kabo.scene import link_poses
from kabo.simulation import Physics
from kabo.simulation.kernels.bias import add_point_mass, bias
from kabo.simulation.kernels.friction import Contacts, complete_friction
from kabo.simulation.kernels.motors import Joints, Pressing, drive, press
from kabo.streams import stream_key, uniforms

mujoco = pytest.importorskip("mujoco")
DOMAINS = Path(__file__).parents[2] / "domains"


def drawn(name: str, count: int, rows: int = 1) -> Array:
    """Numbers from -1 to 1 (rows, count)."""
    return 2.0 * uniforms(stream_key("kernels", name), 0, rows, count) - 1.0


@pytest.fixture(scope="module")
def moving() -> Physics:
    """Two arms and four bottles, somewhere, all in motion."""
    physics = Physics(kabo.load_scene(DOMAINS / "bartender" / "four_bottles.yaml"))
    data, model = physics.data, physics.model
    data.qvel[:] = drawn("velocities", model.nv)[0]
    data.qpos[physics._values] += 0.4 * drawn("values", len(physics._values))[0]
    mujoco.mj_step1(model, data)
    return physics


def test_the_bias_and_the_load_of_a_point_are_those_of_mujoco(moving: Physics) -> None:
    model, data, scratch, jacobian = moving.model, moving.data, np.empty((6, 3)), np.zeros((3, moving.model.nv))
    wanted, gravity = drawn("wanted", model.nv)[0], np.array(model.opt.gravity)
    for body in range(model.nbody):
        own = 0.1 * drawn(f"place {body}", 3)[0]
        place = data.xpos[body] + data.xmat[body].reshape(3, 3) @ own
        mujoco.mj_jacDot(model, data, jacobian, None, place, body)
        expected = jacobian @ data.qvel
        bias(body, place, moving._tree, moving._moving, scratch)
        assert np.allclose(scratch[0], expected, atol=1e-12)
        mujoco.mj_jac(model, data, jacobian, None, place, body)
        torques = np.zeros(model.nv)
        add_point_mass(body, own, 0.3, wanted, gravity, moving._tree, moving._moving, scratch, torques)
        assert np.allclose(torques, (0.3 * (jacobian @ wanted + expected - gravity)) @ jacobian, atol=1e-12)


def test_what_presses_gets_the_force_of_its_hand_and_the_rest_what_it_had() -> None:
    """The first of two motors moves joints 4 and 1 with shares of its torque; the second one holds its setpoint."""
    pressing = Pressing(np.array([4, 1]), np.array([3, 0]), np.array([0, 0]), np.array([0.5, 0.25]))
    levers, dampings, rates = np.array([2.0, 9.0]), np.array([0.1, 0.7]), np.array([3, 2])
    velocities, bias_, passive, torques = (
        np.array([1.0, 2.0, 3.0, 4.0]),
        np.arange(4.0),
        np.ones(4),
        np.full(5, -1.0),
    )
    for function in (press, press.py_func):
        function(pressing, levers, 10.0, dampings, rates, velocities, bias_, passive, torques)
        torque = 2.0 * 10.0 - 0.1 * 4.0
        assert torques.tolist() == [-1.0, 0.0 - 1.0 + 0.25 * torque, -1.0, -1.0, 3.0 - 1.0 + 0.5 * torque]


def test_contacts_of_a_hand_get_the_bias_that_mujoco_leaves_out(moving: Physics) -> None:
    """Contacts are made up: one of a finger and a bottle, one of a bottle and the table, one that has no rows."""
    model, data, touches = moving.model, moving.data, moving._touches
    hand, free = touches.hand[touches.body], touches.free[touches.body]
    geoms = [int(np.flatnonzero(chosen)[0]) for chosen in (hand == 0, free == 1, (hand < 0) & (free == 0))]
    finger, bottle = int(touches.body[geoms[0]]), int(touches.body[geoms[1]])
    pairs = np.array([[geoms[0], geoms[1]], [geoms[2], geoms[1]], [geoms[0], geoms[1]]], np.int32)
    places, frame = drawn("places", 3, 3), np.linalg.qr(drawn("frame", 3, 3))[0]
    contacts = Contacts(
        pairs, places, np.tile(frame.ravel(), (3, 1)), np.array([0, 4, -1], np.int32), np.full(3, 4, np.int32)
    )
    reference, impedance, step = np.zeros(8), np.full((8, 4), 100.0), moving.settings.timestep
    for presses in (0, 1):
        given = contacts, touches, np.array([presses, 0]), moving._tree, moving._moving, reference, impedance, step
        complete_friction(*given)
        if not presses:
            assert (reference == 0.0).all()
    off, turn = np.zeros(3), np.zeros(3)
    for body, sign in ((bottle, 1.0), (finger, -1.0)):
        jacobian, turning = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        mujoco.mj_jacDot(model, data, jacobian, turning, places[0], body)
        off += sign * (jacobian @ data.qvel)
        turn += sign * (turning @ data.qvel)
    share = 1.0 - 0.5 * step * 100.0
    assert np.allclose(reference[:3], -share * (frame @ off), atol=1e-12)
    assert abs(frame[0] @ turn) > 0.05
    assert reference[3] == pytest.approx(-share * frame[0] @ turn, abs=1e-12)  # about the normal
    assert (reference[4:] == 0.0).all()


def test_joints_that_share_a_motor_share_its_limit() -> None:
    none = np.zeros(3, np.int64)
    joints = Joints(none, np.array([0, 1, 2]), np.array([0, 1, 0]), np.array([1.0, 1.0, -0.5]), np.zeros(3))
    control, applied = np.zeros(2), np.zeros(4)
    drive(joints, np.array([3.0, 1.0, -2.0]), np.array([2.0, np.inf]), np.array([1.0, 1.0]), control, applied)
    assert control.tolist() == [1.5, 1.0]  # the motor of joints 0 and 2 would have to give 4
    assert applied.tolist() == [0.0, 0.0, -1.0, 0.0]


def test_origins_of_links_are_those_of_pinocchio() -> None:
    scene = kabo.load_scene(DOMAINS / "bartender" / "four_bottles.yaml")
    robot = scene.robots["left"]
    rows = drawn("configurations", robot.tree.size, 20)
    own = LinkOrigins.of(robot)
    expected = np.array([[pose[:3, 3] for pose in map(link_poses(robot, row).get, robot.links)] for row in rows])
    assert np.allclose(own.at(rows), expected, atol=1e-12)
    assert np.allclose(origins_of.py_func(rows[:2], own.tree, own.joints, own.offsets), expected[:2], atol=1e-12)
    wanted, actual = rows[1:4].copy(), rows[0]
    wanted[:, robot.planned :] = actual[robot.planned :]  # hands are where they are
    there = np.array([[pose[:3, 3] for pose in map(link_poses(robot, row).get, robot.links)] for row in wanted])
    off = np.linalg.norm(there - expected[0], axis=2).max(axis=1)
    assert own.farthest(rows[1:4], tuple(actual)) == pytest.approx(off, abs=1e-12)


def test_what_is_called_while_robots_move_is_loaded_before() -> None:
    """On a machine where nothing was compiled, a robot server was silent for too long when its hand closed first."""
    program = """
import sys
from pathlib import Path
import kabo
from kabo.execution import KnownTruth, execute
from kabo.simulation import SimulatedRobot

def loaded():
    rooms = [room for name, room in sys.modules.items() if name.startswith("kabo.simulation.kernels.")]
    return {(name, str(each)) for room in rooms for name, made in vars(room).items()
            for each in getattr(made, "signatures", ())}

problem = kabo.load_problem(Path("domains/stacked/n2.yaml"))
plan, scene = kabo.solve(problem).plan, kabo.load_scene(problem.scene)
robot = SimulatedRobot(scene)
robot.wait(0.01)
before = loaded()
assert execute(plan, scene, robot, KnownTruth(poses=robot.poses)).reached_goal
print(len(before) > 0, loaded() == before)
"""
    repository = DOMAINS.parent
    made = subprocess.run(
        [sys.executable, "-c", program], cwd=repository, capture_output=True, text=True, check=True
    )
    assert made.stdout.split() == ["True", "True"], made.stderr
