"""Laws of exact signs: what a contraction relies on when it argues with tetrahedra, and triangles with their images."""

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kabo.geometry.triangles.kernels.crossing import triangles_cross
from kabo.geometry.triangles.kernels.orientation import SCRATCH_SIZE, orientation

SEEDS = st.integers(0, 2**32 - 1)
GRAINS = st.sampled_from([2.0**-40, 2.0**-3, 1.0])


def sign(*points):
    return orientation(np.array(points), 0, 1, 2, 3, np.empty(SCRATCH_SIZE))


def grid_points(seed, count, grain, steps=6):
    """Points with few bits, so that sums and differences of them are exact; often in a plane or on a line."""
    return np.random.default_rng(seed).integers(-steps, steps + 1, size=(count, 3)) * grain


def volume(a, b, c, d):
    """Six times the volume of a tetrahedron, in rational numbers."""
    u, v, w = ([Fraction(float(x)) - Fraction(float(y)) for x, y in zip(p, a, strict=True)] for p in (b, c, d))
    return sum(u[i] * (v[(i + 1) % 3] * w[(i + 2) % 3] - v[(i + 2) % 3] * w[(i + 1) % 3]) for i in range(3))


@given(seed=SEEDS, grain=GRAINS)
def test_the_sign_stays_when_all_points_move_alike_and_turns_in_a_mirror(seed, grain):
    points = grid_points(seed, 4, grain)
    expected = sign(*points)
    assert sign(*(points + grid_points(seed + 1, 1, 1024.0 * grain))) == expected
    assert sign(*(points * [1.0, -1.0, 1.0])) == -expected
    assert sign(*points[:, [1, 2, 0]]) == expected


@given(seed=SEEDS, grain=GRAINS)
def test_the_faces_of_a_tetrahedron_see_a_fifth_point_as_the_volumes_say(seed, grain):
    """[a b c d] = [e b c d] + [a e c d] + [a b e d] + [a b c e]: signs that cannot be together never come together."""
    a, b, c, d, e = grid_points(seed, 5, grain, 3)
    parts = [(e, b, c, d), (a, e, c, d), (a, b, e, d), (a, b, c, e)]
    signs, whole = [sign(*p) for p in parts], sign(a, b, c, d)
    assert sum(volume(*p) for p in parts) == volume(a, b, c, d)
    assert min(signs) <= whole <= max(signs)


@given(seed=SEEDS, scale=st.integers(-60, 40))
def test_a_rounded_point_of_a_plane_lies_on_the_side_that_rational_numbers_say(seed, scale):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(4, 3)) * 2.0**scale
    points[3] = points[0] + rng.random() * (points[1] - points[0]) + rng.random() * (points[2] - points[0])
    exact = volume(*points)
    assert sign(*points) == (exact > 0) - (exact < 0)


@given(seed=SEEDS, grain=GRAINS, shared=st.integers(0, 2))
def test_whether_triangles_cross_does_not_change_when_space_is_moved_mirrored_or_doubled(seed, grain, shared):
    pair = grid_points(seed, 6, grain, 3)
    pair[3 : 3 + shared] = pair[:shared]
    expected = triangles_cross(pair.copy(), shared, np.empty(SCRATCH_SIZE))
    move = grid_points(seed + 1, 1, 64.0 * grain)
    for image in (pair + move, pair * [-1.0, 1.0, 1.0], pair[:, [2, 0, 1]], 2.0 * pair, pair[[3, 4, 5, 0, 1, 2]]):
        # Without an area and with one shared vertex the answer may depend on the axes that are tried.
        normals = [np.cross(t[1] - t[0], t[2] - t[0]) for t in (pair[:3], pair[3:])]
        if shared != 1 or all(np.any(n) for n in normals):
            assert triangles_cross(np.ascontiguousarray(image), shared, np.empty(SCRATCH_SIZE)) == expected


@given(seed=SEEDS)
def test_a_point_of_both_triangles_is_never_overlooked(seed):
    """Corners of one triangle are pushed through a point of the other: rounding may miss it, the answer must not."""
    rng = np.random.default_rng(seed)
    first = rng.normal(size=(3, 3))
    weights = rng.dirichlet(np.ones(3)) * 0.9 + 0.1 / 3.0  # well inside
    middle, direction = weights @ first, rng.normal(size=3)
    second = np.array(
        [middle + direction, middle - rng.random() * direction - 1e-9 * direction, rng.normal(size=3)]
    )
    normal = np.cross(first[1] - first[0], first[2] - first[0])
    if abs(direction @ normal) > 1e-3 * np.linalg.norm(direction) * np.linalg.norm(normal):
        assert triangles_cross(np.concatenate([first, second]), 0, np.empty(SCRATCH_SIZE))
