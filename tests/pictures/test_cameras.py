"""Cameras: everything is in the picture, and the picture is full."""

import numpy as np
import pytest

from kabo.pictures.cameras import MARGIN, Camera, directions, fitted, natural_aspect

SIZE = (900, 600)


def cloud(seed: int) -> np.ndarray:
    generator = np.random.default_rng(seed)
    return generator.uniform(-1.0, 1.0, (60, 3)) * generator.uniform(0.1, 3.0, 3) + generator.uniform(-5, 5, 3)


@pytest.mark.parametrize("seed", range(8))
def test_every_point_is_in_the_picture_from_every_side(seed):
    points = cloud(seed)
    for away in directions():
        seen = fitted(points, away, SIZE[0] / SIZE[1]).seen(points, SIZE)
        assert (seen[:, :2] >= 0).all() and (seen[:, :2] <= SIZE).all() and (seen[:, 2] > 0).all()


@pytest.mark.parametrize("seed", range(8))
def test_the_points_fill_the_picture_in_one_direction_up_to_the_margin(seed):
    points = cloud(seed)
    for away in directions():
        seen = fitted(points, away, SIZE[0] / SIZE[1]).seen(points, SIZE)
        filled = np.ptp(seen[:, :2], axis=0) / SIZE
        assert filled.max() > 0.93 / MARGIN


def test_a_picture_of_free_size_has_the_shape_of_what_it_shows():
    wide = cloud(0) * (1.0, 9.0, 0.4)
    away = np.array([1.0, 0.0, 0.5])
    assert natural_aspect(wide, away) > natural_aspect(wide[:, [1, 0, 2]], away)


def test_a_camera_sees_up_as_up_and_left_as_left():
    camera = Camera(np.array([5.0, 0.0, 0.0]), np.zeros(3))
    (x, y, depth), (above, higher, _), (left, _, _) = camera.seen(
        np.array([[0, 0, 0], [0, 0, 1], [0, -1, 0]]), SIZE
    )
    assert (x, y, depth) == pytest.approx((450, 300, 5)) and higher < y and above == pytest.approx(x) and left < x
