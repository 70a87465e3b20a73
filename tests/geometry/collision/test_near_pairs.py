"""Which pairs come nearest along a path: the same as if each one were measured at each place."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.geometry import Enclosure
from kabo.geometry.collision.near_pairs import NearPairs
from kabo.geometry.collision.separation_proofs import Course, PlacedBody, Prover, ordered
from kabo.scene.transforms import flat, transform
from tests.geometry.collision.test_separation_proofs import CLEARANCE, CUBE, slide
from tests.support.oracles import coal_distance, healthy_hull

FAR = 1.0


def near_pairs(
    gaps, scopes=None, caps=(FAR,), waypoints=((0.0, 0.0), (1.0, 0.0)), above: tuple[float, ...] | None = None
) -> NearPairs:
    """A cube that slides upwards, cubes beside its way at some distances, and one that stands `above` it."""
    prover = Prover({"cube": ordered(Enclosure((CUBE,), 0.0))}, FAR, CLEARANCE)
    beside = [PlacedBody("cube", 0, flat(transform((0.3 + gap, 0.0, 0.5)))) for gap in gaps]
    beside += [] if above is None else [PlacedBody("cube", 0, flat(transform(above)))]
    bodies = [PlacedBody("cube", 2, flat(transform((0.2, 0, 0)))), *beside]
    pairs = np.array([[0, k, 0] for k in range(1, len(bodies))], np.int64)
    numbers = np.zeros(len(bodies), np.int64) if scopes is None else np.array([0, *scopes])
    return NearPairs(prover, Course(slide(), np.array(waypoints), bodies, pairs), numbers, np.array(caps))


def settled(measured: NearPairs) -> list[int]:
    """The pairs that are looked at, settled one after the other with what was measured."""
    order = []
    while (pair := measured.next()) is not None:
        order.append(pair)
        measured.settle(pair, measured.distance(pair))
    return order


def test_the_nearest_pair_decides_and_of_others_no_more_is_wanted():
    measured = near_pairs([0.03, 0.01, 0.4, 0.02])
    assert settled(measured) == [1]
    np.testing.assert_allclose(measured.wanted(), 0.01, rtol=0.03)


def test_a_pair_whose_parts_stuck_out_leaves_the_decision_to_the_next_one():
    measured = near_pairs([0.03, 0.01, 0.4, 0.02])
    assert measured.next() == 1
    measured.settle(1, 0.025)  # as after parts were refined
    assert settled(measured) == [3]
    np.testing.assert_allclose(measured.wanted(), [0.02, 0.025, 0.02, 0.02], rtol=0.03)


def test_the_least_distance_of_each_object_is_looked_at_unless_a_branch_has_a_lesser_one():
    assert settled(near_pairs([0.03, 0.01, 0.4, 0.02], [1, 2, 0, 3], (FAR, FAR, FAR, FAR))) == [1, 3, 0]
    assert settled(near_pairs([0.03, 0.01, 0.4, 0.02], [1, 2, 0, 3], (FAR, 0.005, FAR, FAR))) == [1, 3]


def test_bodies_that_do_not_move_decide_nothing():
    assert settled(near_pairs([0.03, 0.01], waypoints=((0.0, 0.0), (0.0, 0.0)))) == []


@pytest.mark.parametrize("bend", range(197, 206))
def test_where_bodies_come_nearest_on_a_long_way_is_not_passed_over(bend):
    away, rise = 0.2, 0.01  # of each piece [m] around the bend, where the cubes come nearest
    heights = -away - rise * np.abs(np.arange(400.0) - bend)
    measured = near_pairs([], waypoints=np.stack([heights, np.zeros(400)], axis=1), above=(0.2, 0.0, 0.1))
    pair = measured.next()
    assert pair is not None and away - 1e-9 <= measured.distance(pair) <= 1.03 * (away + 2 * rise)


@given(st.integers(0, 2**32 - 1), st.integers(2, 2000))
def test_along_a_random_way_the_least_distance_is_found_wherever_it_is(seed, pieces):
    random = np.random.default_rng(seed)
    knots = np.unique(random.integers(0, pieces + 1, 8))  # the cube comes near at each second one, and turns back
    peaks = np.where(np.arange(len(knots)) % 2 == 0, random.uniform(-0.4, -0.1, len(knots)), -1.0)
    heights = np.interp(np.arange(pieces + 1.0), knots, peaks)
    angles = np.interp(np.arange(pieces + 1.0), knots, random.uniform(-0.5, 0.5, len(knots)))
    waypoints = np.stack([heights, angles], axis=1)
    measured = near_pairs([], waypoints=waypoints, above=(0.2, 0.0, 0.1))
    cube = healthy_hull(CUBE)
    true = min(coal_distance(cube, carried(*at), cube, transform((0.2, 0.0, 0.1))) for at in waypoints)
    pair = measured.next()
    if pair is None:
        assert true >= FAR or np.ptp(waypoints, axis=0).max() == 0.0
        return
    # Way points are looked at, or places between them, at most four pieces apart: that far the cube comes unseen.
    unseen = 2 * np.linalg.norm(np.diff(waypoints, axis=0) * (1.0, 0.3), axis=1).max()
    assert 0.97 * true - 1e-9 <= measured.distance(pair) <= 1.03 * (true + unseen)


def carried(height: float, angle: float) -> np.ndarray:
    """The pose of the cube that slides and turns."""
    cosine, sine = np.cos(angle), np.sin(angle)
    pose = transform((0.2 * cosine, 0.2 * sine, height))
    pose[:2, :2] = [[cosine, -sine], [sine, cosine]]
    return pose
