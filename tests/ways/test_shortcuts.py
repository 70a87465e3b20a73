"""Shortcuts keep the ends, prove every new piece, and never lengthen; the law is in tests/properties."""

import numpy as np

from kabo.streams import stream_key
from kabo.ways import shortcut
from kabo.ways.shortcuts import length
from tests.ways.worlds import LEFT, RIGHT, Discs, wall

KEY = stream_key("shortcut")
DETOUR = np.array([LEFT, [-1.5, 1.9], [-0.2, 1.3], [0.2, 1.2], [1.2, 1.9], [1.9, 0.5], RIGHT])


def test_a_detour_gets_shorter_and_stays_free():
    world = wall(gap=0.5)
    assert world.clearance(DETOUR) > 0
    short = shortcut(DETOUR, world.free_segment, KEY, 100, free_configurations=world.free_configurations)
    assert length(short) < 0.9 * length(DETOUR)
    assert world.clearance(short) > 0
    assert np.array_equal(short[[0, -1]], DETOUR[[0, -1]])


def test_without_obstacles_little_remains_of_a_detour():
    nothing = Discs(np.empty((0, 2)), np.empty(0))
    short = shortcut(DETOUR, nothing.free_segment, KEY, 100)
    assert length(short) < 1.05 * np.linalg.norm(RIGHT - LEFT)


def test_a_straight_path_and_no_attempts_are_left_alone():
    world = wall(gap=0.5)
    assert np.array_equal(shortcut(DETOUR[:2], world.free_segment, KEY, 50), DETOUR[:2])
    assert np.array_equal(shortcut(DETOUR, world.free_segment, KEY, 0), DETOUR)


def test_a_path_that_stands_still_is_left_alone():
    still = np.array([LEFT, LEFT, LEFT])
    assert np.array_equal(shortcut(still, lambda a, b: -1, KEY, 10), still)


def test_under_a_constraint_the_replacement_is_pulled_onto_it():
    """On a circle no chord is proven; small steps along the circle are, and cut off the way round."""

    def pull(q):
        return q / np.linalg.norm(q)

    def free_segment(q0, q1):
        return -1 if np.linalg.norm(0.5 * (q0 + q1)) > 0.99 else 0

    angles = np.concatenate([np.arange(0, 2.0, 0.1), np.arange(2.0, 1.0, -0.1)])
    path = np.round(np.stack([np.cos(angles), np.sin(angles)], axis=1), 9)
    short = shortcut(path, free_segment, KEY, 60, projection=pull)
    assert length(short) < 0.6 * length(path)
    assert all(free_segment(a, b) < 0 for a, b in zip(short, short[1:], strict=False))


def test_patience_ends_after_so_many_attempts_in_vain() -> None:
    asked = []

    def blocked(q0: np.ndarray, q1: np.ndarray) -> int:
        asked.append(1)
        return 0

    path = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]])
    assert np.array_equal(shortcut(path, blocked, KEY, 100, patience=5), path)
    assert 0 < len(asked) <= 5
