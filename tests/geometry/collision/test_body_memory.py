"""The memory of bodies: whatever was in place before, it holds what a new one would hold."""

import numpy as np
import pytest

from kabo.geometry import BodyMemories, Budget, CollisionView, Enclosure, FixedGroup, MovingGroup
from kabo.geometry.collision.kernels.bundles import Hulls
from kabo.geometry.collision.placed_bodies import cores_of
from kabo.meshes import Rounding
from kabo.scene.transforms import flat, transform
from tests.geometry.worlds import slide, three_joints

BUDGET, TREE = Budget.share(0.01), three_joints()
NUMBERS = np.random.default_rng(1)
HULL = Enclosure((NUMBERS.normal(size=(8, 3)) * 0.1,), 0.0)
ROUNDED = Enclosure(
    (NUMBERS.normal(size=(20, 3)) * 0.05, NUMBERS.normal(size=(3, 3)) * 0.05),
    0.0,
    (Rounding(), Rounding(0.02, 0.05, (0.0, 0.6, 0.8))),
)


def pose(numbers):
    """A random pose of 12 numbers."""
    turn = numbers.normal(size=4)
    return flat(transform(0.2 * numbers.normal(size=3), turn / np.linalg.norm(turn)))


def arranged(numbers, memories=None, kept=0.0):
    """A view of a hull and a rounded body on joints, and of both standing, at random poses, and of some pairs of them."""
    moving = [MovingGroup(j, pose(numbers), each, kept=kept) for j, each in ((1, HULL), (3, ROUNDED))]
    fixed = [
        FixedGroup(pose(numbers), each, kept=kept, hand=int(2 * numbers.random())) for each in (ROUNDED, HULL)
    ]
    every = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3]])
    pairs = numbers.permutation(every)[: numbers.integers(1, 6)]
    return CollisionView(TREE, moving, fixed, pairs, BUDGET, memories=memories)


def answers(view, numbers):
    """What a view says of some configurations and segments."""
    rows, ends = numbers.uniform(-3.0, 3.0, (2, 12, 3))
    off = np.zeros(rows.shape)
    return [view.configuration_hit(q) for q in rows], view.segments_hit(rows, ends, off).tolist(), view.counters


def test_views_that_share_a_memory_answer_as_those_with_memories_of_their_own():
    memories, found = BodyMemories(), []
    for keys in ([1, 2, 3], [3, 1, 2]):  # the second time they are asked in another order
        shared = {key: arranged(np.random.default_rng(key), memories, kept=0.01 * key) for key in keys}
        for key, view in shared.items():
            own = arranged(np.random.default_rng(key), kept=0.01 * key)
            for _ in range(2):
                numbers = np.random.default_rng(9)
                found.append(answers(view, numbers))
                assert found[-1] == answers(own, np.random.default_rng(9))
                reached, reaches = (each.kernel_checks.sweep[4].tracks.radii for each in (view, own))
                np.testing.assert_array_equal(reached, reaches)
                assert arranged(np.random.default_rng(8), memories).configuration_hit(np.zeros(3)) >= -1
    assert len({str(each[0]) for each in found}) > 2


def test_views_of_the_same_bodies_share_one_array():
    memories = BodyMemories()
    first, second = (arranged(np.random.default_rng(key), memories) for key in (1, 2))
    assert first.kernel_checks.memory is second.kernel_checks.memory
    assert arranged(np.random.default_rng(1)).kernel_checks.memory is not first.kernel_checks.memory


def test_each_view_counts_its_own_checks():
    memories = BodyMemories()
    first, second = (arranged(np.random.default_rng(key), memories) for key in (1, 2))
    for view in (first, second, first):
        view.configuration_hit(np.zeros(3))
    assert [view.counters.configuration_checks for view in (first, second)] == [2, 1]


def test_cores_of_placed_parts_are_those_of_the_parts_where_they_are():
    view = arranged(np.random.default_rng(1))
    bodies, parts = view._bodies, len(view._bodies._source.packed.sizes)
    hulls = Hulls(*(array[:parts] for array in bodies._hulls))
    np.testing.assert_allclose(bodies._cores, cores_of(hulls), atol=1e-12)
    assert np.ptp(bodies._cores[:, :3], axis=0).max() > 0.1


def test_a_body_too_far_away_is_refused_and_the_memory_serves_others_still():
    memories = BodyMemories()
    tree, cube = slide(pose(np.random.default_rng(1))), HULL
    groups = [MovingGroup(1, pose(np.random.default_rng(2)), cube)]
    pairs = np.array([[0, 1]])
    far = FixedGroup(flat(transform((1e6, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))), cube)
    near = FixedGroup(pose(np.random.default_rng(3)), cube)
    own = CollisionView(tree, groups, [near], pairs, BUDGET).configuration_hit([0.1])
    shared = CollisionView(tree, groups, [near], pairs, BUDGET, memories=memories)
    with pytest.raises(ValueError, match="too far"):
        CollisionView(tree, groups, [far], pairs, BUDGET, memories=memories)
    assert shared.configuration_hit([0.1]) == own


def test_views_of_the_same_bodies_share_their_pairs_and_tracks_wherever_the_bodies_are():
    memories = BodyMemories()
    pairs, numbers = np.array([[0, 1]]), np.random.default_rng(4)
    views = [
        CollisionView(
            TREE,
            [MovingGroup(3, pose(numbers), HULL)],
            [FixedGroup(pose(numbers), HULL)],
            pairs,
            BUDGET,
            memories=memories,
        )
        for _ in range(2)
    ]
    sweeps = [view.kernel_checks.sweep for view in views]
    assert sweeps[0][2] is sweeps[1][2], "the pairs are laid out once"
    assert sweeps[0][4].tracks is sweeps[1][4].tracks
