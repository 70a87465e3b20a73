"""Frames with all sines at once are those of plain forward kinematics."""

import numpy as np
import pytest

from kabo.geometry.collision.kernels.bundles import Chain
from kabo.geometry.collision.kernels.sines import frames_of
from kabo.geometry.collision.view_arrays import local_frames
from kabo.scene import PRISMATIC, REVOLUTE
from kabo.scene.kernels.poses import forward_kinematics
from tests.support.strategies import placement_of


def chain(rng, kinds):
    joints = np.array([[0, *range(len(kinds))], [REVOLUTE, *kinds], [0, *range(len(kinds))]], np.int64)
    joints[0, -1] = 1  # a branch
    placement = np.array([placement_of(rng.normal(size=4), rng.normal(size=3)) for _ in range(len(kinds) + 1)])
    factors = np.array([rng.uniform(-2.0, 2.0, len(kinds) + 1), rng.normal(size=len(kinds) + 1)])
    return Chain(joints, factors, placement, np.full(len(kinds), 1e6))


@pytest.mark.parametrize("largest", [3.0, 900.0, 5e5])  # of the last some angles are too large for the common pass
@pytest.mark.parametrize(
    "kinds", [(REVOLUTE,) * 4, (PRISMATIC, REVOLUTE, PRISMATIC), (REVOLUTE, PRISMATIC, REVOLUTE)]
)
def test_frames_are_those_of_forward_kinematics(kinds, largest):
    rng = np.random.default_rng(5)
    for _ in range(50):
        tree, q = chain(rng, kinds), rng.uniform(-largest, largest, len(kinds))
        count = len(kinds) + 1
        expected, world_T = np.zeros((2, count, 12))
        expected[0, [0, 4, 8]] = world_T[0, [0, 4, 8]] = 1.0
        forward_kinematics(q, *tree.joints, *tree.factors, tree.placement, expected)
        for function in (frames_of, frames_of.py_func):
            frames = np.zeros((count, 3, 4))
            frames[0] = np.eye(3, 4)
            local = local_frames(tree.placement).ravel()
            function(q, tree, local, np.zeros((3, count)), world_T, frames.reshape(-1))
            # A sliding joint goes as far as its value, of which rounding takes its share.
            assert np.allclose(frames[:, :, :3].reshape(count, 9), expected[:, :9], atol=1e-13, rtol=0.0)
            assert np.allclose(frames[:, :, 3], expected[:, 9:], atol=1e-14 * (10.0 + largest), rtol=1e-13)
