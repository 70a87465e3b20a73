"""Mates that hold: parts that have come together stay so in physics, whatever is below them, and the others do not."""

from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.errors import InputError
from kabo.scene import Scene
from kabo.simulation import SimulatedRobot
from kabo.simulation.joined_parts import holding_mates, joined
from tests.planner.gantry import gantry

pytest.importorskip("mujoco")

POST = """models:
  post:
    box: [0.04, 0.04, 0.4]
    features:
      hook: {point: [0, 0.041, 0.1]}
      axis: {line: {through: [0, 0.041, 0], along: [0, 0, 1]}}
      x_axis: {line: {through: [0, 0.041, 0.1], along: [1, 0, 0]}}
"""
MATES = """mates:
  hung:
    moving: cube
    fixed: post
    constraints:
      - coincident(moving.center, fixed.hook)
      - aligned(moving.axis, fixed.axis)
      - parallel(moving.x_axis, fixed.x_axis)
"""
OBJECTS = """objects:
  post: {model: post, movable: false, pose: {position: [0.2, -0.041, 0.2]}}
"""


def scene(folder: Path, height: float, holds: str | None = "true") -> Scene:
    """A cube in the air beside a post, at which it is hung at a height of 0.3 m; `second` lies on the table."""
    things = {"cube": (0.2, 0.0, height), "second": (-0.2, 0.3, 0.02)}
    path = gantry(folder, things=things, goal="K(at(second, shelf))").with_name("scene.yaml")
    text = path.read_text().replace("models:\n", POST).replace("objects:\n", MATES + "objects:\n")
    if holds is not None:
        text = text.replace("fixed: post\n", f"fixed: post\n    holds: {holds}\n")
    text = text.replace("objects:\n", OBJECTS)
    path.write_text(text)
    return kabo.load_scene(path.with_name("problem.yaml"))


@pytest.mark.parametrize(
    ("holds", "height", "stays"),
    [("true", 0.3, True), ("false", 0.3, False), (None, 0.3, False), ("true", 0.305, False)],
)
def test_what_has_come_into_a_mate_that_holds_stays_there(
    holds: str | None, height: float, stays: bool, tmp_path: Path
) -> None:
    robot = SimulatedRobot(scene(tmp_path, height, holds))
    robot.wait(0.5)
    where = robot.poses()["cube"][:3, 3]
    assert bool(abs(where[2] - height) < 1e-3) == stays
    assert stays or where[2] < 0.1, "it lies on the table"
    assert robot.poses()["second"][2, 3] == pytest.approx(0.02, abs=1e-3)


def test_what_comes_there_later_is_held_from_where_the_hand_lets_it_go(tmp_path: Path) -> None:
    robot = SimulatedRobot(scene(tmp_path, 0.02))
    robot.physics.displace("cube", np.array([0.0, 5e-4, 0.2805]))
    robot.release("gantry", ("second",))
    assert robot.physics.data.eq_active[robot.physics.model.equality("post:cube").id] == 0, "it was not let go of"
    assert not robot.joined
    robot.release("gantry", ("cube",))
    assert robot.joined == {frozenset(("post", "cube"))}
    robot.wait(0.5)
    assert robot.poses()["cube"][:3, 3] == pytest.approx([0.2, 5e-4, 0.3005], abs=5e-4)


def test_pairs_are_those_whose_models_the_mate_names(tmp_path: Path) -> None:
    made = scene(tmp_path, 0.3)
    assert {(moving, fixed) for _, moving, fixed in holding_mates(made)} == {("cube", "post"), ("second", "post")}
    poses = {name: SimulatedRobot(made).physics.pose(name) for name in ("cube", "second", "post")}
    assert list(joined(made, ("cube",), poses.__getitem__)) == [("post", "cube")]
    assert list(joined(made, ("second",), poses.__getitem__)) == []
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    poses["cube"] = poses["cube"].copy()
    poses["cube"][:3, :3] = turn
    assert list(joined(made, ("cube",), poses.__getitem__)) == [], "it is turned by a right angle"


def test_whether_a_mate_holds_is_true_or_false(tmp_path: Path) -> None:
    with pytest.raises(InputError, match='whether a mate holds must be true or false, not "often"'):
        scene(tmp_path, 0.3, "often")


def test_what_is_taken_off_a_mate_falls_though_it_rested(tmp_path: Path) -> None:
    robot = SimulatedRobot(scene(tmp_path, 0.3))
    robot.wait(0.5)
    robot.physics.unweld("post", "cube")
    robot.wait(0.5)
    assert robot.poses()["cube"][2, 3] < 0.1
