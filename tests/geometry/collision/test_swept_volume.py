"""Bounding swept volumes: they contain what is swept, stick out no farther than they say, and are closed meshes."""

import numpy as np
import pytest
import trimesh

from kabo.geometry import Enclosure, Motion, MovingGroup, swept_volume
from tests.geometry.worlds import box, move, slide, three_joints
from tests.support.strategies import IDENTITY

BAR = Enclosure((box([0.15, 0.03, 0.03]),), 0.0)


def arm(*waypoints, bodies=(1, 2, 3), enclosure=BAR):
    """Three joints that turn about z, with a bar on some."""
    groups = tuple(MovingGroup(j, move(0.15, 0, 0), enclosure) for j in bodies)
    return Motion(three_joints(), groups, np.array(waypoints, float))


def test_a_slide_is_swept_by_one_box_without_growth():
    motion = Motion(
        slide(IDENTITY), (MovingGroup(1, IDENTITY, Enclosure((box([0.1] * 3),), 0.0)),), np.array([[0.0], [1.0]])
    )
    volume = swept_volume(motion, 1e-3)
    (part,) = volume.parts
    assert volume.deviation < 1e-8
    assert np.allclose(part.min(axis=0), [-0.1, -0.1, -0.1], atol=1e-8)
    assert np.allclose(part.max(axis=0), [0.1, 0.1, 1.1], atol=1e-8)


def test_a_quarter_turn_sweeps_a_quarter_of_a_disc():
    volume = swept_volume(arm([0, 0, 0], [np.pi / 2, 0, 0], bodies=[1]), 1e-3)
    vertices, faces = volume.mesh()
    reach = np.hypot(0.3, 0.03)
    assert np.linalg.norm(vertices[:, :2], axis=1).max() <= reach + volume.deviation
    assert np.abs(vertices[:, 2]).max() <= 0.03 + volume.deviation
    assert volume.deviation <= 1e-3
    assert faces.min() >= 0


@pytest.mark.parametrize("tolerance", [0.05, 0.01, 0.002])
def test_the_polyhedra_stick_out_as_little_as_is_asked_for(tolerance):
    volume = swept_volume(arm([0, 0, 0], [1.0, -1.0, 2.0]), tolerance)
    assert 0 < volume.deviation <= tolerance
    loose = swept_volume(arm([0, 0, 0], [1.0, -1.0, 2.0], enclosure=Enclosure(BAR.parts, 0.004)), tolerance)
    assert loose.deviation == pytest.approx(volume.deviation + 0.004)


def test_finer_is_more_and_slow_links_are_coarser():
    count = [len(swept_volume(arm([0, 0, 0], [1.0, 1.0, 1.0], bodies=[j]), 0.01).hulls) for j in (1, 2, 3)]
    assert count[0] < count[2]
    finer = len(swept_volume(arm([0, 0, 0], [1.0, 1.0, 1.0]), 0.0025).hulls)
    assert sum(count) < finer <= 8 * sum(count)


def test_the_mesh_is_closed_and_turned_outwards():
    vertices, faces = swept_volume(arm([0, 0, 0], [1.0, 1.0, 1.0]), 0.01).mesh()
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert all(part.volume > 0 for part in mesh.split())


@pytest.mark.parametrize("part", [np.zeros((1, 3)), box([0.1, 0.0, 0.0]), box([0.1, 0.1, 0.0])])
def test_points_needles_and_plates_are_swept_as_well(part):
    for waypoints in ([[0, 0, 0]], [[0, 0, 0], [1, 0, 0]]):
        volume = swept_volume(arm(*waypoints, enclosure=Enclosure((part,), 0.0)), 0.01)
        assert all(len(corners) >= 4 for corners in volume.parts)


def test_nothing_sweeps_nothing():
    vertices, faces = swept_volume(arm([0, 0, 0], bodies=[]), 0.01).mesh()
    assert vertices.shape == faces.shape == (0, 3)


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan, 1e-7])
def test_a_tolerance_that_cannot_be_kept_is_refused(tolerance):
    with pytest.raises(ValueError, match="tolerance"):
        swept_volume(arm([0, 0, 0]), tolerance)
