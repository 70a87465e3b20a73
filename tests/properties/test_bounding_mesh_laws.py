"""The laws of a bounding mesh [K 4.3]: one-sided, within epsilon by proof, closed, and no new crossings."""

import numpy as np
import pytest
from hypothesis import assume, event, given, settings
from hypothesis import strategies as st

from kabo.geometry import bounding_mesh
from tests.conftest import PROPERTY_SCALE
from tests.support import oracles_meshes as oracles
from tests.support.shapes import Shape, shapes

SIDES = ("outer", "inner")
PLACES = st.sampled_from([(1.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0**-10, 0.0), (2.0**10, 0.0), (2.0**-10, 1.0)])
AWAY = np.array([1024.0, 1000.0, 1500.0])
SHARES = st.floats(np.log(1e-3), np.log(0.2)).map(lambda power: float(np.exp(power)))
FEWER = settings(max_examples=max(20, round(150 * PROPERTY_SCALE)))  # exact arithmetic takes its time


def bounded(shape: Shape, share: float, side: str, **options):
    return bounding_mesh(shape, share * shape.diagonal, side, **options)


def nested(shape: Shape, made, side: str):
    """What has to be inside, and what has to contain it."""
    original, result = (shape.vertices, shape.faces), (made.vertices, made.faces)
    return (original, result) if side == "outer" else (result, original)


def probes(vertices, faces, most=60):
    """Vertices, and points of the surface moved into the solid by far more than rounding."""
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    healthy = areas > 1e-12 * areas.max()
    depth = 1e-9 * np.linalg.norm(np.ptp(vertices, axis=0))
    inside = corners[healthy].mean(axis=1) - depth * normals[healthy] / areas[healthy, None]
    chosen = [rows[:: max(1, len(rows) // most)] for rows in (vertices, inside)]
    return np.concatenate(chosen), len(chosen[0])


@FEWER
@given(shape=shapes(), share=SHARES, side=st.sampled_from(SIDES))
def test_nothing_sticks_out_in_exact_arithmetic(shape, share, side):
    inner, outer = nested(shape, bounded(shape, share, side), side)
    points, exact = probes(*inner)
    for number, point in enumerate(points):
        if oracles.winding_number(point, *outer) == 0:
            # Only a vertex is known to be in the solid; a probe has to be found there.
            assert number >= exact and oracles.winding_number(point, *inner) == 0, f"{point.tolist()} sticks out"


@FEWER
@given(shape=shapes(), share=SHARES, side=st.sampled_from(SIDES))
def test_the_solid_inside_has_no_volume_outside(shape, share, side):
    assume(shape.simple and oracles.crossing_pairs(shape.vertices, shape.faces) == 0)
    inner, outer = nested(shape, bounded(shape, share, side), side)
    assert oracles.volume_outside(inner, outer) <= 1e-9 * shape.diagonal**3


@FEWER
@given(shape=shapes(), share=SHARES, side=st.sampled_from(SIDES), target=st.none() | st.integers(4, 40))
def test_the_certificate_is_within_epsilon_and_true(shape, share, side, target):
    made = bounded(shape, share, side, vertices=target)
    assert made.hausdorff_upper_bound <= made.epsilon
    event("used: " + ("most" if made.hausdorff_upper_bound > 0.5 * made.epsilon else "little") + " of epsilon")
    meshes = (shape.vertices, shape.faces), (made.vertices, made.faces)
    for (vertices, faces), other in (meshes, meshes[::-1]):
        points = np.concatenate([vertices, vertices[faces].mean(axis=1)])
        farthest = oracles.distances_to_surface(points[:: max(1, len(points) // 300)], *other).max()
        assert farthest <= made.hausdorff_upper_bound + 1e-12 * shape.diagonal


@FEWER
@given(shape=shapes(), share=SHARES, side=st.sampled_from(SIDES))
def test_the_surface_stays_closed_and_crosses_itself_no_more(shape, share, side):
    made = bounded(shape, share, side)
    assert oracles.lonely_edges(made.faces) == 0
    assert np.isin(np.arange(len(made.vertices)), made.faces).all()
    before = oracles.crossing_pairs(shape.vertices, shape.faces)
    event("the input crosses itself" if before else "no crossings")
    assert oracles.crossing_pairs(made.vertices, made.faces) <= before
    assert oracles.crossing_faces(made.vertices, made.faces) <= oracles.crossing_faces(shape.vertices, shape.faces)


@FEWER
@given(shape=shapes(), share=SHARES, side=st.sampled_from(SIDES), place=PLACES)
def test_scale_and_place_change_nothing_that_is_promised(shape, share, side, place):
    scale, away = place
    moved = Shape(shape.vertices * scale + away * AWAY, shape.faces, shape.simple)
    made = bounded(moved, share, side)
    inner, outer = nested(moved, made, side)
    assert made.hausdorff_upper_bound <= made.epsilon
    assert oracles.lonely_edges(made.faces) == 0
    for vertex in inner[0][:: max(1, len(inner[0]) // 40)]:
        assert oracles.winding_number(vertex, *outer) != 0


@pytest.mark.parametrize("side", SIDES)
@FEWER
@given(shape=shapes(), target=st.integers(4, 60))
def test_a_number_of_vertices_is_where_it_stops(side, shape, target):
    made = bounded(shape, 0.2, side, vertices=target)
    assert len(made.vertices) >= min(target, len(shape.vertices))
    assert made.contractions == len(shape.vertices) - len(made.vertices)
