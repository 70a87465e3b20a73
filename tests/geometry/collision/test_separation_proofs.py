"""Proofs along paths: what they say, where there is none, and the order of parts."""

import numpy as np
import pytest

from kabo.geometry import Budget, Enclosure
from kabo.geometry.collision import separation_proofs
from kabo.geometry.collision.kernels.witness import prove_pairs
from kabo.geometry.collision.separation_proofs import Course, PlacedBody, Prover, Unproven, ordered
from kabo.scene import KinematicTree
from kabo.scene.transforms import flat, transform

CUBE = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05)])
CLEARANCE = Budget.share(0.01).clearance
NEAR = 0.01


def slide() -> KinematicTree:
    """One sliding joint along z, then one that turns about z."""
    whole = np.eye(3).ravel()
    rows = np.array([[*whole, 0, 0, 0], [*whole, 0, 0, 0], [*whole, 0.0, 0.0, 0.0]])
    return KinematicTree(
        np.array([0, 0, 1]), np.array([0, 1, 0]), np.array([0, 0, 1]), np.array([0.0, 1, 1]), np.zeros(3), rows,
        np.array([-2.0, -3.0]), np.array([2.0, 3.0]), np.ones(2),
    )  # fmt: skip


def course(*waypoints, at=(0.0, 0.0, 0.5), parts=1) -> tuple[Prover, Course]:
    """A cube on the last joint, 0.2 m off its axis, and one that stands; each in so many parts."""
    pieces = []
    for k in range(parts):
        piece = CUBE.copy()
        piece[:, 0] = np.where(piece[:, 0] < 0, -0.05 + 0.1 * k / parts, -0.05 + 0.1 * (k + 1) / parts)
        pieces.append(piece)
    prover = Prover({"cube": ordered(Enclosure(tuple(pieces), 0.0))}, NEAR, CLEARANCE)
    bodies = [PlacedBody("cube", 2, flat(transform((0.2, 0, 0)))), PlacedBody("cube", 0, flat(transform(at)))]
    return prover, Course(slide(), np.array(waypoints, dtype=float), bodies, np.array([[0, 1, 0]], np.int64))


def proven(*waypoints, gap=None, **more):
    """The proofs; of a `gap` [m] just as much is wanted as boxes do not leave, for they keep a nanometre to spare."""
    prover, path = course(*waypoints, **more)
    return prover.prove(path, None if gap is None else np.array([gap - 5e-10]))


def test_what_boxes_settle_needs_no_proof():
    assert proven([0, 0], [1, 0], at=(0.0, 0.0, 0.5)) == [None]
    assert proven([0, 0], [0, 0], at=(0.2, 0.0, 0.12)) == [None], "what does not move needs none"


def test_one_axis_proves_a_whole_path_beside_a_body():
    path = [0, 0], [0.4, 0.0], [0.8, 0.0], [1.0, 0.0]
    (found,) = proven(*path, at=(0.305, 0.0, 0.5), gap=0.005)
    assert found.walk == "a" and len(found.axes) == 6
    assert 0.0045 < found.margin <= 0.005 + 1e-9


def test_boxes_that_leave_what_is_wanted_need_no_axis_and_their_gap_is_the_margin():
    prover, path = course([0, 0], [1.0, 0.0], at=(0.305, 0.0, 0.5))
    found = prover.arrays(path, np.array([0.004]))
    assert found.sizes.tolist() == [0] and 0.005 - 2e-9 < found.margins[0] < 0.005


def test_a_path_around_a_body_is_halved():
    (found,) = proven([0.5, 0.7], [0.5, 2.9], at=(0.0, 0.0, 0.5))
    assert "t" in found.walk and set(found.walk) <= set("abet") and found.margin > 0.9 * CLEARANCE


def test_a_body_in_parts_is_proven_as_a_whole_if_that_will_do():
    (found,) = proven([0, 0], [1.0, 0.0], at=(0.305, 0.0, 0.5), parts=4, gap=0.005)
    assert found.walk == "a"


def test_where_bodies_meet_there_is_none_and_the_place_is_told():
    found = proven([0, 0], [1, 0], at=(0.2, 0.0, 0.5))
    assert isinstance(found, Unproven) and found.pair == 0
    assert 0.38 < found.start <= found.end < 0.62 and found.gap < 0.0


@pytest.mark.parametrize("gap", [1.2 * CLEARANCE, 0.5 * CLEARANCE, 1e-6])
def test_narrow_passages_are_proven_down_to_rounding(gap):
    (found,) = proven([0, 0], [1, 0], at=(0.3 + gap, 0.0, 0.5), gap=gap)
    assert 0.5 * gap < found.margin <= gap + 1e-12  # rounding of where it stands


@pytest.mark.parametrize("turn", np.linspace(0.1, 0.7, 7))
def test_no_margin_is_lost_below_the_distance_from_which_on_it_is_not_told(turn):
    long = CUBE * (1.0, 100.0, 100.0)  # five metres: an axis in short integers loses a good share of a millimetre
    prover = Prover({"wall": ordered(Enclosure((long,), 0.0))}, NEAR, CLEARANCE)
    there = np.array([np.cos(turn), np.sin(turn), 0.0])
    turned = [
        flat(transform(place, (0.0, 0.0, np.sin(turn / 2), np.cos(turn / 2))))
        for place in (0.0 * there, 0.11001 * there)
    ]
    bodies = [PlacedBody("wall", 2, turned[0]), PlacedBody("wall", 0, turned[1])]
    path = Course(slide(), np.array([[0.0, 0.0], [0.1, 0.0]]), bodies, np.array([[0, 1, 0]], np.int64))
    (found,) = prover.prove(path, np.array([NEAR]))
    assert found is not None and found.margin >= NEAR


def test_the_kernel_is_its_own_python_original(monkeypatch):
    prover, path = course([0.5, 0.7], [0.4, 1.0], [0.5, 1.6], at=(0.0, 0.0, 0.45), parts=3)
    compiled = prover.prove(path)
    monkeypatch.setattr(separation_proofs, "prove_pairs", prove_pairs.py_func)
    assert prover.prove(path) == compiled


def test_parts_are_ordered_so_that_neighbours_stand_together():
    rng = np.random.default_rng(1)
    places = rng.permutation(16)
    parts = ordered(Enclosure(tuple(CUBE + [0.2 * k, 0, 0] for k in places), 0.0))
    middles = np.array([part[:, 0].mean() for part in parts.vertices])
    assert sorted(middles) == pytest.approx(0.2 * np.arange(16))
    assert np.ptp(middles[:8]) < 1.5 and middles[:8].max() < middles[8:].min(), "halves lie apart"
    assert (parts.boxes[:, :3] <= parts.boxes[:, 3:]).all() and len(parts.packed.blocks) == len(
        parts.packed.sizes
    ) == 16
