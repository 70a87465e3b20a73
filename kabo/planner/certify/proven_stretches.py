"""A stretch of motion with the proofs of its pairs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Integers
from kabo.geometry.collision.separation_proofs import Course
from kabo.plan import PairProof, StretchProof
from kabo.planner.certify.certified_bodies import PairProofs
from kabo.planner.certify.certified_pairs import Thing
from kabo.planner.certify.motion_stretches import MotionStretch


@dataclass(eq=False)
class ProvenStretch:
    """A stretch of motion, its bodies, the pairs that it is about, and their proofs."""

    node: str
    stretch: MotionStretch
    course: Course
    things: Sequence[Thing]
    pairs: Integers  # (P, 3) the numbers of both bodies among `things`, and the frame
    proofs: PairProofs
    before: tuple[int, ...] = ()  # segments of the node before
    cut: int = 0

    @property
    def least(self) -> tuple[float, tuple[str, str] | None]:
        """The least margin of all pairs [m], and of which one; infinite if no pair needs an axis."""
        margins = self.proofs.margins
        pair = int(margins.argmin()) if len(margins) else -1
        return (float(margins[pair]), self.names(pair)) if pair >= 0 and margins[pair] < np.inf else (np.inf, None)

    def names(self, pair: int) -> tuple[str, str]:
        """The names of the bodies of a pair."""
        first, second = self.pairs[pair, :2]
        return self.things[first].name, self.things[second].name

    def proof(self) -> StretchProof:
        """The proofs as the plan has them."""
        made = []
        needed = self.proofs.needed
        for pair, (i, k) in zip(needed.tolist(), self.pairs[needed, :2].tolist(), strict=True):
            witness, first, second = self.proofs.witness(pair), self.things[i], self.things[k]
            assert witness is not None
            made.append(PairProof(first.name, second.name, second.place, witness.walk, witness.axes))
        return StretchProof(self.node, self.stretch.segments, tuple(made), self.before, self.cut)
