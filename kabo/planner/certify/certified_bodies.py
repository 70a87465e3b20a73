"""The convex parts of a certificate: as few as its proofs need, the same for all of them."""

from collections.abc import Mapping

import numpy as np

from kabo.arrays import Array
from kabo.geometry import Budget, Enclosure
from kabo.geometry.collision.part_trees import Cover, divided_larger
from kabo.geometry.collision.separation_proofs import Course, Prover, Unproven, Witness, order_of, ordered
from kabo.plan import BodyParts


class CertifiedBodies:
    """The parts of every mesh; where a proof fails, parts that have children are divided.

    `covers` are the divisions to begin with: those that the proofs of the whole plan turned out to need.
    """

    def __init__(
        self, enclosures: Mapping[str, Enclosure], covers: Mapping[str, Cover], budget: Budget, near: float
    ) -> None:
        self.covers = {digest: covers.get(digest) or Cover.of(made) for digest, made in enclosures.items()}
        self.divided = False  # whether proofs needed more than those
        self._budget, self._near = budget, near
        self._parts = {digest: ordered(cover.enclosure) for digest, cover in self.covers.items()}
        self._prover = Prover(self._parts, near, budget.clearance)

    def prove(self, course: Course) -> list[Witness | None] | Unproven:
        """The result of `Prover.prove`, with parts divided until they decide."""
        while True:
            found = self._prover.prove(course)
            if not isinstance(found, Unproven) or not self._divide(course, found):
                return found

    def prove_best(self, course: Course, wanted: Array | None) -> list[Witness | None] | Unproven:
        """The result of `Prover.prove` for wanted margins, with the parts as they are."""
        return self._prover.prove(course, wanted)

    def _divide(self, course: Course, failed: Unproven) -> bool:
        """Whether the larger of the two parts that were not proven apart could be divided."""
        meshes = [course.bodies[k].mesh for k in course.pairs[failed.pair, :2]]
        places = [
            order_of(self.covers[mesh].enclosure)[part] for mesh, part in zip(meshes, failed.parts, strict=True)
        ]
        before = [self.covers[mesh] for mesh in meshes]
        finer = divided_larger(before, places, self._budget.geometry)
        if finer is None:
            return False
        self.divided = True
        for mesh, cover, old in zip(meshes, finer, before, strict=True):
            if cover is not old:
                self.covers[mesh] = cover
                self._parts[mesh] = ordered(cover.enclosure)
        self._prover = Prover(self._parts, self._near, self._budget.clearance)
        return True

    def given(self) -> dict[str, BodyParts]:
        """The parts of every mesh for a certificate, by `sha256:` and its hash."""
        result = {}
        for digest, parts in sorted(self._parts.items()):
            sizes, vertices = tuple(map(len, parts.vertices)), np.concatenate(parts.vertices)
            rounds = parts.packed.rounds.astype("<f8").tobytes() if parts.packed.rounds[:, :2].any() else b""
            result[f"sha256:{digest}"] = BodyParts(sizes, vertices.astype("<f8").tobytes(), rounds)
        return result
