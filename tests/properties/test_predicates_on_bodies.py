"""Both sides of [K Table 4.1] for bodies, what they sweep, and containers: gaps and depths known by construction.

Shapes are as bad as they get: points, needles, plates, slivers (tests/support/strategies.py); parts may stick out of the
bodies by all that the budget allows, and inner meshes may lie that deep.
"""

import numpy as np
import trimesh
from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.geometry import (
    Budget,
    Enclosure,
    FixedGroup,
    InnerSolid,
    Motion,
    MovingGroup,
    collides,
    distance,
    includes,
    sweep_collides,
)
from tests.conftest import PROPERTY_SCALE
from tests.geometry.worlds import one_joint, slide
from tests.support.strategies import IDENTITY, KINDS, gaps_about, rational_placements, shape, touching_pairs

COUNT = max(20, round(1000 * PROPERTY_SCALE))
ROUNDING = 1e-12  # metres: of the construction of gaps, at a hundred metres
epsilons = st.sampled_from([1e-6, 1e-4, 2e-3, 0.02, 0.3])


def loosened(vertices, spare, towards):
    """An enclosure that sticks out by `spare` along z, if it has vertices to spare."""
    if spare == 0.0 or len(vertices) > 12:
        return Enclosure((vertices,), 0.0)
    return Enclosure((np.concatenate([vertices, vertices + [0.0, 0.0, towards * spare]]),), spare)


def shifted(placement, height):
    """The pose whose origin lies `height` above a placed frame's."""
    R = placement[:9].reshape(3, 3)
    return np.concatenate([placement[:9], placement[9:] + height * R[:, 2]])


def law(free, gap, budget, known):
    """What Table 4.1 says about an answer at a distance."""
    if gap <= -ROUNDING or (known and gap <= 0.0):
        assert not free
    if gap >= budget.epsilon + ROUNDING:
        assert free
    event("contact" if gap <= 0 else "free" if gap >= budget.epsilon else "between")


@settings(max_examples=COUNT)
@given(pairs=touching_pairs(count=2), epsilon=epsilons, share=st.sampled_from([0.0, 1.0]))
def test_bodies_and_what_they_sweep_keep_both_sides(pairs, epsilon, share):
    """Still, slid away upwards, or turned about the line along which the gap is measured: the gap stays the distance."""
    budget = Budget.share(epsilon)
    spare = share * budget.geometry * (1 - 1e-9)
    for pair in pairs:
        lower = FixedGroup(pair.placement, loosened(pair.lower, spare, 1.0))
        upper = loosened(pair.upper, spare, -1.0)
        gaps = gaps_about(budget.clearance, budget.epsilon)
        for gap in gaps[~np.isnan(pair.distances(gaps))][::4]:
            true = float(pair.distances(np.array([gap]))[0])
            above = FixedGroup(shifted(pair.placement, gap), upper)
            law(not collides(above, lower, budget), true, budget, known=False)
            lift = Motion(
                slide(pair.placement), (MovingGroup(1, IDENTITY, upper),), np.array([[gap], [gap + 0.5]])
            )
            if gap >= 0.0:  # sliding away from an overlap meets what the lower shape has above
                law(not sweep_collides(lift, lower, budget), true, budget, known=True)
            if gap >= 0.0 and epsilon > 1e-3:  # ten metres that turn are not followed within micrometres
                turn = Motion(one_joint(pair.placement), (moved(upper, gap),), np.array([[-0.2], [0.3]]))
                law(not sweep_collides(turn, lower, budget), true, budget, known=False)
                other = Motion(
                    one_joint(pair.placement), (moved(lower.enclosure, 0.0),), np.array([[0.1], [-0.1]])
                )
                law(not sweep_collides(turn, other, budget), true, budget, known=False)


def moved(enclosure, height):
    """A body on a joint, so high above its origin."""
    return MovingGroup(1, np.array([1.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, height]), enclosure)


@settings(max_examples=COUNT)
@given(pairs=touching_pairs(count=2), spare=st.sampled_from([0.0, 1e-3]))
def test_the_bounds_of_a_distance_enclose_it(pairs, spare):
    for pair in pairs:
        lower, upper = loosened(pair.lower, spare, 1.0), loosened(pair.upper, spare, -1.0)
        both = lower.deviation + upper.deviation
        for gap in (0.0, 1e-9, 1e-6, 1e-3, 0.05, 2.0):
            found = distance(FixedGroup(shifted(pair.placement, gap), upper), FixedGroup(pair.placement, lower))
            assert found.lower <= gap + ROUNDING
            assert found.upper >= gap - ROUNDING
            assert found.upper - found.lower <= 2 * both + 1e-7
            event("tight" if found.upper - found.lower <= both + 1e-9 else "loose")


def room(floor, cavity, size=200.0):
    """A huge box whose floor is at a height z, or one with a box-shaped hollow whose ceiling is there: a mesh."""
    if not cavity:
        return trimesh.creation.box((size, size, size)).apply_translation((0, 0, floor + size / 2))
    hollow = trimesh.creation.box((2.0, 3.0, 1.0)).apply_translation((0, 0, floor - 0.5))
    hollow.invert()
    return trimesh.util.concatenate([trimesh.creation.box((size, size, size)), hollow])


@settings(max_examples=COUNT)
@given(
    seed=st.integers(0, 2**32 - 1),
    kind=st.sampled_from(KINDS),
    placement=rational_placements(),
    epsilon=epsilons,
    share=st.sampled_from([0.0, 1.0]),
    cavity=st.booleans(),
)
def test_inclusion_keeps_both_sides(seed, kind, placement, epsilon, share, cavity):
    """The shape stands on the floor of a room, or on the ceiling of a hollow in a solid, so high as its depth says."""
    budget = Budget.share(epsilon)
    spare = share * budget.geometry * (1 - 1e-9)
    true = shape(kind, np.random.default_rng(seed))
    body = FixedGroup(placement, loosened(true.vertices, spare, -1.0))
    for depth in gaps_about(budget.numeric, budget.epsilon)[::4]:
        mesh = room(-depth + spare, cavity)  # the inner mesh: its floor lies higher than the room's
        inner = InnerSolid(placement, np.asarray(mesh.vertices), np.asarray(mesh.faces), spare)
        answer = includes(inner, body, budget)
        assert not answer or depth > 0.0
        assert answer or depth < budget.epsilon
        event("outside" if depth < 0 else "deep" if depth >= budget.epsilon else "between")
