"""The laws of rounded corners: near the straight path both ways, ends and rests exact, no jump of the direction."""

from math import factorial

import numpy as np
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.motion import Blended, blended

ROUNDING = 1e-9


@st.composite
def corners(draw: st.DrawFn) -> np.ndarray:
    """Paths of pieces from a milliradian to two radians that turn anyhow, some of them back."""
    joints, pieces = draw(st.integers(1, 7)), draw(st.integers(1, 8))
    number = st.floats(-1.0, 1.0, width=32)
    found, way = [np.zeros(joints)], np.eye(joints)[0]
    for _ in range(pieces):
        # Strokes turn little from piece to piece; where phases meet they turn far.
        turn = draw(st.sampled_from([0.02, 0.3, 2.0]))
        way = way + turn * np.array(draw(st.lists(number, min_size=joints, max_size=joints)))
        norm = np.linalg.norm(way)
        way = way / norm if norm > 1e-3 else np.eye(joints)[0]
        found.append(found[-1] + draw(st.sampled_from([1e-3, 0.02, 0.1, 0.5, 2.0])) * way)
    return np.array(found)


def shares(count: int) -> st.SearchStrategy[list[float]]:
    return st.lists(st.sampled_from([0.0, 0.1, 0.5, 1.0, 1.0, 1.0]), min_size=count, max_size=count)


@st.composite
def cases(draw: st.DrawFn) -> tuple[np.ndarray, float, list[float], Blended]:
    points = draw(corners())
    deviation = draw(st.sampled_from([0.0, 1e-3, 0.02, 0.05, 0.3]))
    given_shares = draw(shares(len(points)))
    return points, deviation, given_shares, blended(points, deviation, given_shares)


def dense(path: Blended) -> np.ndarray:
    """Places that lie densely along pieces of any length, with all borders and corners."""
    cuts = np.unique(np.concatenate([path.borders, path.places]))
    return np.unique(np.concatenate([np.linspace(a, b, 33) for a, b in zip(cuts, cuts[1:], strict=False)]))


def away(points: np.ndarray, path: np.ndarray) -> float:
    """The greatest distance of points from a path of straight pieces."""
    starts, ways = path[:-1], np.diff(path, axis=0)
    squares = np.maximum((ways * ways).sum(axis=1), 1e-24)
    steps = points[:, None] - starts
    parts = np.clip((steps * ways).sum(axis=2) / squares, 0.0, 1.0)
    return float(np.linalg.norm(steps - parts[..., None] * ways, axis=2).min(axis=1).max())


@given(case=cases())
def test_neither_path_is_farther_from_the_other_than_the_deviation(case) -> None:
    points, deviation, _, path = case
    s = dense(path)
    there, straight = path.at(s), path.straight(s)
    event(f"reaches over a corner: {bool((path.trims[1:-1] > np.minimum(*_pieces(points))).any())}")
    assert np.linalg.norm(there - straight, axis=1).max() <= deviation + ROUNDING
    assert away(there, points) <= deviation + ROUNDING
    assert away(straight, there) <= deviation + ROUNDING


def _pieces(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return lengths[:-1], lengths[1:]


@given(case=cases())
def test_ends_and_rests_are_reached_exactly_and_nothing_reaches_over_them(case) -> None:
    points, _, given_shares, path = case
    rests = [0, *(i for i in range(1, len(points) - 1) if given_shares[i] == 0.0), len(points) - 1]
    assert np.allclose(path.at(path.places[rests]), points[rests], rtol=0.0, atol=1e-11)
    assert path.at(0.0).tobytes() == points[0].tobytes()
    for low, high in zip(rests, rests[1:], strict=False):
        inner = slice(low + 1, high)
        assert (path.places[inner] - path.trims[inner] >= path.places[low] - ROUNDING).all()
        assert (path.places[inner] + path.trims[inner] <= path.places[high] + ROUNDING).all()
    assert all(path.trims[i] == 0.0 for i in rests)


@given(case=cases())
def test_the_direction_jumps_only_where_the_path_rests(case) -> None:
    _, deviation, given_shares, path = case
    turning = [i for i in range(1, len(path.places) - 1) if given_shares[i] == 0.0 or deviation == 0.0]
    low, high = path.borders[:-1], path.borders[1:]
    steps = (high - low)[:, None]
    # At the end of each piece, by the Taylor series of its beginning.
    before = sum(path.at(low, order + 1) * steps**order / factorial(order) for order in range(4))
    jumps = np.linalg.norm(path.at(low[1:], 1) - before[:-1], axis=1)
    rests = (np.abs(low[1:, None] - path.places[turning]) <= 2e-9).any(axis=1)
    assert (jumps[~rests] <= 1e-5).all()


@given(case=cases())
def test_derivatives_are_those_of_the_path(case) -> None:
    _, _, _, path = case
    low, high = path.borders[:-1], path.borders[1:]
    middle, step = (low + high) / 2, (high - low) / 4
    slope = (path.at(middle + step) - path.at(middle - step)) / (2 * step)[:, None]
    assert np.allclose(slope - (step**2)[:, None] / 6 * path.at(middle, 3), path.at(middle, 1), atol=1e-6)
    there = sum(path.at(low, order) * (high - low)[:, None] ** order / factorial(order) for order in range(5))
    assert np.allclose(there, path.at(high), atol=1e-8)


@given(
    turn=st.floats(0.7, 1.99),
    deviation=st.sampled_from([1e-3, 0.02, 0.05]),
    short=st.lists(st.floats(0.01, 0.05), max_size=4),
)
def test_the_room_of_neighbours_that_do_not_turn_is_used(turn, deviation, short) -> None:
    """A sharp corner before short pieces in one line has the whole deviation, as if they were one piece."""
    angle = 2.0 * np.arcsin(turn / 2.0)
    way = np.array([np.cos(angle), np.sin(angle)])
    lengths = np.cumsum([*short, 2.0])
    path = blended([[-2.0, 0.0], [0.0, 0.0], *(length * way for length in lengths)], deviation)
    assert np.linalg.norm(path.at(path.corner(1))) >= 0.97 * deviation
