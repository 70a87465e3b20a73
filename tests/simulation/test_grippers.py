"""Hands of several kinds press with the force that the scene says, and hold by friction while they lift."""

from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution.motions import Motion, Stretch
from kabo.motion import Trajectory
from kabo.simulation import Physics, SimulatedRobot
from tests.support.grippers import GRIPPERS

mujoco = pytest.importorskip("mujoco")


def pressed(physics: Physics, body: str) -> float:
    """The sum of the normal forces between links and a body [N]."""
    found, total = np.zeros(6), 0.0
    for number in range(physics.data.ncon):
        contact = physics.data.contact[number]
        things = {physics.model.geom(k).name.partition("#")[0] for k in (contact.geom1, contact.geom2)}
        if body in things and any(thing.startswith("arm.") for thing in things):
            mujoco.mj_contactForce(physics.model, physics.data, number, found)
            total += float(found[0])
    return total


def raising(start: float, end: float) -> Trajectory:
    """A motion of the joint `lift` within a second, from rest to rest."""
    way = end - start
    return Trajectory(
        ("lift",), ((start,), (end,)), (0.0, 1.0), (((start, 0.0, 0.0, 10.0 * way, -15.0 * way, 6.0 * way),),)
    )


@pytest.mark.parametrize("force", [12.0, 60.0])
@pytest.mark.parametrize("kind", GRIPPERS)
def test_a_hand_presses_with_its_force_and_holds_what_it_lifts(kind: str, force: float, tmp_path: Path) -> None:
    scene = kabo.load_scene(GRIPPERS[kind]().write(tmp_path, force))
    own = scene.robots["arm"]
    names, gripper = own.joint_names, own.gripper
    assert gripper is not None
    q = tuple({"lift": -0.49, **gripper.open}[name] for name in names)
    robot = SimulatedRobot(scene, start=scene.start.replace({"arm": q}))
    robot.grip("arm", ("block",))
    robot.wait(0.6)
    before = robot.poses()["block"]
    assert pressed(robot.physics, "block") == pytest.approx(
        force, rel=0.1, abs=2.5
    )  # friction on the table bears up to 2.4 N
    trajectory = raising(-0.49, -0.2)
    robot.follow(Motion((Stretch("n0", 0, "arm", trajectory),), (), ("n0",), 0.0, 1.0))
    while robot.state().moving:
        robot.wait(0.01)
    robot.wait(0.2)
    risen = robot.poses()["block"][:3, 3] - before[:3, 3]
    assert risen == pytest.approx([0.0, 0.0, 0.29], abs=0.002)
