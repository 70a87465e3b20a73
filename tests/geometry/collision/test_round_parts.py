"""Spheres, capsules and cylinders: one part each, whose gaps are known by construction; and what coal says of them."""

import coal
import numpy as np
import pytest

from kabo.geometry import Budget, CollisionView, Enclosure, FixedGroup, MovingGroup, collides, distance
from kabo.geometry.collision.kernels import separation
from kabo.geometry.collision.kernels.bundles import Hulls
from kabo.geometry.collision.kernels.distance import parts_distance
from kabo.geometry.collision.view_arrays import offset_for, search_for
from kabo.meshes import Rounding
from tests.geometry.worlds import slide
from tests.support.strategies import KINDS, placement_of, touching

ROUND = ("sphere", "capsule", "cylinder", "rounded hull", "everything")
MARGIN = 1e-3
NEAR = (-1e-4, -1e-9, 0.0, MARGIN - 1e-8, MARGIN - 1e-9)  # gaps at which nothing is free
FREE = (MARGIN + 1e-8, MARGIN + 1e-6, 0.009)  # gaps at which all is: epsilon is larger


def above(kind, rng):
    """A round part with z >= 0 that contains the origin: its corners and its rounding."""
    radius, disc = rng.choice([1e-4, 0.01, 0.3], 2) * rng.uniform(0.5, 1.0, 2)
    far = rng.uniform(-0.5, 0.5, (1, 3)) * [1, 1, 0] + [0, 0, rng.choice([0.0, 1e-9, 0.2])]
    if kind == "sphere":
        return np.zeros((1, 3)) + [0, 0, radius], Rounding(radius)
    if kind == "capsule":
        return np.concatenate([np.zeros((1, 3)), far]) + [0, 0, radius], Rounding(radius)
    if kind == "rounded hull":
        corners = rng.uniform(-0.3, 0.3, (12, 3))
        return np.concatenate([np.zeros((1, 3)), corners * [1, 1, 0] + abs(corners) * [0, 0, 1]]) + [
            0,
            0,
            radius,
        ], Rounding(radius)
    lean = rng.choice([0.0, 1e-12, 1e-7, 0.3, 1.0])  # upright, nearly so, and lying
    axis = rng.normal(size=3) * [lean, lean, 1.0 if lean < 1.0 else 0.0]
    axis /= np.linalg.norm(axis)
    across = np.hypot(axis[0], axis[1])  # not from 1 - z^2, which would be wrong by a nanometre
    lowest = np.array([*(-axis[2] * axis[:2] / across), across]) if across > 0.0 else np.zeros(3)
    end, length = disc * lowest, rng.choice([0.0, 1e-6, 0.4]) * np.sign(axis[2] or 1.0)
    corners = np.array([end, end + length * axis])
    if kind == "cylinder":
        return corners, Rounding(0.0, disc, tuple(axis))
    return corners + [0, 0, radius], Rounding(radius, disc, tuple(axis))


def placed(part, placement):
    """A part and its rounding, moved."""
    corners, rounding = part
    R = placement[:9].reshape(3, 3)
    return np.ascontiguousarray(corners @ R.T + placement[9:]), rounding._replace(axis=tuple(R @ rounding.axis))


def turned_over(part):
    """The mirror image below z = 0, moved down by nothing."""
    corners, rounding = part
    flip = np.array([1.0, 1.0, -1.0])
    return corners * flip, rounding._replace(axis=tuple(flip * rounding.axis))


def pairs(count, seed, far):
    """Pairs of a round part and another one that touch at a point, with the direction that takes them apart."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        quaternion = rng.integers(-3, 4, 4)
        placement = placement_of(quaternion if quaternion.any() else (1, 0, 0, 0), rng.uniform(-far, far, 3))
        first = above(rng.choice(ROUND), rng)
        kind = rng.choice([*ROUND, *KINDS])
        if kind in ROUND:
            second = turned_over(above(kind, rng))
        else:
            still = placement_of((1, 0, 0, 0), np.zeros(3))
            second = touching("point", kind, still, rng).lower, Rounding()
        if rng.random() < 0.5:
            yield placed(first, placement), placed(second, placement), placement[[2, 5, 8]]
        else:
            yield placed(second, placement), placed(first, placement), -placement[[2, 5, 8]]


def rows(parts):
    packed = Enclosure(tuple(p for p, _ in parts), 0.0, tuple(r for _, r in parts)).packed
    return Hulls(packed.blocks, packed.sizes, packed.rounds)


@pytest.mark.parametrize(("count", "far"), [(12_000, 0.0), (6_000, 3.0), (4_000, 400.0)])
def test_no_pair_within_the_margin_is_free_and_every_pair_beyond_is(count, far):
    offset = offset_for(40.0 + 2.0 * far)
    rounding, undecided = float(separation.rounding.py_func(offset)), 0
    for number, (first, second, away) in enumerate(pairs(count, int(far), far)):
        hulls, search = rows([first, second]), search_for(offset)
        own = hulls.blocks[0].copy()
        for gap in NEAR if number % 2 else FREE:
            search.axis[:] = (0.3, -0.2, 0.5) if number % 3 else away
            hulls.blocks[0] = own + (gap * away)[:, None]
            free = separation.apart(hulls, 0, 0, 1, 1, MARGIN, search)
            assert free == (gap > MARGIN), f"{number}: {first[1]} and {second[1]} at {gap}"
        undecided += search.counters[2]
        assert rounding < 2e-10
    assert undecided == 0


def test_the_kernel_and_its_original_say_the_same():
    for number, (first, second, away) in enumerate(pairs(60, 5, 0.5)):
        hulls, offset = rows([first, second]), offset_for(40.0)
        gap = (NEAR + FREE)[number % 8]
        hulls.blocks[0] += (gap * away)[:, None]
        answers = set()
        for function in (separation.apart, separation.apart.py_func):
            search = search_for(offset)
            answers.add(bool(function(hulls, 0, 0, 1, 1, MARGIN, search)))
        assert answers == {gap > MARGIN}


def test_distances_are_bounded_on_both_sides():
    for first, second, away in pairs(400, 6, 0.5):
        hulls = rows([first, second])
        for gap in (0.0, 1e-6, 0.01, 0.5):
            moved = hulls._replace(blocks=hulls.blocks.copy())
            moved.blocks[0] += (gap * away)[:, None]
            search = search_for(offset_for(40.0))
            lower, upper = parts_distance(moved, 0, 1, search)
            assert lower <= gap + 1e-11
            assert gap - 1e-11 <= upper
            assert upper - lower < 1e-7


def coal_shape(kind, size):
    makers = {"sphere": coal.Sphere, "capsule": coal.Capsule, "cylinder": coal.Cylinder, "box": coal.Box}
    return makers[kind](*size)


def own_shape(kind, size):
    """The same shape as coal's, about the same origin."""
    if kind == "box":
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.array(size) / 2
        return Enclosure((corners,), 0.0)
    if kind == "sphere":
        return Enclosure((np.zeros((1, 3)),), 0.0, (Rounding(size[0]),))
    ends = np.array([[0, 0, -size[1] / 2], [0, 0, size[1] / 2]])
    return Enclosure((ends,), 0.0, (Rounding(size[0]) if kind == "capsule" else Rounding(disc=size[0]),))


SIZES = {"sphere": (0.1,), "capsule": (0.08, 0.3), "cylinder": (0.12, 0.2), "box": (0.2, 0.3, 0.1)}


@pytest.mark.parametrize("kind", ["sphere", "capsule", "cylinder"])
@pytest.mark.parametrize("other", list(SIZES))
def test_distances_of_primitives_are_those_of_coal(kind, other):
    rng = np.random.default_rng(0)
    request = coal.DistanceRequest()
    for _ in range(60):
        poses = [placement_of(rng.integers(-3, 4, 4) + [7, 0, 0, 0], rng.uniform(-0.4, 0.4, 3)) for _ in range(2)]
        groups = [FixedGroup(p, own_shape(k, SIZES[k])) for p, k in zip(poses, (kind, other), strict=True)]
        there = [coal.Transform3s(p[:9].reshape(3, 3), p[9:]) for p in poses]
        shapes = coal_shape(kind, SIZES[kind]), coal_shape(other, SIZES[other])
        theirs = coal.distance(shapes[0], there[0], shapes[1], there[1], request, coal.DistanceResult())
        found = distance(*groups)
        if theirs > 1e-3:
            assert found.lower - 1e-5 <= theirs <= found.upper + 1e-5
            assert found.upper - found.lower < 1e-6
        elif theirs < -1e-3:
            assert found.lower == 0.0
        budget = Budget.share(0.01)
        if theirs <= -1e-4:
            assert collides(*groups, budget)
        elif theirs >= 0.01:
            assert not collides(*groups, budget)


@pytest.mark.parametrize("kind", ["sphere", "capsule", "cylinder"])
def test_checks_and_sweeps_count_the_rounding(kind):
    """A round thing slides along z past a ball: what is told agrees with the distance at every place."""
    ball = FixedGroup(placement_of((1, 0, 0, 0), np.array([0.15, 0.05, 0.7])), own_shape("sphere", (0.1,)))
    mover = MovingGroup(1, placement_of((1, 2, 0, 1), np.zeros(3)), own_shape(kind, SIZES[kind]))
    view = CollisionView(
        slide(placement_of((1, 0, 0, 0), np.zeros(3))), [mover], [ball], np.array([[0, 1]]), Budget.share(0.01)
    )
    free, places = [], np.linspace(0.0, 1.4, 141)
    for place in places:
        pose = mover.joint_T_group.copy()
        pose[11] += place
        bounds = distance(FixedGroup(pose, mover.enclosure), ball)
        hit = view.configuration_hit(np.array([place])) >= 0
        assert hit or bounds.upper > 0.0
        assert not hit or bounds.lower < 0.01
        free.append(not hit)
    assert free[0] and free[-1] and not all(free)
    first, last = places[free.index(False) - 1], places[len(free) - free[::-1].index(False)]
    assert view.segment_hit(np.array([0.0]), np.array([first - 0.02])) < 0
    assert view.segment_hit(np.array([last + 0.02]), np.array([1.4])) < 0
    assert view.segment_hit(np.array([0.0]), np.array([1.4])) == 0
