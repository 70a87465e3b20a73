"""Proofs of courses: a pair is proven once along a path, whatever else is asked beside it."""

from dataclasses import replace

import numpy as np

from kabo.geometry import Budget, Enclosure
from kabo.geometry.collision.separation_proofs import Course, PlacedBody
from kabo.planner.certify.certified_bodies import CertifiedBodies
from kabo.scene.transforms import flat, transform
from tests.geometry.collision.test_separation_proofs import CUBE, slide

NEAR = 0.01
BUDGET = Budget.share(NEAR)


def bodies_of(*heights: float) -> list[PlacedBody]:
    """A cube that slides upwards, and cubes beside its way at some distances."""
    moving = PlacedBody("cube", 2, flat(transform((0.2, 0, 0))))
    return [moving, *(PlacedBody("cube", 0, flat(transform((0.3 + gap, 0.0, 0.5)))) for gap in heights)]


def course(bodies: list[PlacedBody]) -> Course:
    pairs = np.array([[0, k, 0] for k in range(1, len(bodies))], np.int64)
    return Course(slide(), np.array([[0.0, 0.0], [1.0, 0.0]]), bodies, pairs)


def fresh() -> CertifiedBodies:
    return CertifiedBodies({"cube": Enclosure((CUBE,), 0.0)}, {}, BUDGET, NEAR)


def test_what_was_proven_along_a_path_is_the_same_beside_other_bodies():
    tree, first, more = slide(), bodies_of(0.004, 0.006), bodies_of(0.005, 0.004, 0.3, 0.006)
    known, new = fresh(), fresh()
    known.prove(replace(course(first), tree=tree))
    found, alone = known.prove(replace(course(more), tree=tree)), new.prove(replace(course(more), tree=tree))
    assert found.margins.tolist() == alone.margins.tolist() and len(found.sources) == 2
    assert [found.witness(k) for k in range(4)] == [alone.witness(k) for k in range(4)]
    assert found.needed.tolist() == [0, 1, 3]


def test_margins_are_the_greatest_up_to_near():
    found = fresh().prove(course(bodies_of(0.004, 0.008)))
    np.testing.assert_allclose(found.margins, [0.004, 0.008], atol=1e-5)
