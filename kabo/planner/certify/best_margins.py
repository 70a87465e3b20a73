"""Better proofs for the pairs that decide how far objects may be displaced: the margins of a certificate tell the truth.

A proof is found quickly, with the margin that the planner keeps. How far an object may be displaced is the least
margin of all pairs that it is in, so only the pairs with the least margins are worth more work: they are proven again
for a greater margin, in rounds. A pair that does not reach what is wanted then has what can be found of it.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from kabo.arrays import Array
from kabo.geometry.collision.separation_proofs import Course, Unproven, Witness
from kabo.planner.certify.certified_pairs import Thing
from kabo.planner.certify.motion_stretches import MotionStretch

GROWTH = 1.6  # of the margin that is wanted, from round to round
EVERYTHING = ""  # the name under which the least margin of all pairs is kept

Prove = Callable[[Course, Array | None], "list[Witness | None] | Unproven"]


@dataclass(eq=False)
class ProvenStretch:
    """A stretch of motion, its bodies, the pairs that it is about, and the proof of each, which may be replaced."""

    node: str
    stretch: MotionStretch
    course: Course
    things: Sequence[Thing]
    numbers: Sequence[tuple[int, int]]  # of the bodies of each pair of the course
    witnesses: list[Witness | None]
    before: tuple[int, ...] = ()  # segments of the node before
    cut: int = 0
    best: set[int] = field(default_factory=set)  # pairs for which more was wanted in vain

    @cached_property
    def margins(self) -> Array:
        """The margin of each pair [m]; infinite where no proof is needed, or boxes suffice."""
        return np.array([np.inf if each is None else each.margin for each in self.witnesses])

    def names(self, pair: int) -> tuple[str, str]:
        """The names of the bodies of a pair."""
        first, second = self.numbers[pair]
        return self.things[first].name, self.things[second].name

    def prove_again(self, pairs: Sequence[int], wanted: float, prove: Prove) -> None:
        """Proves some pairs for a margin, and keeps the proofs that are better."""
        course = self.course
        kept = None if course.kept is None else course.kept[pairs]
        found = prove(replace(course, pairs=course.pairs[pairs], kept=kept), np.full(len(pairs), wanted))
        for k, pair in enumerate(pairs):
            witness = None if isinstance(found, Unproven) else found[k]
            if witness is not None and witness.margin > self.margins[pair]:
                self.witnesses[pair], self.margins[pair] = witness, witness.margin
            if self.margins[pair] < wanted:
                self.best.add(pair)


def widen(
    proven: Sequence[ProvenStretch], objects: frozenset[str], near: float, prove: Prove, look: Callable[[], None]
) -> None:
    """Proves pairs again until the least margin of every object, and of all pairs, is the best that can be found.

    Args:
        proven: all stretches with their proofs, which are replaced.
        objects: the names of the bodies whose least margins count.
        near: margins from this on [m] do not count.
        prove: the proofs of a course for wanted margins.
        look: called before each stretch.
    """
    named = [[_counted(each, pair, objects) for pair in range(len(each.numbers))] for each in proven]
    wanted = 0.0
    open_names = {name for names in named for own in names for name in own}
    while open_names:
        least = _least(proven, named)
        for name in sorted(open_names):
            margin, best = least.get(name, (np.inf, True))
            if best or margin >= near:
                open_names.discard(name)
        if not open_names:
            return
        lowest = min(least[name][0] for name in open_names)
        wanted = min(near, GROWTH * max(wanted, lowest))
        for each, names in zip(proven, named, strict=True):
            below = np.flatnonzero(each.margins < wanted).tolist()
            chosen = [i for i in below if i not in each.best and open_names & set(names[i])]
            if chosen:
                look()
                each.prove_again(chosen, wanted, prove)


def _counted(each: ProvenStretch, pair: int, objects: frozenset[str]) -> tuple[str, ...]:
    return (*(name for name in each.names(pair) if name in objects), EVERYTHING)


def _least(
    proven: Sequence[ProvenStretch], named: Sequence[Sequence[tuple[str, ...]]]
) -> dict[str, tuple[float, bool]]:
    """The least margin for each name, and whether it is the best that can be found."""
    found: dict[str, tuple[float, bool]] = {}
    for name, margin, best in _entries(proven, named):
        if (margin, best) < found.get(name, (np.inf, True)):
            found[name] = margin, best
    return found


def _entries(
    proven: Sequence[ProvenStretch], named: Sequence[Sequence[tuple[str, ...]]]
) -> Iterator[tuple[str, float, bool]]:
    for each, names in zip(proven, named, strict=True):
        for pair in np.flatnonzero(np.isfinite(each.margins)).tolist():
            for name in names[pair]:
                yield name, float(each.margins[pair]), pair in each.best
