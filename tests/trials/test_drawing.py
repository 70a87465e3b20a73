"""Drawings without a library: pictures are PNG, contours lie where values pass the level, everything is XML."""

import io
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from kabo.trials.drawing import Axis, Dot, colours, contours, curve, heat_map, png


def test_a_picture_is_the_pixels():
    pixels = np.random.default_rng(0).integers(0, 256, (7, 5, 4)).astype(np.uint8)
    read = Image.open(io.BytesIO(png(pixels)))
    assert read.mode == "RGBA" and (np.asarray(read) == pixels).all()


def test_contours_of_a_cone_are_circles():
    y, x = np.mgrid[0:41, 0:41] / 20.0 - 1.0
    for radius in (0.3, 0.7):
        (line,) = contours(-np.hypot(x, y), -radius)
        assert line[0] == line[-1] and len(line) > 20
        points = np.array(line) / 20.0 - 1.0
        assert np.abs(np.hypot(*points.T) - radius).max() < 2e-3


def test_contours_end_at_the_border_and_there_are_none_where_no_level_is_passed():
    values = np.tile(np.linspace(0.0, 1.0, 9), (5, 1))
    (line,) = contours(values, 0.5 + 1e-9)
    assert sorted(y for _, y in line) == [0, 1, 2, 3, 4] and {round(x, 6) for x, _ in line} == {4.0}
    assert contours(values, 2.0) == [] and contours(values, -1.0) == []


@given(st.integers(0, 10_000))
def test_each_edge_of_the_grid_that_passes_the_level_has_one_point_and_every_line_goes_on(seed):
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(6, 7))
    above = values > 0.1
    passed = (above[:, 1:] != above[:, :-1]).sum() + (above[1:] != above[:-1]).sum()
    lines = contours(values, 0.1)
    points = [point for line in lines for point in (line[:-1] if line[0] == line[-1] else line)]
    assert len(points) == len(set(points)) == passed
    for line in lines:
        border = [x in (0, 6) or y in (0, 5) for x, y in (line[0], line[-1])]
        assert line[0] == line[-1] or all(border)
        assert all(np.hypot(a - c, b - d) < 1.5 for (a, b), (c, d) in zip(line, line[1:], strict=False))


def test_colours_grow_brighter():
    brightness = colours(np.linspace(0.0, 1.0, 50)) @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(brightness) > 0.0).all()
    assert (colours(np.array([-1.0, 2.0])) == colours(np.array([0.0, 1.0]))).all()


@pytest.mark.parametrize(
    ("lower", "upper", "ticks"),
    [
        (-0.08, 0.08, [-0.05, 0.0, 0.05]),
        (1.0, 40.0, [10.0, 20.0, 30.0, 40.0]),
        (0.0, 1.0, [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]),
        (-1e-320, 1e-320, [-1e-320, 1e-320]),
        (-1e305, 1e305, [-1e305, 1e305]),
    ],
)
def test_ticks_are_round(lower, upper, ticks):
    assert Axis("x", lower, upper).ticks() == pytest.approx(ticks, rel=1e-9, abs=1e-12 * (upper - lower))


@given(st.floats(-1e12, 1e12), st.floats(1e-9, 1e12))
def test_ticks_lie_within_the_axis_and_are_few(lower, width):
    axis = Axis("x", lower, lower + width)
    if axis.upper - axis.lower > 1e-6 * abs(lower):
        assert len(axis.ticks()) <= 6
        assert all(-1e-6 < axis.share(tick) < 1.0 + 1e-6 for tick in axis.ticks())


def test_names_cannot_break_out_of_a_drawing():
    bad = "</text><script>&\"'"
    x, y = Axis(bad, 0.0, 1.0), Axis(bad, -1.0, 1.0)
    dots = [Dot(0.5, 0.0, "red", bad), Dot(0.1, 0.1, "red", bad, cross=True, opacity=0.3)]
    flat = np.zeros((3, 3, 4), np.uint8)
    values = np.array([[0.0, 1.0, 0.0]] * 3)
    for drawn in (
        heat_map(x, y, flat, [(values, 0.5, "strict")], dots, bad),
        curve(
            x, y, np.linspace(0, 1, 4), np.array([0.1, 0.2, np.nan, 0.3]), np.full(4, 0.1), dots, [(0.5, "loose")]
        ),
    ):
        tree = ElementTree.fromstring(drawn)
        assert [each.text for each in tree.iter("title")] == [bad, bad]
        assert not list(tree.iter("script"))


def test_a_curve_is_broken_where_its_value_is_unknown():
    drawn = curve(
        Axis("x", 0, 1), Axis("y", 0, 1), np.linspace(0, 1, 5), np.array([0.1, 0.2, np.nan, 0.3, 0.4]), None, []
    )
    assert drawn.count("<polyline") == 2 and "nan" not in drawn
