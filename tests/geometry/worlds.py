"""Small trees and bodies for tests of views."""

import numpy as np

from kabo.scene import PRISMATIC, REVOLUTE, KinematicTree


def one_joint(placement: np.ndarray, kind: int = REVOLUTE, limit: float = 4.0) -> KinematicTree:
    """A tree of one joint, placed (12,) in the world."""
    rows = np.zeros((2, 12))
    rows[:, [0, 4, 8]], rows[1] = 1.0, placement
    zeros, last = np.zeros(2, np.int64), np.array([0.0, 1.0])
    bound = np.array([limit])
    return KinematicTree(zeros, np.array([0, kind]), zeros, last, np.zeros(2), rows, -bound, bound, np.ones(1))


def slide(placement: np.ndarray) -> KinematicTree:
    """A tree of one joint that slides along z."""
    return one_joint(placement, PRISMATIC, 2.0)


def three_joints() -> KinematicTree:
    """Three joints that turn about z, 0.3 m apart along x."""
    rows = np.zeros((4, 12))
    rows[:, [0, 4, 8]], rows[2:, 9] = 1.0, 0.3
    ratio = np.array([0.0, 1.0, 1.0, 1.0])
    bound = np.full(3, 3.2)
    parent, source = np.array([0, 0, 1, 2]), np.array([0, 0, 1, 2])
    return KinematicTree(
        parent, np.zeros(4, np.int64), source, ratio, np.zeros(4), rows, -bound, bound, np.ones(3)
    )


def box(half) -> np.ndarray:
    """The corners of a box about the origin."""
    return np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * np.asarray(half, float)


def move(x: float, y: float, z: float) -> np.ndarray:
    """A pose (12,) without rotation."""
    return np.array([1.0, 0, 0, 0, 1, 0, 0, 0, 1, x, y, z])


def rng_rows(seed: int, count: int, size: int) -> np.ndarray:
    """Configurations of angles."""
    return np.random.default_rng(seed).uniform(-3.1, 3.1, (count, size))
