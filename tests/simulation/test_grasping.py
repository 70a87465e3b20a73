"""What hands do in physics: fingers that are coupled close to the middle, and joined parts are not pressed."""

from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution.motions import _hand_actions
from kabo.plan import Segment
from kabo.scene import Scene
from kabo.simulation import Physics, SimulatedRobot

pytest.importorskip("mujoco")
DOMAINS = Path(__file__).parents[2] / "domains"


@pytest.fixture(scope="module")
def scene() -> Scene:
    return kabo.load_scene(DOMAINS / "inspection" / "three_boxes_covered.yaml")


def test_fingers_that_are_coupled_stay_so_under_the_force_of_the_hand(scene: Scene) -> None:
    physics = Physics(scene)
    physics.grip("arm", (), force=100.0)
    for _ in range(1500):
        physics.step()
    left, right = (physics.data.joint(f"arm:{name}").qpos[0] for name in ("finger_joint", "finger_joint_2"))
    assert abs(left) < 0.002  # the fingers have met
    assert left == pytest.approx(right, abs=1e-4)


def test_a_hand_that_closes_where_nothing_is_does_not_bear_what_is_elsewhere(scene: Scene) -> None:
    """On a lever of 30 m it would throw the arm away."""
    robot = SimulatedRobot(scene)
    before = np.array(robot.state().positions["arm"])
    robot.physics.displace("box_1", np.array([30.0, 0.0, 0.0]))
    robot.grip("arm", ("box_1",))
    robot.wait(0.3)
    count = scene.robots["arm"].planned
    assert np.abs(np.array(robot.state().positions["arm"]) - before)[:count].max() < 1e-3
    assert robot.held_by("arm") == ()


def test_a_body_that_falls_over_by_itself_is_told(tmp_path: Path) -> None:
    """The panel stands on its foot; on the side across it topples, as its handle is heavy."""
    text = (DOMAINS / "inspection" / "three_boxes.yaml").read_text()
    headlong = text.replace("-90 deg", "90 deg").replace("scene.yaml", f"{DOMAINS}/inspection/scene.yaml")
    assert headlong.count("90 deg") == 1
    (tmp_path / "headlong.yaml").write_text(headlong.replace("domain.yaml", f"{DOMAINS}/inspection/domain.yaml"))
    assert SimulatedRobot(kabo.load_scene(DOMAINS / "inspection" / "three_boxes.yaml")).doubts == ()
    (told,) = SimulatedRobot(kabo.load_scene(tmp_path / "headlong.yaml")).doubts
    assert told.startswith("panel does not stay where it is put: gravity has moved it by")


def test_a_part_that_is_joined_to_another_is_not_gripped(scene: Scene) -> None:
    def actions(attach: tuple[tuple[str, str], ...], detach: tuple[str, ...] = ()) -> list[str]:
        segment = Segment(
            "arm", ("joint_1",), ((0.0,), (0.1,)), (0.0, 1.0), "insert", attach=attach, detach=detach
        )
        return [each.kind for each in _hand_actions("n0", [segment], 0.0, scene)]

    assert actions((("box_1", "arm.tool0"),)) == ["grip"]
    assert actions((("box_1", "box_2"),), ("box_1",)) == ["release", "detach"]
    assert actions((("box_1", "box_2"),)) == ["detach"]
