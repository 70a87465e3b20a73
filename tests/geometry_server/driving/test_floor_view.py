"""A base over the edge of its floor collides, as everything that collides does: at a place and on a way."""

import numpy as np

from kabo.geometry_server import GeometryServer
from tests.domains.scenes import DOMAINS, scene_of

SCENE = scene_of(DOMAINS / "waiter" / "two_cups.yaml")
HOME = np.array(SCENE.start.robots["waiter"])
EDGE = 1.6 - 0.19  # half of the hall's width, less half of the platform's length in y


def at(x: float, y: float, yaw: float = 0.0) -> np.ndarray:
    """The waiter at home in its arm, with the base at a pose."""
    return np.concatenate([[x, y, yaw], HOME[3:]])


def test_the_pair_of_the_base_and_its_floor_is_named_last() -> None:
    workspace = GeometryServer(SCENE)._workspace("waiter", None)
    hit = workspace.first_hit(at(-0.5, -EDGE - 0.01))
    assert hit == ("waiter.base_link", "hall") == workspace.pairs[-1]
    assert workspace.first_hit(at(-0.5, -EDGE + 0.001)) is None


def test_a_turn_sweeps_corners_over_an_edge_that_both_ends_keep_from() -> None:
    workspace = GeometryServer(SCENE)._workspace("waiter", None)
    start, goal = at(-0.5, -EDGE + 0.001), at(-0.5, -EDGE + 0.001, np.pi)
    assert list(workspace.hits(np.array([start, goal]))) == [-1, -1]
    found = workspace.segment_hit(start, goal)
    assert workspace.pairs[found] == ("waiter.base_link", "hall")
    assert workspace.segment_hit(start, at(-0.9, -EDGE + 0.001)) == -1


def test_what_else_collides_is_told_before_the_floor() -> None:
    workspace = GeometryServer(SCENE)._workspace("waiter", None)
    assert "column" in (workspace.first_hit(at(0.75, -0.2)) or ())


def test_what_is_free_early_keeps_the_base_on_its_floor_with_what_it_strays() -> None:
    workspace = GeometryServer(SCENE)._workspace("waiter", None)
    near, turned, away = at(-0.5, -EDGE + 0.001), at(-0.5, -EDGE + 0.001, np.pi), at(-0.9, -EDGE + 0.001)
    starts, ends = np.array([near, near, near]), np.array([away, turned, away])
    strays = np.zeros_like(starts)
    strays[2, 1] = 0.01  # over the edge
    assert workspace.segments_free_early(starts, ends, strays).tolist() == [True, False, False]
    assert (workspace.segments_hit(starts, ends, strays) < 0).tolist() == [True, False, False]
