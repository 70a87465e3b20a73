"""Towers of blocks that are put down turned and beside the middle, as plans do: they stand still in physics."""

from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.arrays import Array
from kabo.scene.transforms import quaternion, transform
from kabo.simulation import Physics
from kabo.simulation.contact_shapes import ContactShape, calm
from kabo.streams import stream_key, uniforms

pytest.importorskip("mujoco")
DOMAINS = Path(__file__).parents[2] / "domains"
BESIDE, SCATTERED = 0.012, 0.002  # [m]
HEIGHT = 0.02  # [m] of a block


def tower() -> Physics:
    """Nineteen flat blocks, turned and scattered; from the fifth on all are as far beside the lowest one."""
    physics = Physics(kabo.load_scene(DOMAINS / "stacked" / "n20.yaml"))
    base = physics.pose("o2")
    for number, (share, along, across) in enumerate(uniforms(stream_key("tower", "turned"), 0, 19, 3)):
        turn = np.pi * share
        pose = transform((0.0, 0.0, 0.0), (0.0, 0.0, float(np.sin(0.5 * turn)), float(np.cos(0.5 * turn))))
        scattered = SCATTERED * (2.0 * along - 1.0), SCATTERED * (2.0 * across - 1.0)
        beside = BESIDE * min(number / 5.0, 1.0)
        pose[:3, 3] = base[:3, 3] + [beside + scattered[0], scattered[1], number * HEIGHT]
        x, y, z, w = quaternion(pose)
        physics.data.joint(f"o{number + 2}").qpos[:] = [*pose[:3, 3], w, x, y, z]
    return physics


def poses_after_two_seconds(physics: Physics) -> list[Array]:
    for _ in range(2000):
        physics.step()
    return [physics.pose(f"o{k}") for k in range(2, 21)]


def test_a_tower_of_nineteen_turned_blocks_stands_still_and_hardly_leans() -> None:
    physics = tower()
    settled, after = poses_after_two_seconds(physics), poses_after_two_seconds(physics)
    ways = [float(np.linalg.norm(b[:3, 3] - a[:3, 3])) for a, b in zip(settled, after, strict=True)]
    assert max(ways) < 5e-6
    lean = [float(np.degrees(np.arccos(min(1.0, pose[2, 2])))) for pose in after]
    assert max(lean) < 0.1


def test_the_hull_of_a_box_has_its_corners() -> None:
    pose = transform((0.1, 0.2, 0.3), (0.0, 0.0, float(np.sin(0.2)), float(np.cos(0.2))))
    made = calm(ContactShape("box", (0.01, 0.02, 0.03), pose))
    assert made.kind == "mesh" and made.corners is not None and made.corners.shape == (8, 3)
    own = (made.corners - pose[:3, 3]) @ pose[:3, :3]
    assert np.allclose(np.abs(own), [0.01, 0.02, 0.03])
    sphere = ContactShape("sphere", (0.01,), pose)
    assert calm(sphere) is sphere
