"""Unions of enclosures: roots first, parts that keep their numbers when one of them is refined."""

from dataclasses import replace

import numpy as np
import pytest

from kabo.geometry.bounding.united_enclosure import united
from kabo.geometry.parts import Enclosure
from kabo.meshes import Rounding

TETRAHEDRON = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def tree(name: int, roots: int) -> Enclosure:
    """A tree whose parts say whose they are: each root can be divided into two halves."""
    parts = tuple(TETRAHEDRON + 10.0 * name + i for i in range(roots))
    whole = Enclosure(parts, 0.1, deviations=(0.1,) * roots, children=((0, 0),) * roots, roots=roots)
    return replace(whole, finer=lambda i: divided(whole, i))


def divided(enclosure: Enclosure, part: int) -> Enclosure:
    """The enclosure with two children of a part at the end."""
    count = len(enclosure.parts)
    children = list(enclosure.children)
    children[part] = (count, 2)
    made = replace(
        enclosure,
        parts=(*enclosure.parts, 0.5 * enclosure.parts[part], 0.7 * enclosure.parts[part]),
        deviations=(*enclosure.deviations, 0.01, 0.02),
        children=(*children, (0, 0), (0, 0)),
    )
    return replace(made, finer=lambda i: divided(made, i))


def test_one_enclosure_is_its_own_union_and_none_is_refused() -> None:
    one = Enclosure((TETRAHEDRON,), 0.0)
    assert united([one]) is one
    with pytest.raises(ValueError, match="no bodies"):
        united([])


def test_parts_keep_their_rounding_and_deviation() -> None:
    ball = Enclosure((np.zeros((1, 3)),), 0.0, (Rounding(radius=0.2),))
    both = united([Enclosure((TETRAHEDRON,), 0.05), ball])
    assert [both.rounding_of(i).radius for i in range(2)] == [0.0, 0.2]
    assert [both.deviation_of(i) for i in range(2)] == [0.05, 0.0]
    assert both.deviation == 0.05 and both.finer is None and not both.children


def test_what_is_refined_gets_children_at_the_end_and_everything_else_keeps_its_number() -> None:
    union = united([tree(1, 2), Enclosure((TETRAHEDRON,), 0.1), tree(2, 1)])
    assert union.finer is not None and len(union.root_parts) == 4
    once = union.finer(3)
    assert once.finer is not None
    twice = once.finer(0)
    assert [list(twice.children_of(i)) for i in range(4)] == [[6, 7], [], [], [4, 5]]
    for before, after in ((union, once), (once, twice)):
        for one, other in zip(before.parts, after.parts, strict=False):
            assert np.array_equal(one, other)
    assert np.array_equal(twice.parts[4], 0.5 * union.parts[3])
    assert np.array_equal(twice.parts[7], 0.7 * union.parts[0])
    assert [twice.deviation_of(i) for i in (4, 5, 6, 7)] == [0.01, 0.02, 0.01, 0.02]
    with pytest.raises(ValueError, match="no finer"):
        union.finer(2)


def test_a_union_of_refined_trees_has_all_roots_first() -> None:
    first, second = tree(1, 1), tree(2, 1)
    assert first.finer is not None
    union = united([first.finer(0), second])
    assert len(union.root_parts) == 2
    assert np.array_equal(union.parts[1], second.parts[0])
    assert list(union.children_of(0)) == [2, 3]
