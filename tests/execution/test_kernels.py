"""Kernels of the executor beside what is known without them: numpy, and `Trajectory.at`."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kabo.execution.kernels.placed import displaced, distortion
from kabo.motion import Trajectory
from kabo.motion.kernels.deviations import positions_at


def random_poses(draw: np.random.Generator, count: int) -> np.ndarray:
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, :3] = Rotation.random(count, random_state=draw.integers(1 << 30)).as_matrix()
    poses[:, :3, 3] = draw.normal(size=(count, 3))
    return poses


@pytest.mark.parametrize("seed", range(20))
def test_places_are_those_of_the_trajectory(seed: int) -> None:
    draw = np.random.default_rng(seed)
    pieces, joints = int(draw.integers(1, 6)), int(draw.integers(1, 8))
    times = tuple(np.cumsum(draw.uniform(0.01, 1.0, pieces + 1)).tolist())
    rows = [[tuple(draw.normal(size=draw.integers(1, 7)).tolist()) for _ in range(joints)] for _ in range(pieces)]
    names = tuple(f"j{k}" for k in range(joints))
    motion = Trajectory(names, ((0.0,) * joints,) * 2, times, tuple(map(tuple, rows)))
    wanted = np.sort([*times, *draw.uniform(times[0], times[-1], 20)])
    assert np.array_equal(positions_at(motion.knots, motion.padded, wanted), motion.at(wanted))


@pytest.mark.parametrize("seed", range(20))
def test_points_are_displaced_by_what_their_poses_say(seed: int) -> None:
    draw = np.random.default_rng(seed)
    wanted, found = random_poses(draw, 5), random_poses(draw, 5)
    points = draw.normal(size=(5, 8, 3))
    there = [points @ poses[:, :3, :3].transpose(0, 2, 1) + poses[:, None, :3, 3] for poses in (wanted, found)]
    moves, sizes = displaced(wanted, found, points)
    assert np.allclose(moves, there[1] - there[0], atol=1e-12)
    assert np.allclose(sizes, np.linalg.norm(there[1] - there[0], axis=2).max(axis=1), atol=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_what_is_no_pose_is_seen(seed: int) -> None:
    draw = np.random.default_rng(seed)
    poses = random_poses(draw, 4)
    assert distortion(poses) < 1e-12
    k, row, column = draw.integers(4), draw.integers(3), draw.integers(3)
    longer = poses.copy()
    longer[k, row, :3] *= 1.01
    assert distortion(longer) == pytest.approx(0.0201, abs=1e-9)
    sheared = poses.copy()
    sheared[k, :3, :3] = poses[k, :3, :3] @ (np.eye(3) + 0.01 * np.eye(3)[[row]].T * np.eye(3)[[row - 1]])
    skew = sheared[k, :3, :3] @ sheared[k, :3, :3].T - np.eye(3)
    assert distortion(sheared) == pytest.approx(np.abs(skew).max(), abs=1e-12)
    mirrored = poses.copy()
    mirrored[k, :3, column] *= -1.0
    assert distortion(mirrored) == np.inf
    last = poses.copy()
    last[k, 3, column] = 0.02
    assert distortion(last) == pytest.approx(0.02)
    for value in (np.nan, np.inf, -np.inf):
        for at in ((row, column), (row, 3), (3, column)):
            broken = poses.copy()
            broken[(k, *at)] = value
            assert not distortion(broken) <= 1.0
