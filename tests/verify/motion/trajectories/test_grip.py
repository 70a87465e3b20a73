"""What is held must not slip: exact accelerations, and bounds that no moment exceeds."""

import numpy as np
import pytest

from kabo.language import load_problem
from kabo.scene import load_scene
from kabo.verify import verify_plan
from kabo.verify.motion.arms import Arm, Mount
from kabo.verify.motion.trajectories.curves import Curve
from kabo.verify.motion.trajectories.grip import GRAVITY, _Carried
from tests.verify import bench
from tests.verify.smooth import smooth

SCENES = (
    "domains/bartender/four_bottles.yaml",
    "domains/waiter/two_cups.yaml",
)  # an arm; a base, a torso and an arm


def robots(path: str):
    problem = load_problem(path)
    assert problem.scene is not None
    return load_scene(problem.scene).robots


@pytest.fixture(params=SCENES)
def carried(request) -> tuple[_Carried, Arm, Mount]:
    """A point in a hand that follows a random quintic."""
    robot = next(iter(robots(request.param).values()))
    arm, rng = Arm(robot), np.random.default_rng(7)
    held = np.eye(4)
    held[:3, 3] = 0.05, -0.02, 0.1
    assert robot.tool is not None
    mount = arm.mounts[robot.tool.frame].carrying(held)
    own = list(range(robot.planned))
    still = np.zeros(len(robot.joint_names))
    curve = Curve(np.array([0.0, 1.1]), rng.uniform(-0.4, 0.4, (1, robot.planned, 6)))
    return _Carried(arm, mount, curve, still, own), arm, mount


def places(carried: _Carried, times: np.ndarray) -> np.ndarray:
    """The positions of the held origin (T, 3) at times."""
    rows = np.tile(carried.still, (len(times), 1))
    rows[:, carried.columns] = carried.curve.at(times)
    return np.array([carried.arm.pose(q.tolist(), carried.mount)[:3, 3] for q in rows])


def test_accelerations_are_second_differences_of_positions(carried):
    own, _, _ = carried
    for time in (0.1, 0.35, 0.9):
        steps = time + 1e-4 * np.array([-1.0, 0.0, 1.0])
        before, here, after = places(own, steps)
        rate = (before - 2.0 * here + after) / 1e-8
        found = own._shares(np.array([time]), 1.0)[0]
        assert found == pytest.approx(float(np.linalg.norm(rate - GRAVITY)), rel=1e-5)


def test_no_moment_needs_more_than_the_greatest_share_and_some_moment_as_much(carried):
    own, _, _ = carried
    share, time, sure = own.greatest(20.0, 0.0)
    sampled = own._shares(np.linspace(0.0, 1.1, 3001), 20.0)
    assert sure and share >= sampled.max() * (1.0 - 1e-3) and share == pytest.approx(sampled.max(), rel=2e-3)
    assert own._shares(np.array([time]), 20.0)[0] == pytest.approx(share)


def test_a_limit_is_decided_up_to_a_millionth(carried):
    own, _, _ = carried
    sampled = own._shares(np.linspace(0.0, 1.1, 20001), 1.0).max()
    assert own.greatest(float(sampled) * (1.0 - 1e-6), 0.0)[0] > 1.0
    share, _, sure = own.greatest(float(sampled) * (1.0 + 1e-6), 0.0)
    assert sure and share <= 1.0


def test_fourth_derivatives_are_never_above_their_bounds(carried):
    own, _, _ = carried
    starts = np.linspace(0.0, 1.05, 22)
    bounds = own._snaps(starts, starts + 0.05)
    for start, bound in zip(starts, bounds, strict=True):
        times = start + np.linspace(0.0, 0.05, 9)
        fits = np.polynomial.polynomial.polyfit(times - start, places(own, times), 7)
        inside = np.linspace(0.0, 0.05, 20)
        fourth = np.polynomial.polynomial.polyval(inside, np.polynomial.polynomial.polyder(fits, 4))
        assert np.linalg.norm(fourth, axis=0).max() <= bound * 1.05


@pytest.mark.parametrize(
    ("force", "held"), [(None, True), (40.0, True), (26.2, True), (25.9, False), (15.0, False)]
)
def test_a_plan_is_refused_if_the_gripper_cannot_hold_what_it_lifts(tmp_path, force, held):
    """The peg weighs 1 kg and is lifted by 0.1 m in 0.423 s: 3.23 m/s2 at most, so that friction 0.5 needs 26.1 N."""
    given = "" if force is None else f"      force: {force}\n"
    scene = bench.SCENE.replace("joints: [finger]\n", f"joints: [finger]\n{given}", 1)
    world = bench.load(
        tmp_path,
        scene=scene.replace("    box: [0.04, 0.04, 0.06]\n", "    box: [0.04, 0.04, 0.06]\n    mass: 1\n"),
    )
    made = smooth(world.plan(bench.take_peg()), load_scene(world.problem.scene))
    texts = [f.message for f in verify_plan(world.problem, made).findings if f.node is not None]
    assert held == (not any("needs" in text for text in texts)), texts
    if not held:
        texts = [text for text in texts if "needs" in text]
        assert "segment 2: peg needs" in texts[0] and f"left's gripper is {0.5 * force:.4g} N" in texts[0]
