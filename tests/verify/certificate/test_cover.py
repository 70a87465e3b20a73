"""Covering: what parts hold between them is covered, what they leave out is found, however narrow."""

import numpy as np
import pytest

from kabo.verify.certificate.cover import covered, faces_of, outside, uncovered
from tests.verify.certified import CUBE, FACES


def halves(gap: float) -> list[np.ndarray]:
    """A slightly larger cube in two halves that overlap by `-gap`."""
    cube = CUBE * (1 + 1e-8)
    left, right = cube.copy(), cube.copy()
    left[left[:, 0] > 0, 0], right[right[:, 0] < 0, 0] = -gap / 2, gap / 2
    return [left, right]


def test_a_part_that_is_larger_covers_its_body():
    assert uncovered(CUBE, FACES, [CUBE * (1 + 1e-8)]) is None


def test_triangles_across_the_seam_of_two_parts_are_covered_by_both():
    assert uncovered(CUBE, FACES, halves(-1e-8)) is None


@pytest.mark.parametrize("gap", [1e-9, 1e-6, 0.1])
def test_a_gap_between_parts_is_found(gap):
    index = uncovered(CUBE, FACES, halves(gap))
    assert index is not None and np.ptp(CUBE[FACES[index], 0]) > 0.5


def test_a_missing_part_and_no_parts_at_all_are_found():
    assert uncovered(CUBE, FACES, halves(-1e-8)[:1]) is not None
    assert uncovered(CUBE, FACES, []) == 0


def test_a_part_without_volume_holds_nothing():
    assert faces_of(CUBE[CUBE[:, 0] < 0]) is None
    assert faces_of(np.zeros((1, 3))) is None


@pytest.mark.parametrize("seed", range(20))
def test_what_is_cut_off_is_what_is_outside(seed):
    """Areas add up, and no piece that is cut off has its middle in the part."""
    rng = np.random.default_rng(seed)
    part = faces_of(rng.normal(size=(12, 3)))
    triangle = rng.normal(size=(3, 3)) * 1.5
    pieces = outside(triangle, part)

    def area(polygon):
        first, rest = polygon[0], polygon[1:]
        cross = sum(np.cross(a - first, b - first) for a, b in zip(rest, rest[1:], strict=False))
        return float(np.linalg.norm(cross)) / 2

    weights = rng.dirichlet(np.ones(3), size=4000)
    inside = ((weights @ triangle) @ part.normals.T <= part.offsets).all(axis=1).mean()
    assert sum(map(area, pieces)) == pytest.approx(area(triangle) * (1 - inside), abs=0.05 * area(triangle))
    for piece in pieces:
        assert not (piece.mean(axis=0) @ part.normals.T <= part.offsets - 1e-9).all()
    assert covered(triangle, [part]) == (not pieces)


@pytest.mark.parametrize("size", [1e-3, 0.01, 0.1, 1.0])
@pytest.mark.parametrize("place", [0.0, 0.5])
def test_parts_that_enclose_a_small_body_as_tightly_as_kabo_makes_them_cover_it(size, place):
    """Parts are made at unit size: the smaller the body, the less they stand off it."""
    body = CUBE * size + place
    assert uncovered(body, FACES, [CUBE * size * (1 + 2e-9) + place]) is None
    assert uncovered(body, FACES, [CUBE * size * (1 - 2e-9) + place]) == 0
