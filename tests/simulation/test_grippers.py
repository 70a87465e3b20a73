"""Hands of several kinds press with the force that the scene says, and hold by friction while they lift."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution.motions import Motion, Stretch
from kabo.motion import Trajectory
from kabo.scene import Scene
from kabo.simulation import Physics, SimulatedRobot
from tests.support.grippers import BOX, GRIPPERS

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


def settled(scene: Scene, lift: float, then: Callable[[Physics], None], seconds: float = 0.5) -> Physics:
    """The physics of a lifter whose open hand is at a height, a moment after something was done."""
    own = scene.robots["arm"]
    assert own.gripper is not None
    physics = Physics(scene)
    physics.place({"arm": tuple({"lift": lift, **own.gripper.open}[name] for name in own.joint_names)})
    then(physics)
    for _ in range(round(seconds / physics.settings.timestep)):
        physics.step()
    return physics


@pytest.mark.parametrize("permitted", [True, False])
def test_a_zone_around_a_hand_is_no_thing_for_what_the_scene_permits_in_it(
    permitted: bool, tmp_path: Path
) -> None:
    """Such a link has a shape for collisions alone, where others have one to be seen, as TIAGo's box around its hand."""
    path, urdf = GRIPPERS["sliding"]().write(tmp_path), tmp_path / "lifter.urdf"
    around = BOX.format(place="0 0 -0.06", size="0.1 0.14 0.1")
    zone = f"""<link name="zone">{around}</link>
  <joint name="zone_joint" type="fixed"><parent link="palm"/><child link="zone"/></joint>"""
    seen = "<visual><geometry><box size='0.02 0.02 0.02'/></geometry></visual>"
    names = ("palm", "left", "right")
    text = urdf.read_text().replace("</robot>", f"{zone}</robot>")
    for name in names:
        text = text.replace(f'<link name="{name}">', f'<link name="{name}">{seen}')
    urdf.write_text(text)
    others = ("table", "arm.left", "arm.right", *(("block",) if permitted else ()))
    allowed = "".join(f"  - [arm.zone, {other}]\n" for other in others)
    path.write_text(f"{path.read_text()}allowed_contacts:\n{allowed}")
    scene = kabo.load_scene(path)
    assert [name for name, link in scene.robots["arm"].links.items() if link.is_zone] == ["zone"]
    physics = settled(scene, -0.49, lambda _: None, 0.002)
    assert (("arm.zone", "block") in {each.things for each in physics.contacts()}) is not permitted


def test_joints_that_a_grasp_does_not_move_stay_where_they_are(tmp_path: Path) -> None:
    scene = kabo.load_scene(GRIPPERS["independent"]().write(tmp_path))

    def close(physics: Physics) -> None:
        physics.command("arm", ("left_joint",), np.array([0.025]), np.zeros(1), np.zeros(1))
        physics.grip("arm", (), force=20.0)

    physics = settled(scene, 0.2, close)
    left, right = (physics.data.joint(f"arm:{side}_joint").qpos[0] for side in ("left", "right"))
    assert left < 0.001
    assert right == pytest.approx(0.03, abs=1e-4)


def test_a_finger_that_a_grasp_does_not_move_does_not_give_way_to_what_the_other_presses(tmp_path: Path) -> None:
    scene = kabo.load_scene(GRIPPERS["independent"]().write(tmp_path))

    def close(physics: Physics) -> None:
        physics.command("arm", ("left_joint",), np.array([0.025]), np.zeros(1), np.zeros(1))
        physics.grip("arm", ("block",), force=20.0)

    physics = settled(scene, -0.49, close, 1.0)
    assert pressed(physics, "block") == pytest.approx(20.0, rel=0.1, abs=2.5)
    assert physics.data.joint("arm:right_joint").qpos[0] == pytest.approx(0.03, abs=3e-4)


def test_a_finger_that_meets_nothing_stops_at_the_end_of_its_joint(tmp_path: Path) -> None:
    scene = kabo.load_scene(GRIPPERS["independent"]().write(tmp_path))

    def close(physics: Physics) -> None:
        physics.command("arm", ("left_joint",), np.array([0.025]), np.zeros(1), np.zeros(1))
        physics.grip("arm", (), force=60.0)

    assert settled(scene, 0.2, close).data.joint("arm:left_joint").qpos[0] == pytest.approx(0.0, abs=5e-4)
