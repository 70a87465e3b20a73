"""Rows say what the constraints mean [docs/explanation/sampling.md#which-constraints]; judged by plain geometry."""

import numpy as np
import pytest

from kabo.kinematics import (
    FrameFeature,
    jacobian,
    project,
    rows_of,
    sample,
    satisfied,
    stacked,
    values,
)
from kabo.kinematics.kernels import rows as columns
from kabo.language.constraint_kinds import CONSTRAINT_KINDS
from kabo.streams import stream_key
from tests.kinematics.trees import two_arms, violation, world_feature

ARMS = two_arms(seed=3)
DEG = np.pi / 180
FIRST_TOOL, SECOND_TOOL, WORLD = 8, 15, 0
CASES = [
    ("coincident", "point", "point", None, None, 3),
    ("coincident", "point", "line", None, None, 2),
    ("coincident", "point", "plane", None, None, 1),
    ("coincident", "line", "line", None, None, 4),
    ("coincident", "plane", "plane", None, None, 3),
    ("parallel", "line", "line", None, None, 2),
    ("parallel", "plane", "plane", None, None, 2),
    ("parallel", "line", "plane", None, None, 1),
    ("aligned", "line", "line", None, None, 2),
    ("aligned", "plane", "plane", None, None, 2),
    ("aligned", "line", "plane", None, None, 2),
    ("opposed", "line", "line", None, None, 2),
    ("opposed", "line", "plane", None, None, 2),
    ("perpendicular", "plane", "plane", None, None, 1),
    ("perpendicular", "line", "line", None, None, 1),
    ("perpendicular", "line", "plane", None, None, 2),
    ("distance", "point", "point", 0.3, 0.3, 1),
    ("distance", "point", "line", 0.1, 0.2, 1),
    ("distance", "point", "plane", 0.05, 0.05, 1),
    ("distance", "point", "plane", 0.2, None, 1),
    ("distance", "point", "line", None, 0.02, 1),
    ("height", "point", "plane", -0.1, -0.1, 1),
    ("height", "point", "plane", 0.05, 0.12, 1),
    ("height", "point", "plane", 0.3, None, 1),
    ("angle", "line", "line", None, 10 * DEG, 1),
    ("angle", "line", "plane", 30 * DEG, 30 * DEG, 1),
    ("angle", "plane", "plane", 170 * DEG, None, 1),
]
PLACES = [(FIRST_TOOL, WORLD), (FIRST_TOOL, SECOND_TOOL), (WORLD, SECOND_TOOL), (5, 8)]


def feature(joint, kind, seed):
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=3)
    return FrameFeature(
        joint,
        kind,
        tuple(rng.uniform(-0.2, 0.2, 3)),
        None if kind == "point" else tuple(direction / np.linalg.norm(direction)),
    )


@pytest.mark.parametrize(("kind", "one", "other", "lower", "upper", "count"), CASES)
@pytest.mark.parametrize("place", PLACES)
def test_samples_fulfil_the_constraint_in_plain_geometry(kind, one, other, lower, upper, count, place):
    first, second = feature(place[0], one, 1), feature(place[1], other, 2)
    rows = rows_of(kind, first, second, lower, upper)
    assert rows.shape == (count, columns.WIDTH)
    tree = ARMS.tree
    Q, right = sample(tree, rows, stream_key(kind), 0, 40, tree.lower, tree.upper, np.ones(tree.size, bool))
    if place != (5, 8):  # three joints between the frames cannot fulfil everything
        assert right.sum() >= 8
    for q in Q[right]:
        assert violation(kind, first, second, lower, upper, ARMS.poses(q)) <= 2e-6
        assert satisfied(rows, q, tree)


@pytest.mark.parametrize(("kind", "one", "other", "lower", "upper", "count"), CASES)
def test_what_violates_the_constraint_is_not_satisfied(kind, one, other, lower, upper, count):
    first, second = feature(FIRST_TOOL, one, 1), feature(SECOND_TOOL, other, 2)
    rows = rows_of(kind, first, second, lower, upper)
    for q in np.random.default_rng(0).uniform(-1, 1, (50, ARMS.tree.size)):
        error = violation(kind, first, second, lower, upper, ARMS.poses(q))
        assert satisfied(rows, q, ARMS.tree, 1e-6) == (error <= 1e-6)


@pytest.mark.parametrize(("kind", "one", "other", "lower", "upper", "count"), CASES)
def test_jacobians_are_those_of_central_differences(kind, one, other, lower, upper, count):
    for place in PLACES:
        rows = rows_of(kind, feature(place[0], one, 4), feature(place[1], other, 5), lower, upper)
        for q in np.random.default_rng(1).uniform(-1.5, 1.5, (3, ARMS.tree.size)):
            difference = differences(rows, q)
            assert np.allclose(jacobian(rows, q, ARMS.tree), difference, atol=2e-8)


def test_jacobians_of_azimuth_are_those_of_central_differences():
    rows = rows_of("azimuth", feature(FIRST_TOOL, "line", 6), feature(SECOND_TOOL, "line", 7))
    for q in np.random.default_rng(1).uniform(-1.5, 1.5, (5, ARMS.tree.size)):
        assert np.allclose(jacobian(rows, q, ARMS.tree), differences(rows, q), atol=1e-7)


def differences(rows, q, step=1e-6):
    """The derivative of the rows' values by central differences."""
    steps = step * np.eye(len(q))
    return np.stack(
        [(values(rows, q + s, ARMS.tree) - values(rows, q - s, ARMS.tree)) / (2 * step) for s in steps], axis=1
    )


def test_jacobians_are_those_of_pinocchio():
    point, plane = feature(FIRST_TOOL, "point", 8), feature(WORLD, "plane", 9)
    rows = rows_of("height", point, plane, 0.0, 0.0)
    for q in np.random.default_rng(2).uniform(-1.5, 1.5, (10, ARMS.tree.size)):
        pose, J = ARMS.poses(q)[FIRST_TOOL], ARMS.jacobian(q, FIRST_TOOL)
        arm = world_feature(point, ARMS.poses(q))[0] - pose.translation
        velocities = J[:3] + np.cross(J[3:].T, arm).T
        assert np.allclose(jacobian(rows, q, ARMS.tree)[0], np.array(plane.direction) @ velocities, atol=1e-12)


def test_aligned_and_opposed_rows_pull_over_from_upside_down():
    """No seed ends upside down, not even one that starts there exactly."""
    up, down = feature(FIRST_TOOL, "line", 1), feature(SECOND_TOOL, "line", 2)
    for kind, sense in (("aligned", 1.0), ("opposed", -1.0)):
        rows = rows_of(kind, up, down)
        against = rows_of({"aligned": "opposed", "opposed": "aligned"}[kind], up, down)
        tree = ARMS.tree
        free = np.ones(tree.size, bool)
        seeds, right = sample(tree, against, stream_key("against"), 0, 20, tree.lower, tree.upper, free)
        Q, arrived = project(tree, rows, seeds[right], tree.lower, tree.upper, free)
        assert arrived.sum() >= 5
        for q in Q[arrived]:
            (_, d), (_, e) = (world_feature(f, ARMS.poses(q)) for f in (up, down))
            assert sense * (d @ e) > 1.0 - 1e-9


def test_the_order_of_shapes_does_not_matter_where_the_meaning_is_symmetric():
    line, plane, point = (feature(FIRST_TOOL, kind, 1) for kind in ("line", "plane", "point"))
    other = feature(SECOND_TOOL, "plane", 2)
    assert np.array_equal(rows_of("parallel", other, line), rows_of("parallel", line, other))
    assert np.array_equal(rows_of("coincident", plane, point), rows_of("coincident", point, plane))


def test_a_distance_of_zero_is_a_coincidence_and_an_angle_of_zero_an_alignment():
    point, line, plane = (feature(FIRST_TOOL, kind, 1) for kind in ("point", "line", "plane"))
    other = feature(SECOND_TOOL, "line", 2)
    assert np.array_equal(rows_of("distance", point, other, upper=0.0), rows_of("coincident", point, other))
    assert np.array_equal(rows_of("angle", line, other, 0.0, 0.0), rows_of("aligned", line, other))
    assert np.array_equal(rows_of("angle", plane, other, np.pi, np.pi), rows_of("opposed", other, plane))


@pytest.mark.parametrize(
    ("kind", "one", "other", "lower", "upper", "message"),
    [
        ("coincident", "line", "plane", None, None, "cannot coincide"),
        ("aligned", "point", "line", None, None, "a point has none"),
        ("distance", "line", "line", 0.1, 0.1, "from a point"),
        ("distance", "point", "line", None, None, "needs a bound"),
        ("distance", "point", "line", None, -0.1, "never negative"),
        ("height", "point", "line", 0.1, 0.1, "above a plane"),
        ("height", "point", "plane", 0.2, 0.1, "crossed"),
        ("angle", "line", "line", 4.0, None, "between 0 and 180"),
        ("parallel", "line", "line", 0.1, None, "takes no bounds"),
        ("beside", "line", "line", None, None, "unknown constraint"),
    ],
)
def test_what_has_no_meaning_is_refused(kind, one, other, lower, upper, message):
    with pytest.raises(ValueError, match=message):
        rows_of(kind, feature(1, one, 1), feature(2, other, 2), lower, upper)


@pytest.mark.parametrize(
    ("kind", "shapes"),
    [(kind, shapes) for kind, known in CONSTRAINT_KINDS.items() for shapes in sorted(known.shapes)],
)
def test_every_pair_of_shapes_that_a_file_may_relate_has_rows(kind, shapes):
    bounds = (None, None) if CONSTRAINT_KINDS[kind].quantity is None else (0.1, 0.2)
    rows = rows_of(kind, feature(FIRST_TOOL, shapes[0], 1), feature(SECOND_TOOL, shapes[1], 2), *bounds)
    assert len(rows) and rows.shape[1] == columns.WIDTH


def test_a_feature_needs_a_unit_direction():
    with pytest.raises(ValueError, match="unit vector"):
        FrameFeature(0, "line", (0.0, 0.0, 0.0), (0.0, 0.0, 2.0))
    with pytest.raises(ValueError, match="not finite"):
        FrameFeature(0, "point", (0.0, np.nan, 0.0))


def test_rows_stack_to_a_conjunction_and_nothing_stacks_to_no_rows():
    assert stacked([]).shape == (0, columns.WIDTH)
    assert satisfied(stacked([]), np.zeros(ARMS.tree.size), ARMS.tree)
