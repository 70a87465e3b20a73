"""Rank and null space say what a constraint takes away and what it leaves [K 5.2.2]."""

import numpy as np
import pytest

from kabo.kinematics import FrameFeature, joined, project, rows_of, sample, stacked, tangent, values
from kabo.streams import stream_key
from tests.kinematics.trees import planar, seven_axes

ARM = seven_axes().tree
FREE = np.ones(7, bool)
TIP, AXIS = FrameFeature(7, "point", (0, 0, 0.2)), FrameFeature(7, "line", (0, 0, 0.2), (0, 0, 1))
UP, TABLE = FrameFeature(0, "line", (0.4, 0.1, 0), (0, 0, 1)), FrameFeature(0, "plane", (0, 0, 0.3), (0, 0, 1))
TOP = FrameFeature(7, "plane", (0, 0, 0.2), (0, 0, 1))
GOAL = FrameFeature(0, "point", (0.45, 0.1, 0.4))
RANKS = [
    (("coincident", TIP, GOAL), 3),
    (("coincident", TIP, UP), 2),
    (("coincident", TIP, TABLE), 1),
    (("coincident", AXIS, UP), 4),
    (("coincident", TOP, TABLE), 3),
    (("parallel", AXIS, UP), 2),
    (("parallel", TOP, TABLE), 2),
    (("parallel", AXIS, TABLE), 1),
    (("perpendicular", TOP, TABLE), 1),
    (("distance", TIP, GOAL, 0.2, 0.2), 1),
    (("distance", TIP, UP, 0.2, 0.2), 1),
    (("distance", TIP, TABLE, 0.2, 0.2), 1),
    (("aligned", AXIS, UP), 2),
    (("opposed", AXIS, UP), 2),
    (("angle", AXIS, UP, 0.5, 0.5), 1),
    (("height", TIP, TABLE, 0.1, 0.1), 1),
]


def solutions(rows, tree=ARM, name="tangent"):
    free = np.ones(tree.size, bool)
    Q, right = sample(tree, rows, stream_key(name), 0, 60, tree.lower, tree.upper, free)
    assert right.sum() >= 3
    return Q[right][:8]


@pytest.mark.parametrize(("constraint", "rank"), RANKS)
def test_the_rank_is_the_number_of_degrees_of_freedom_that_a_constraint_takes(constraint, rank):
    rows = rows_of(*constraint)
    for q in solutions(rows):
        found = tangent(ARM, rows, q)
        assert (found.rank, found.freedom) == (rank, 7 - rank)
        assert np.allclose(found.basis.T @ found.basis, np.eye(7 - rank), atol=1e-12)


@pytest.mark.parametrize(("constraint", "rank"), RANKS)
def test_along_the_null_space_a_constraint_keeps_to_second_order_and_across_it_does_not(constraint, rank):
    rows = rows_of(*constraint)
    for q in solutions(rows)[:3]:
        found = tangent(ARM, rows, q)
        start = values(rows, q, ARM)
        for direction in found.basis.T:
            moved = [np.abs(values(rows, q + step * direction, ARM) - start).max() for step in (1e-2, 1e-3)]
            assert moved[1] <= 0.05 * moved[0] + 1e-8, "the change is not of second order"
        across = np.eye(7) - found.basis @ found.basis.T
        _, _, V = np.linalg.svd(across)
        assert all(np.abs(values(rows, q + 1e-3 * v, ARM) - start).max() > 1e-6 for v in V[:rank])


def test_rows_that_say_the_same_twice_count_once():
    once = stacked([rows_of("parallel", AXIS, UP), rows_of("coincident", TIP, TABLE)])
    twice = stacked([once, rows_of("coincident", TOP, TABLE), rows_of("aligned", UP, TABLE)])
    q = solutions(once)[0]
    first, second = tangent(ARM, once, q), tangent(ARM, twice, q, tolerance=1e-5)
    assert first.rank == second.rank == 3
    assert np.allclose(first.basis @ first.basis.T, second.basis @ second.basis.T, atol=1e-6)


def test_an_interval_counts_only_at_its_bound():
    tilt = rows_of("angle", AXIS, UP, upper=0.4)
    (inside,) = project(ARM, tilt, solutions(tilt)[:1], ARM.lower, ARM.upper, FREE, inset=0.1)[0]
    edge = rows_of("angle", AXIS, UP, upper=float(values(tilt, inside, ARM)[0]))
    assert tangent(ARM, tilt, inside).freedom == 7
    assert not tangent(ARM, tilt, inside).active.any()
    assert tangent(ARM, edge, inside).freedom == 6
    assert tangent(ARM, edge, inside).active.all()


def test_what_stands_still_is_not_counted_and_moves_in_no_direction():
    rows = rows_of("coincident", TIP, GOAL)
    moving = np.array([True, True, False, True, True, True, False])
    found = tangent(ARM, rows, solutions(rows)[0], moving)
    assert (found.rank, found.freedom) == (3, 2)
    assert np.all(found.basis[~moving] == 0.0)


def test_a_stretched_arm_loses_a_rank():
    chain = planar(3).tree
    tip = FrameFeature(3, "point", (1.0, 0, 0))
    rows = rows_of("coincident", tip, FrameFeature(0, "point", (3.0, 0, 0)))
    assert tangent(chain, rows, np.zeros(3)).rank == 1
    assert tangent(chain, rows, np.array([0.3, -0.6, 0.3])).rank == 2


def test_the_null_space_of_two_arms_holds_motions_of_both_together():
    """Two tools held together: six rows take six of fourteen, and some of what is left moves the tools."""
    both = joined([ARM, ARM._replace(placement=shifted(ARM.placement))])
    tool, other = TIP, both.feature(1, TIP)
    axes = [(FrameFeature(7, "line", (0, 0, 0.2), d), FrameFeature(7, "line", (0, 0, 0.2), e)) for d, e in PAIRS]
    rows = stacked(
        [rows_of("coincident", tool, other), *(rows_of("aligned", a, both.feature(1, b)) for a, b in axes)]
    )
    for q in solutions(rows, both.tree)[:3]:
        found = tangent(both.tree, rows, q)
        assert (found.rank, found.freedom) == (6, 8)
        place = tangent(both.tree, stacked([rows_of("coincident", tool, GOAL)]), q, tolerance=np.inf)
        still = np.abs(place.basis @ place.basis.T @ found.basis - found.basis).max(axis=0)
        assert still.max() > 1e-3, "nothing moves the tools"


PAIRS = (((0, 0, 1), (0, 0, -1)), ((1, 0, 0), (1, 0, 0)))


def shifted(placement):
    moved = placement.copy()
    moved[1, 9] += 0.8
    return moved
