"""The proof that a motion keeps a constraint, and the way back onto it; the law itself is in tests/properties."""

import numpy as np
import pinocchio as pin
import pytest

from kabo.kinematics import FrameFeature, keeps, projector, rows_of, seeds, stacked, unkept_row, values
from kabo.kinematics.kernels import motion_bounds as kernels
from kabo.kinematics.motion_constraints import INTERVAL_INSET
from kabo.streams import stream_key
from tests.kinematics.trees import planar, seven_axes, twin, two_arms

ARM = seven_axes()
TREE = ARM.tree
READY = np.array([0.0, 0.2, 0.1, -1.9, 0.1, 2.2, 0.5])
AXIS, UP = FrameFeature(7, "line", (0, 0, 0.2), (0, 0, -1)), FrameFeature(0, "line", (0, 0, 0), (0, 0, 1))
UPRIGHT = rows_of("angle", AXIS, UP, upper=np.deg2rad(10))
ALL = np.ones(7, bool)


def test_a_wrist_that_turns_about_the_vertical_keeps_upright_and_an_elbow_does_not():
    (upright,) = (projector(TREE, UPRIGHT, TREE.lower, TREE.upper, ALL)(READY),)
    turned, bent = upright + np.eye(7)[0], upright + 0.5 * np.eye(7)[5]
    assert keeps(TREE, UPRIGHT, upright, turned)
    assert not keeps(TREE, UPRIGHT, upright, bent)


def test_a_violation_in_the_middle_only_is_found():
    """Both ends of a swing of the planar arm are at height 0, the way between is not."""
    arm = planar(1, limits=4.0)
    low = rows_of(
        "height", FrameFeature(1, "point", (1, 0, 0)), FrameFeature(0, "plane", (0, 0, 0), (0, 1, 0)), upper=0.5
    )
    assert not keeps(arm.tree, low, [0.0], [np.pi])
    assert keeps(arm.tree, low, [0.0], [-np.pi])


def test_the_proof_is_sharp_to_a_thousandth():
    """A swing that just stays below its bound is proven; one that just does not is refused."""
    arm = planar(1, limits=4.0)
    tip, floor = FrameFeature(1, "point", (1, 0, 0)), FrameFeature(0, "plane", (0, 0, 0), (0, 1, 0))
    for top, kept in ((0.9995, True), (0.9985, False)):
        assert keeps(arm.tree, rows_of("height", tip, floor, upper=top), [0.0], [np.pi], 1e-3) == kept


def test_a_distance_is_kept_on_the_circle_that_its_chord_leaves():
    arm = planar(1, limits=4.0)
    tip, centre = FrameFeature(1, "point", (1, 0, 0)), FrameFeature(0, "point", (0, 0, 0))
    assert keeps(arm.tree, rows_of("distance", tip, centre, 1.0, 1.0), [-3.0], [3.0], 1e-4)
    assert keeps(arm.tree, rows_of("distance", tip, UP, 1.0, 1.0), [-3.0], [3.0], 1e-4)


def crossed_swings():
    """Two joints at the origin that turn against each other, one under each feature."""
    still = pin.SE3.Identity()
    return twin([(0, 0, still, 0, 1.0, 0.0), (0, 0, still, 1, 1.0, 0.0)])


@pytest.mark.parametrize("changes", [(0.3, 0.0), (0.0, 0.3), (0.2, -0.3)])
def test_the_second_order_bound_is_attained_by_a_swing_of_either_frame_or_of_both(changes):
    """A point at distance 1 leaves its chord by 1 - cos(half the relative turn): the bound for small turns."""
    tree = crossed_swings().tree
    row = rows_of("distance", FrameFeature(1, "point", (1, 0, 0)), FrameFeature(2, "point", (0, 0, 0)), 0.0, 2.0)[
        0
    ]
    bound = kernels.curvature(row, tree, np.zeros(2), np.array(changes)) / 8.0
    half = 0.5 * abs(changes[0] - changes[1])
    assert 0.98 * bound <= 1.0 - np.cos(half) <= bound


def test_a_tool_upside_down_is_not_kept_aligned():
    arm = planar(1)
    tip, up = FrameFeature(1, "line", (0, 0, 0), (1, 0, 0)), FrameFeature(0, "line", (0, 0, 0), (1, 0, 0))
    assert keeps(arm.tree, rows_of("aligned", tip, up), [-1e-4], [1e-4])
    assert not keeps(arm.tree, rows_of("aligned", tip, up), [np.pi - 1e-4], [np.pi + 1e-4])
    assert keeps(arm.tree, rows_of("parallel", tip, up), [np.pi - 1e-4], [np.pi + 1e-4])


def test_joints_that_both_frames_hang_on_do_not_count():
    arms = two_arms(2)
    first, second = FrameFeature(8, "point", (0, 0, 0)), FrameFeature(15, "point", (0, 0, 0))
    q = np.zeros(arms.tree.size)
    gap = values(rows_of("distance", first, second, 0.0, 9.0), q, arms.tree)[0]
    rows = rows_of("distance", first, second, gap, gap)
    assert keeps(arms.tree, rows, q, q + 2.0 * np.eye(arms.tree.size)[0], 1e-8)


def test_the_row_that_fails_is_named():
    rows = stacked([rows_of("distance", FrameFeature(7, "point", (0, 0, 0)), UP, upper=5.0), UPRIGHT])
    upright = projector(TREE, UPRIGHT, TREE.lower, TREE.upper, ALL)(READY)
    assert unkept_row(TREE, rows, upright, upright) is None
    assert unkept_row(TREE, rows, upright, upright + 0.5 * np.eye(7)[5]) == 1


def test_a_tolerance_of_nothing_ends_the_proof_and_not_the_program():
    lateral = rows_of(
        "height", FrameFeature(7, "point", (0, 0, 0)), FrameFeature(0, "plane", (0, 0, 0), (0, 0, 1)), upper=0.5
    )
    assert not keeps(TREE, lateral, READY, READY + 0.1, -1.0)
    assert keeps(TREE, stacked([]), READY, READY + 0.1)


def test_the_projector_aims_inside_and_stays_within_limits():
    pull = projector(TREE, UPRIGHT, TREE.lower, TREE.upper, ALL)
    found = [pull(q) for q in seeds(TREE.lower, TREE.upper, stream_key("pull"), 0, 60)]
    arrived = [q for q in found if q is not None]
    assert len(arrived) > 40
    for q in arrived:
        assert values(UPRIGHT, q, TREE)[0] <= np.deg2rad(10)
        assert np.all((TREE.lower <= q) & (q <= TREE.upper))
    assert np.median([values(UPRIGHT, q, TREE)[0] for q in arrived]) <= np.deg2rad(10) - 0.5 * INTERVAL_INSET


def test_what_cannot_be_kept_or_does_not_fit_is_refused():
    azimuth = rows_of("azimuth", AXIS, UP)
    with pytest.raises(ValueError, match="azimuth"):
        keeps(TREE, azimuth, READY, READY)
    with pytest.raises(ValueError, match="finite"):
        keeps(TREE, UPRIGHT, READY, READY * np.nan)
    with pytest.raises(ValueError, match="limits and mask"):
        projector(TREE, UPRIGHT, TREE.lower[:3], TREE.upper, ALL)


def test_the_proof_runs_as_plain_python_with_the_same_answer():
    run = kernels.first_row_not_kept
    slack = np.full(1, 1e-3)
    for end in seeds(READY - 0.2, READY + 0.2, stream_key("plain"), 0, 6):
        arguments = UPRIGHT, slack, READY, end, TREE, kernels.pieces_of(1, len(TREE.parent), TREE.size)
        assert run(*arguments) == run.py_func(*arguments)
    for kernel in (kernels.curvature,):
        arguments = UPRIGHT[0], TREE, READY, READY + 0.3
        assert kernel(*arguments) == pytest.approx(kernel.py_func(*arguments), abs=1e-15)
