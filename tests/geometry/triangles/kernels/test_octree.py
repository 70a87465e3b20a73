"""The octree finds what a list would: faces come and go, whatever their size and place."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kabo.geometry.triangles.kernels.octree import STACK_SIZE, insert, octree_of, query, remove

FACES = 60


def boxes_of(rng, count):
    """Boxes of all sizes: most inside of the unit cube, some on cell borders, some outside or far larger."""
    low = np.where(rng.random((count, 1)) < 0.3, rng.integers(0, 9, size=(count, 3)) / 8.0, rng.random((count, 3)))
    extent = (
        10.0 ** rng.uniform(-7, 0.5, size=(count, 1))
        * rng.random((count, 3))
        * rng.integers(0, 2, size=(count, 3))
    )
    far = rng.random((count, 1)) < 0.1
    return np.concatenate([low + 5.0 * far, low + 5.0 * far + extent], axis=1)


def meeting(boxes, box):
    """Which boxes meet one, touching included."""
    return (boxes[:, :3] <= box[3:]).all(axis=1) & (boxes[:, 3:] >= box[:3]).all(axis=1)


@given(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([1e-9, 1.0, 1e5]), offset=st.sampled_from([0.0, 1e3]))
def test_a_query_finds_exactly_the_faces_in_the_tree_whose_boxes_meet_it(seed, size, offset):
    rng = np.random.default_rng(seed)
    tree = octree_of(np.full(3, offset), np.full(3, offset + size), FACES)
    inside, boxes = np.zeros(FACES, dtype=bool), np.zeros((FACES, 6))
    stack, found = np.empty(STACK_SIZE, dtype=np.int64), np.empty(FACES, dtype=np.int64)
    for _ in range(100):
        face = rng.integers(FACES)
        remove(tree, face)
        inside[face] = rng.random() < 0.7
        if inside[face]:
            boxes[face] = offset + size * boxes_of(rng, 1)[0]
            insert(tree, face, *boxes[face])
        box = offset + size * boxes_of(rng, 1)[0] if rng.random() < 0.7 else boxes[rng.integers(FACES)]
        count = query(tree, *box, stack, found)
        assert sorted(found[:count]) == np.flatnonzero(inside & meeting(boxes, box)).tolist()


def test_a_used_up_pool_makes_queries_slower_and_not_wrong():
    rng = np.random.default_rng(0)
    tree = octree_of(np.zeros(3), np.ones(3), 500)
    small = tree._replace(nodes=tree.nodes[:10].copy(), cells=tree.cells[:10].copy())
    boxes = boxes_of(rng, 500)
    for face, box in enumerate(boxes):
        insert(small, face, *box)
    assert small.used[0] == 10
    stack, found = np.empty(STACK_SIZE, dtype=np.int64), np.empty(500, dtype=np.int64)
    for box in boxes_of(rng, 50):
        count = query(small, *box, stack, found)
        assert sorted(found[:count]) == np.flatnonzero(meeting(boxes, box)).tolist()


def test_small_faces_live_deep_so_that_queries_look_at_few():
    rng = np.random.default_rng(1)
    tree = octree_of(np.zeros(3), np.ones(3), 4000)
    for face, low in enumerate(rng.random((4000, 3))):
        insert(tree, face, *low, *(low + 0.05))
    assert tree.nodes[0, 0] == -1
    assert tree.nodes[0, 1] == 4000
    assert np.bincount(tree.links[:, 2]).max() < 12


def test_the_same_changes_give_the_same_order():
    orders = []
    for _ in range(2):
        rng = np.random.default_rng(2)
        tree = octree_of(np.zeros(3), np.ones(3), 300)
        for face, box in enumerate(boxes_of(rng, 300)):
            insert(tree, face, *box)
        found = np.empty(300, dtype=np.int64)
        count = query(tree, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, np.empty(STACK_SIZE, dtype=np.int64), found)
        orders.append(found[:count].tolist())
    assert orders[0] == orders[1]


def test_a_short_list_is_filled_and_the_number_is_still_right():
    tree = octree_of(np.zeros(3), np.ones(3), 5)
    for face in range(5):
        insert(tree, face, 0.2, 0.2, 0.2, 0.3, 0.3, 0.3)
    found = np.full(2, -1)
    assert query(tree, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, np.empty(STACK_SIZE, dtype=np.int64), found) == 5
    assert (found >= 0).all()
