"""Lines through contacts against least squares and RANSAC of others; their frames; Halton's sequence [T 4.3]."""

import numpy as np
import pytest

from kabo.exploration import ExplorationError, fit_line, halton

UP = np.array([0.0, 0.0, 1.0])


def contacts(
    seed: int, count: int, outliers: int = 0, noise: float = 0.0008
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points near a line of 0.5 m, then outliers; a point of the line, and its direction."""
    generator = np.random.default_rng(seed)
    direction = generator.normal(size=3)
    direction /= np.linalg.norm(direction)
    origin = generator.normal(size=3)
    near = origin + np.outer(generator.random(count) * 0.5, direction) + generator.normal(size=(count, 3)) * noise
    far = origin + generator.uniform(-0.4, 0.4, size=(outliers, 3))
    return np.vstack([near, far]), origin, direction


def distances(points: np.ndarray, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
    return np.array([np.linalg.norm(np.cross(point - origin, direction)) for point in points])


@pytest.mark.parametrize("seed", range(8))
def test_without_outliers_the_line_is_that_of_least_squares(seed):
    points, _, _ = contacts(seed, 30)
    line = fit_line(points)
    assert line.inliers.all()
    values, vectors = np.linalg.eigh(np.cov(points.T))  # the main axis of the covariance
    assert abs(vectors[:, np.argmax(values)] @ line.direction) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(distances(points.mean(axis=0)[None], line.origin, line.direction), 0.0, atol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_outliers_are_left_out_as_the_exhaustive_search_leaves_them(seed):
    points, _, _ = contacts(seed, 16, outliers=6)
    best = 0
    for i in range(len(points)):
        for j in range(i):
            apart = points[i] - points[j]
            best = max(best, int((distances(points, points[j], apart / np.linalg.norm(apart)) <= 0.01).sum()))
    line = fit_line(points)
    assert line.inliers[:16].all()
    assert line.inliers.sum() >= best - 1
    np.testing.assert_array_equal(line.inliers, distances(points, line.origin, line.direction) <= 0.01)


@pytest.mark.parametrize("seed", range(5))
def test_many_points_give_the_line_that_scikit_learn_finds(seed):
    from sklearn.linear_model import LinearRegression, RANSACRegressor

    generator = np.random.default_rng(seed)
    x = np.sort(generator.random(120)) * 0.6
    slopes, offsets = np.array([0.2, -0.1]), np.array([0.3, 0.9])
    points = np.column_stack([x, np.outer(x, slopes) + offsets + generator.normal(size=(120, 2)) * 0.0008])
    points[::10, 1:] += generator.uniform(0.05, 0.3, size=(12, 2))

    def loss(true, predicted):
        return np.linalg.norm(true - predicted, axis=1)

    judge = RANSACRegressor(LinearRegression(), residual_threshold=0.01, loss=loss, random_state=seed)
    judge.fit(points[:, :1], points[:, 1:])
    line = fit_line(points)
    np.testing.assert_array_equal(line.inliers, judge.inlier_mask_)
    assert line.inliers.sum() == 108
    np.testing.assert_allclose(line.direction[1:] / line.direction[0], judge.estimator_.coef_[:, 0], atol=2e-4)


@pytest.mark.parametrize("seed", range(12))
def test_origin_and_length_are_those_of_the_outermost_inliers(seed):
    points, origin, direction = contacts(seed, 40, outliers=8, noise=0.0)
    line = fit_line(points)
    along = (points[line.inliers] - line.origin) @ line.direction
    assert along.min() == pytest.approx(0.0, abs=1e-9)
    assert along.max() == pytest.approx(line.length, abs=1e-9)
    np.testing.assert_allclose(distances(line.origin[None], origin, direction), 0.0, atol=1e-3)
    np.testing.assert_allclose(line.at(1.0), line.origin + line.length * line.direction, atol=1e-12)
    np.testing.assert_allclose(line.distance(points), distances(points, line.origin, line.direction), atol=1e-9)


@pytest.mark.parametrize("seed", range(40))
def test_the_frame_is_right_handed_with_x_along_and_z_upward(seed):
    points, _, _ = contacts(seed, 10)
    line = fit_line(points)
    frame = line.frame
    np.testing.assert_allclose(frame[:3, :3].T @ frame[:3, :3], np.eye(3), atol=1e-12)
    assert np.linalg.det(frame[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_array_equal(frame[:3, 0], line.direction)
    np.testing.assert_array_equal(frame[:3, 3], line.origin)
    np.testing.assert_array_equal(frame[3], [0, 0, 0, 1])
    upward = UP - (UP @ line.direction) * line.direction  # the most upward direction across the line
    np.testing.assert_allclose(frame[:3, 2], upward / np.linalg.norm(upward), atol=1e-9)


@pytest.mark.parametrize(
    ("ends", "origin"),
    [
        ([[0.5, -0.3, 0.8], [0.5, 0.3, 0.8]], 0),  # right is -y
        ([[0.5, 0.3, 0.8], [0.5, -0.3, 0.8]], 1),
        ([[0.5, 0.0, 1.2], [0.5, 0.0, 0.8]], 1),  # below
        ([[0.2, 0.1, 0.8], [0.5, 0.1, 0.8]], 0),  # neither: nearer to the robot
        ([[0.5, 0.1, 0.8], [0.2, 0.1, 0.8]], 1),
    ],
)
def test_the_origin_is_the_right_and_bottom_most_end(ends, origin):
    np.testing.assert_allclose(fit_line(ends).origin, ends[origin], atol=1e-12)


def test_a_vertical_line_has_a_frame():
    frame = fit_line([[1.0, 2.0, 0.0], [1.0, 2.0, 0.5]]).frame
    np.testing.assert_allclose(frame[:3, 0], UP)
    assert np.linalg.det(frame[:3, :3]) == pytest.approx(1.0)


def test_the_same_points_and_seed_give_the_same_line():
    points, _, _ = contacts(3, 80, outliers=40)
    first, second = fit_line(points, seed=7), fit_line(points, seed=7)
    np.testing.assert_array_equal(first.inliers, second.inliers)
    np.testing.assert_array_equal(first.origin, second.origin)


def test_a_third_of_outliers_among_many_points_does_not_matter():
    points, origin, direction = contacts(3, 80, outliers=40)
    line = fit_line(points)
    assert line.inliers[:80].all()
    assert np.degrees(np.arccos(min(1.0, abs(line.direction @ direction)))) < 0.5


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("scale", "offset"), [(1e-9, 1e4), (1e7, 0.0), (1e-300, 0.0), (1e99, 0.0), (1e-6, 1e10)])
@pytest.mark.parametrize("tolerance", [1e-15, 0.01, 1e3])
def test_points_of_any_size_give_a_finite_line_or_one_sentence(scale, offset, tolerance):
    points = offset + scale * np.random.default_rng(0).random((9, 3))
    try:
        line = fit_line(points, tolerance)
    except ExplorationError as error:
        assert str(error) == "all points of the line are the same"
        return
    assert line.inliers.sum() >= 2
    assert np.linalg.norm(line.direction) == pytest.approx(1.0)
    assert np.isfinite(line.frame).all()


@pytest.mark.parametrize("seed", range(20))
def test_two_points_define_a_line_even_if_rounding_exceeds_the_tolerance(seed):
    points = 1_000 * np.random.default_rng(seed).normal(size=(2, 3))
    line = fit_line(points, 1e-15)
    assert line.inliers.all()
    assert line.length == pytest.approx(np.linalg.norm(points[0] - points[1]))


@pytest.mark.parametrize("index", range(0, 1_000, 90))
def test_one_point_apart_from_many_duplicates_is_found(index):
    points = np.zeros((1_000, 3))
    points[index] = [0.0, 0.5, 0.0]
    line = fit_line(points)
    np.testing.assert_allclose(line.direction, [0, 1, 0])
    assert line.length == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("points", "tolerance", "message"),
    [
        ([[0, 0, 0]], 0.01, r"two points or more, as an array \(n, 3\), this is \(1, 3\)"),
        (np.zeros((4, 2)), 0.01, "two points or more"),
        (np.zeros(3), 0.01, "two points or more"),
        (np.zeros((3, 3)), 0.01, "all points of the line are the same"),
        ([[0, 0, 0], [1, np.nan, 0]], 0.01, "must be a finite number"),
        ([[0, 0, 0], [1, np.inf, 0]], 0.01, "must be a finite number"),
        ([[0, 0, 0], [1e101, 0, 0]], 0.01, "must be a finite number up to 1e.100"),
        ([[0, 0, 0], [1, 0, 0]], 0.0, "tolerance of a line must be a positive number, this is 0.0"),
        ([[0, 0, 0], [1, 0, 0]], np.nan, "tolerance of a line"),
        ([[0, 0, 0], [1, 0, 0]], "1", "tolerance of a line"),
        ([[0, 0, 0], [1, 0, "along"]], 0.01, "a line is fitted to points"),
        ([[0, 0, 0], [1, 0, [2]]], 0.01, "a line is fitted to points"),
        ([[0, 0, 0], [1, 0, 1j]], 0.01, "a line is fitted to points"),
        ([[0, 0, 0], [1, 0, 10**400]], 0.01, "a line is fitted to points"),
    ],
)
def test_what_is_no_line_is_refused(points, tolerance, message):
    with pytest.raises(ExplorationError, match=message):
        fit_line(points, tolerance)


@pytest.mark.parametrize("seed", [float("nan"), "1", None, 1.5])
def test_the_seed_of_a_line_is_a_whole_number(seed):
    with pytest.raises(ExplorationError, match="the seed of a line must be a whole number"):
        fit_line([[0, 0, 0], [1, 0, 0]], seed=seed)


@pytest.mark.parametrize("dimensions", range(1, 7))
def test_haltons_sequence_is_that_of_scipy(dimensions):
    from scipy.stats import qmc

    expected = qmc.Halton(dimensions, scramble=False).random(300)[1:]  # scipy begins with the origin
    found = np.array([halton(index, dimensions) for index in range(299)])
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_halton_spreads_from_the_first_points_on():
    shares = np.sort([halton(index)[0] for index in range(20)])
    assert np.diff(np.concatenate([[0.0], shares, [1.0]])).max() < 0.08


@pytest.mark.parametrize(
    ("index", "dimensions"), [(-1, 1), (0, 0), (0, 7), (1.5, 1), (0, 1.5), (True, 1), (0, 1j), (0, None)]
)
def test_halton_has_an_index_from_zero_and_one_to_six_dimensions(index, dimensions):
    with pytest.raises(ExplorationError, match="index from 0 on and 1 to 6 dimensions"):
        halton(index, dimensions)
