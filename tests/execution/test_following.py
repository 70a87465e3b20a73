"""What is sent: setpoints on the path, and stops along it within all limits."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from kabo.execution import Follower, Motion, following, motion_of, parts_of
from kabo.execution.loads import LoadOnPath
from kabo.motion import Held
from kabo.plan import Plan
from kabo.scene import Scene, link_pose, motion_limits

RATE = 1000.0
REPOSITORY = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def motion(stacked_plan: Plan, stacked_scene: Scene) -> Motion:
    return motion_of(stacked_plan, stacked_plan.root, stacked_scene)


def sent(follower: Follower, joints: int) -> np.ndarray:
    """All that is sent from now on, (k, 3, joints) for a stretch of so many joints: values and two derivatives."""
    rows = []
    while follower.moving:
        found = [each for each in follower.advance(1.0 / RATE) if len(each.joints) == joints]
        rows += [np.stack([one.positions, one.velocities, one.accelerations]) for one in found[-1:]]
    return np.array(rows)


def test_without_a_stop_the_trajectory_itself_is_sent(motion: Motion, stacked_scene: Scene) -> None:
    follower = Follower(stacked_scene)
    follower.follow(motion)
    while follower.moving:
        for each in follower.advance(1.0 / RATE):
            running = [s for s in motion.at(follower.time) if s.trajectory.joints == each.joints]
            if running:
                for order, value in enumerate(each[2:]):
                    wanted = running[-1].trajectory.at(min(follower.time, running[-1].end), order)
                    assert np.allclose(value, wanted, atol=1e-9) or follower.time >= running[-1].end
    assert follower.time == pytest.approx(motion.end)


@pytest.mark.parametrize("share", np.linspace(0.03, 0.97, 16).tolist())
def test_a_stop_stays_on_the_path_and_within_the_limits_and_ends_at_rest(
    share: float, motion: Motion, stacked_scene: Scene
) -> None:
    follower = Follower(stacked_scene)
    follower.follow(motion)
    begun = motion.begin + share * (motion.end - motion.begin)
    while follower.time < begun:
        list(follower.advance(1.0 / RATE))
    running = next(iter(motion.at(follower.time)))
    limits = motion_limits(stacked_scene.robots[running.robot], running.trajectory.joints)
    follower.stop()
    asked_at = follower.time
    rows = sent(follower, len(running.trajectory.joints))
    assert len(rows)
    assert follower.time - asked_at <= motion.end - asked_at + 1e-9
    assert (np.abs(rows[:, 1]) <= limits.velocity * (1 + 1e-6)).all()
    assert (np.abs(rows[:, 2]) <= limits.acceleration * (1 + 1e-6)).all()
    jerk = np.diff(rows[:, 2], axis=0) * RATE
    assert (np.abs(jerk) <= limits.jerk * 1.02).all()  # a difference over a millisecond
    assert np.abs(rows[-1, 1]).max() < 1e-2 * limits.velocity.max()
    steps = np.linalg.norm(np.diff(rows[:, 0], axis=0), axis=1)
    assert steps.max() <= np.linalg.norm(limits.velocity) / RATE


def test_a_stop_in_fast_motion_is_much_shorter_than_the_motion(motion: Motion, stacked_scene: Scene) -> None:
    follower = Follower(stacked_scene)
    follower.follow(motion)
    transfer = max(motion.stretches, key=lambda each: each.trajectory.duration)
    while follower.time < transfer.begin + 0.4 * transfer.trajectory.duration:
        list(follower.advance(1.0 / RATE))
    follower.stop()
    before, count = follower.time, 0
    while follower.moving:
        list(follower.advance(1.0 / RATE))
        count += 1
    assert follower.time < transfer.end
    assert count / RATE < 0.6
    assert follower.time > before


@pytest.mark.parametrize("share", [0.3, 0.5, 0.7])
def test_a_stop_does_not_shake_off_what_is_held(
    share: float, motion: Motion, stacked_scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Motors that are three times as strong could stop sooner than friction permits."""
    strong = lambda robot, joints: motion_limits(robot, joints).scaled(3.0)  # noqa: E731
    monkeypatch.setattr(following, "motion_limits", strong)
    transfer = max(motion.stretches, key=lambda each: each.trajectory.duration)
    times = np.linspace(transfer.begin, transfer.end, 400)
    robot, tool = stacked_scene.robots[transfer.robot], stacked_scene.robots[transfer.robot].tool
    assert tool is not None

    def places(rows: np.ndarray) -> np.ndarray:
        hand = stacked_scene.start.robots[transfer.robot][robot.planned :]
        return np.array([link_pose(robot, (*row.tolist(), *hand), tool.frame)[:3, 3] for row in rows])

    free = Held(places, 1e9)
    along = LoadOnPath.along(free, times, transfer.trajectory.at(times))
    planned = np.linalg.norm(along.second - np.array(free.gravity), axis=1).max()
    stops = {}
    for bound in (1e9, 1.0005 * planned):
        follower = Follower(stacked_scene)
        follower.loads[transfer.robot] = [Held(places, bound)]
        follower.follow(motion)
        while follower.time < transfer.begin + share * (transfer.end - transfer.begin):
            list(follower.advance(1.0 / RATE))
        follower.stop()
        rows = sent(follower, len(transfer.trajectory.joints))
        found = places(rows[:, 0])
        acceleration = np.diff(found, n=2, axis=0) * RATE**2 - np.array(free.gravity)
        stops[bound] = len(rows), np.linalg.norm(acceleration, axis=1).max()
    (quick, shaken), (gentle, held) = stops.values()
    assert held <= 1.005 * 1.0005 * planned
    assert shaken > 1.05 * planned
    assert gentle > quick


def test_a_motion_is_divided_where_a_hand_acts_at_rest(motion: Motion) -> None:
    parts = parts_of(motion)
    assert [each.kind for part in parts for each in part.actions] == ["grip", "release", "detach"]
    assert parts[0].actions[-1].time == parts[0].end
    assert sum(len(part.stretches) for part in parts) == len(motion.stretches)
    assert [part.begin for part in parts[1:]] == [part.end for part in parts[:-1]]


def test_what_is_called_while_robots_move_is_loaded_before() -> None:
    """Loading a kernel takes longer than a robot server may be silent, and than a watch may be blind."""
    program = """
from pathlib import Path
import kabo
from kabo.execution import KinematicRobot, KnownTruth, execute
from kabo.execution.kernels import origins, placed, setpoints
from kabo.motion.kernels.deviations import positions_at

KERNELS = (setpoints.setpoint, positions_at, placed.distortion, placed.displaced, origins.farthest_origins)


class Counting(KinematicRobot):
    def follow(self, motion):
        loaded.append([len(kernel.signatures) for kernel in KERNELS])
        super().follow(motion)


problem, loaded = kabo.load_problem(Path("domains/stacked/n2.yaml")), []
plan, scene = kabo.solve(problem).plan, kabo.load_scene(problem.scene)
robot = Counting(scene)
assert execute(plan, scene, robot, KnownTruth(poses=robot.poses)).reached_goal
print(loaded[0] == [1] * len(KERNELS), loaded[-1] == loaded[0])
"""
    made = subprocess.run(
        [sys.executable, "-c", program], cwd=REPOSITORY, capture_output=True, text=True, check=True
    )
    assert made.stdout.split() == ["True", "True"], made.stderr
