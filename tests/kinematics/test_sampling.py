"""A sample is a function of its key and number; samples reach everywhere [K Definition 4]."""

import numpy as np
import pytest

from kabo.kinematics import (
    FrameFeature,
    project,
    rows_of,
    sample,
    satisfied,
    seeds,
    stacked,
    uniform,
    values,
)
from kabo.kinematics.kernels import streams
from kabo.kinematics.kernels.projection import project_seeds
from kabo.streams import stream_key
from tests.kinematics.trees import seven_axes

ARM = seven_axes()
TREE = ARM.tree
ALL = np.ones(7, bool)
TIP, APPROACH, CLOSING = (
    FrameFeature(7, "point", (0, 0, 0.2)),
    FrameFeature(7, "line", (0, 0, 0.2), (0, 0, 1)),
    FrameFeature(7, "line", (0, 0, 0.2), (0, 1, 0)),
)
AXIS, FOOT = (
    FrameFeature(0, "line", (0.5, 0.1, 0.3), (0, 0, 1)),
    FrameFeature(0, "plane", (0.5, 0.1, 0.3), (0, 0, 1)),
)
SIDE_GRASP = stacked(
    [
        rows_of("coincident", TIP, AXIS),
        rows_of("perpendicular", APPROACH, AXIS),
        rows_of("perpendicular", CLOSING, AXIS),
        rows_of("height", TIP, FOOT, 0.05, 0.12),
    ]
)
POINTING = stacked([rows_of("height", TIP, FOOT, 0.1, 0.1), rows_of("opposed", APPROACH, AXIS)])
SIDE, ACROSS = FrameFeature(7, "line", (0, 0, 0.2), (1, 0, 0)), FrameFeature(7, "plane", (0, 0, 0.2), (1, 0, 0))
KEY = stream_key("test", 7)


def draw(first, count, key=KEY, **more):
    return sample(TREE, SIDE_GRASP, key, first, count, TREE.lower, TREE.upper, ALL, **more)


def test_a_sample_alone_is_the_same_as_in_a_batch_in_any_order():
    Q, right = draw(0, 40)
    for i in (39, 0, 17, 5):
        q, one = draw(i, 1)
        assert np.array_equal(q[0], Q[i])
        assert one[0] == right[i]
    later, still = draw(20, 20)
    assert np.array_equal(later, Q[20:])
    assert np.array_equal(still, right[20:])


def test_rows_that_may_not_be_written_are_no_reason_to_compile_again():
    """A kernel is compiled once for each kind of array, and this one takes seconds."""
    rows = rows_of("coincident", TIP, AXIS)
    sample(TREE, rows, stream_key(1), 0, 1, TREE.lower, TREE.upper, ALL)
    known = list(project_seeds.signatures)
    fixed = np.frombuffer(rows.tobytes()).reshape(rows.shape)
    Q, _ = sample(TREE, fixed, stream_key(1), 0, 4, TREE.lower, TREE.upper, ALL)
    assert Q.shape == (4, 7) and list(project_seeds.signatures) == known


def test_another_key_gives_other_samples():
    assert not np.array_equal(draw(0, 5)[0], draw(0, 5, stream_key("test", 8))[0])


def test_intervals_are_filled_evenly():
    Q, right = draw(0, 800)
    heights = np.array([values(SIDE_GRASP, q, TREE)[-1] for q in Q[right]])
    assert np.all((heights >= 0.05 - 1e-6) & (heights <= 0.12 + 1e-6))
    counts, _ = np.histogram(heights, bins=7, range=(0.05, 0.12))
    assert counts.min() > 0.6 * counts.mean()


def test_free_rows_spread_what_the_constraints_leave_free():
    around = rows_of("azimuth", APPROACH, AXIS)

    def unevenness(free):
        Q, right = draw(0, 3000, free=free)
        angles = np.array([values(around, q, TREE)[0] for q in Q[right]])
        counts, _ = np.histogram(angles, bins=12, range=(-np.pi, np.pi))
        return counts.min() / counts.mean(), right.sum()

    (spread, count), (alone, _) = unevenness(around), unevenness(None)
    assert count > 100
    assert spread > 0.3
    assert spread > alone


def test_joints_that_are_not_active_keep_their_base():
    base = np.array([0.0, 0.3, 0.1, -1.2, 0.2, 1.0, 0.4])
    active = np.array([True, True, True, True, True, True, False])
    Q, right = sample(TREE, SIDE_GRASP[:2], KEY, 0, 20, TREE.lower, TREE.upper, active, base=base)
    assert right.any()
    assert np.all(Q[:, 6] == 0.4)


def test_a_base_that_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="base configuration"):
        draw(0, 1, base=np.zeros(3))


def test_seeds_of_unbounded_joints_take_one_turn():
    drawn = seeds([-np.inf, 0.0], [np.inf, 1.0], KEY, 0, 500)
    assert np.all((drawn[:, 0] >= -np.pi) & (drawn[:, 0] < np.pi))
    assert np.all((drawn[:, 1] >= 0.0) & (drawn[:, 1] < 1.0))
    assert np.ptp(drawn[:, 0]) > 6.0


def test_numbers_are_uniform_and_uncorrelated():
    u = np.array([[uniform(KEY, i, k) for k in range(3)] for i in range(4000)])
    assert np.all((u >= 0.0) & (u < 1.0))
    for k in range(3):
        counts, _ = np.histogram(u[:, k], bins=20, range=(0, 1))
        assert ((counts - 200) ** 2 / 200).sum() < 43.8  # chi-square, 19 degrees of freedom, 0.1 %
    assert np.abs(np.corrcoef(np.hstack([u[1:], u[:-1]]).T) - np.eye(6)).max() < 0.06


def test_streams_run_as_plain_python_with_the_same_bits():
    with np.errstate(over="ignore"):
        for i, k in [(0, 0), (1, 0), (0, 1), (123456789, 13)]:
            assert streams.uniform.py_func(KEY, np.int64(i), np.int64(k)) == streams.uniform(KEY, i, k)
            assert streams.stratified.py_func(KEY, i, k, 3) == pytest.approx(streams.stratified(KEY, i, k, 3))


def test_joints_that_end_outside_their_limits_return_to_their_seed_and_the_others_make_up_for_it():
    """More samples are right than without, none stops at a limit, and those that were right stay as they are."""
    drawn = seeds(TREE.lower, TREE.upper, KEY, 0, 400)
    plain, without = project(TREE, POINTING, drawn, TREE.lower, TREE.upper, ALL)
    Q, right = sample(TREE, POINTING, KEY, 0, 400, TREE.lower, TREE.upper, ALL)
    assert right.sum() >= 1.2 * without.sum()
    assert np.all(right[without])
    assert np.array_equal(Q[without], plain[without])
    assert all(satisfied(POINTING, q, TREE) for q in Q[right])
    assert np.all((TREE.lower < Q[right]) & (Q[right] < TREE.upper))
    returned = Q[right & ~without] == drawn[right & ~without]
    assert np.all(returned.any(axis=1)), "a sample was found with no joint where its seed had it"


def shares(found, low, high, bins):
    """How full each bin is, relative to the mean."""
    counts, _ = np.histogram(found, bins, (low, high))
    return counts / counts.mean()


RIM = stacked(
    [
        rows_of("distance", TIP, AXIS, 0.05, 0.05),
        rows_of("height", TIP, FOOT, 0.15, 0.15),
        rows_of("opposed", APPROACH, AXIS),
        rows_of("perpendicular", SIDE, AXIS),
        rows_of("coincident", FrameFeature(0, "point", AXIS.origin), ACROSS),
    ]
)
ANGLE = rows_of("azimuth", CLOSING, AXIS)
IN_REGION = [rows_of("height", TIP, FrameFeature(0, "plane", (0.45, 0, 0), (1, 0, 0)), -0.1, 0.1)]
ACROSS_TABLE = rows_of("height", TIP, FrameFeature(0, "plane", (0, 0, 0), (0, 1, 0)), -0.4, 0.4)


def drawn(rows, free=None, count=4000):
    Q, right = sample(TREE, rows, stream_key("even"), 0, count, TREE.lower, TREE.upper, ALL, free)
    return Q[right]


def test_every_angle_of_a_rim_grasp_is_hit_and_with_the_angle_aimed_at_about_equally_often():
    """[K Fig. 5.4b]: with the fingers swapped, all of ]-pi, pi] is covered; evening out takes the peak away."""
    plain = shares([values(ANGLE, q, TREE)[0] for q in drawn(RIM)], -np.pi, np.pi, 36)
    even = shares([values(ANGLE, q, TREE)[0] for q in drawn(RIM, ANGLE)], -np.pi, np.pi, 36)
    assert plain.min() > 0.0
    assert even.min() > plain.min()
    assert even.min() > 0.6
    assert even.max() < 1.3


def test_every_place_across_the_table_is_hit_and_with_a_region_about_equally_often():
    """[K Fig. 5.4a]: the y-coordinate on the table."""
    on_table = stacked([POINTING, *IN_REGION])
    found = np.array([values(ACROSS_TABLE, q, TREE)[0] for q in drawn(on_table)])
    plain = shares(found[np.abs(found) <= 0.4], -0.4, 0.4, 32)
    inside = stacked([on_table, ACROSS_TABLE])
    even = shares([values(ACROSS_TABLE, q, TREE)[0] for q in drawn(inside)], -0.4, 0.4, 32)
    assert plain.min() > 0.0
    assert even.min() > 0.8
    assert even.max() < 1.25


def test_every_cell_of_a_place_and_its_turn_is_hit():
    """Three free parameters at once: x, y and the turn of what is put down, 6 x 8 x 8 cells."""
    inside, turn = stacked([POINTING, *IN_REGION, ACROSS_TABLE]), rows_of("azimuth", CLOSING, AXIS)
    Q = drawn(inside, turn, 6000)
    found = np.array(
        [[*values(IN_REGION[0], q, TREE), *values(ACROSS_TABLE, q, TREE), *values(turn, q, TREE)] for q in Q]
    )
    counts, _ = np.histogramdd(found, (6, 8, 8), ((-0.1, 0.1), (-0.4, 0.4), (-np.pi, np.pi)))
    assert counts.min() >= 1


def test_aims_out_of_reach_cost_no_sample_that_is_right_without_them():
    far = rows_of("height", TIP, FOOT, 3.0, 3.1)
    Q, right = sample(TREE, POINTING, KEY, 0, 100, TREE.lower, TREE.upper, ALL, far)
    plain, also = sample(TREE, POINTING, KEY, 0, 100, TREE.lower, TREE.upper, ALL)
    assert np.array_equal(right, also)
    assert np.array_equal(Q[right], plain[right])
