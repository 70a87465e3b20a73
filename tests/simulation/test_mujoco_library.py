"""Bodies that rest are not simulated; whatever is done to them, they move as if they had been."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.scene import Scene
from kabo.simulation import Physics

mujoco = pytest.importorskip("mujoco")
SCENE = """
scene: tower
epsilon: 0.01
robots:
  arm: {urdf: %s, base: {position: [1, 0, 0]}, configurations: {home: [0, 0, 0, 0, 0, 0]}}
objects:
  floor: {box: [4, 4, 0.1], pose: {position: [0, 0, -0.05]}}
  low: {box: [0.1, 0.1, 0.1], pose: {position: [0, 0, 0.05]}, movable: true, mass: 0.5}
  high: {box: [0.1, 0.1, 0.1], pose: {position: [0, 0, 0.15]}, movable: true, mass: 0.5}
  aside: {box: [0.1, 0.1, 0.1], pose: {position: [-1, 0, 0.05]}, movable: true, mass: 0.5}
"""
SECOND = 1000  # steps


def pushed_by_force(physics: Physics) -> None:
    physics.data.xfrc_applied[physics.model.body("aside").id, 0] = 6.0


def pushed_by_speed(physics: Physics) -> None:
    physics.data.qvel[physics.model.joint("aside").dofadr[0]] = 1.0


def pulled_out(physics: Physics) -> None:
    """What is below is gone: what stands on it falls."""
    start = physics.model.joint("low").qposadr[0]
    physics.data.qpos[start] += 0.5


def lifted(physics: Physics) -> None:
    physics.displace("high", np.array([0.0, 0.0, 0.2]))


def dropped_on(physics: Physics) -> None:
    """Something falls onto what rests, beside its middle."""
    physics.displace("high", np.array([-0.97, 0.03, 0.3]))


DONE = {
    pushed_by_force: {"aside": 0.1},
    pushed_by_speed: {"aside": 0.02},
    pulled_out: {"low": 0.4, "high": 0.09},
    lifted: {},
    dropped_on: {"high": 0.9},
}


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    path = tmp_path_factory.mktemp("tower") / "scene.yaml"
    path.write_text(SCENE % (Path(__file__).parents[2] / "meshes/arm6/arm6.urdf"))
    return kabo.load_scene(path)


def rested(scene: Scene) -> Physics:
    physics = Physics(scene)
    for _ in range(SECOND):
        physics.step()
    return physics


def test_bodies_that_rest_are_not_simulated(scene: Scene) -> None:
    physics = rested(scene)
    if hasattr(mujoco.mjtEnableBit, "mjENBL_SLEEP"):  # MuJoCo 3.4
        awake = {physics.model.body(k).name for k in np.flatnonzero(physics.data.body_awake == 1)}
        assert awake and all(name.startswith(("arm:", "arm.")) for name in awake)


@pytest.mark.parametrize("act", DONE, ids=lambda act: act.__name__)
def test_what_rests_moves_when_something_is_done_to_it(scene: Scene, act: Callable[[Physics], None]) -> None:
    physics = rested(scene)
    before = {name: physics.pose(name) for name in scene.movable}
    act(physics)
    for _ in range(SECOND):
        physics.step()
    after = {name: physics.pose(name) for name in scene.movable}
    for name in scene.movable:
        moved = np.linalg.norm(after[name][:3, 3] - before[name][:3, 3])
        if name in DONE[act]:
            assert moved > DONE[act][name], name
    heights = {name: after[name][2, 3] for name in scene.movable}
    assert all(height < 0.17 for height in heights.values()), "nothing hangs in the air"


def test_a_run_with_sleeping_bodies_ends_where_one_without_ends(scene: Scene) -> None:
    """The same push, with and without sleep."""
    ends = []
    for sleeps in (True, False):
        physics = rested(scene)
        if not sleeps:
            physics.model.opt.enableflags = 0
        pushed_by_speed(physics)
        for _ in range(SECOND):
            physics.step()
        ends.append(np.array([physics.pose(name)[:3, 3] for name in scene.movable]))
    assert np.abs(ends[0] - ends[1]).max() < 1e-4


def test_bodies_that_rest_touch_what_they_stand_on(scene: Scene) -> None:
    """MuJoCo keeps no contacts of bodies that sleep; a sensor of contact sees them all the same."""
    physics = rested(scene)
    standing = {("floor", "low"), ("high", "low"), ("aside", "floor")}
    assert {contact.things for contact in physics.contacts()} == standing
    physics.displace("high", np.array([0.0, 0.0, 0.2]))
    assert {contact.things for contact in physics.contacts()} == standing - {("high", "low")}
    for _ in range(SECOND):
        physics.step()
    assert {contact.things for contact in physics.contacts()} == standing
