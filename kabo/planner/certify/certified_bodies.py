"""The convex parts of a certificate: as few as its proofs need, the same for all of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry import Budget, Enclosure
from kabo.geometry.collision.near_pairs import NearPairs
from kabo.geometry.collision.part_trees import Cover, divided_larger
from kabo.geometry.collision.separation_proofs import (
    Course,
    Parts,
    ProofArrays,
    Prover,
    Unproven,
    Witness,
    arranged,
    order_of,
    ordered,
)
from kabo.meshes import Rounding
from kabo.plan import BodyParts


@dataclass(frozen=True, eq=False)
class PairProofs:
    """The proofs of some pairs, each a row of one of several arrays of proofs."""

    sources: tuple[ProofArrays, ...]
    source: Integers  # (P,) which of the sources has the proof of each pair
    row: Integers  # (P,) and as which of its pairs
    margins: Array  # (P,) [m]

    @classmethod
    def of(cls, made: ProofArrays) -> "PairProofs":
        """Those of one array, in its order."""
        count = len(made.margins)
        return cls((made,), np.zeros(count, np.int64), np.arange(count), made.margins)

    def joined(self, other: "PairProofs", mine: Integers, theirs: Integers) -> "PairProofs":
        """Proofs of pairs `mine` from here and `theirs` from other ones, at these places of the result."""
        count = len(mine) + len(theirs)
        source, row, margins = np.zeros(count, np.int64), np.zeros(count, np.int64), np.zeros(count)
        source[mine], row[mine], margins[mine] = self.source, self.row, self.margins
        source[theirs], row[theirs], margins[theirs] = (
            other.source + len(self.sources),
            other.row,
            other.margins,
        )
        return PairProofs(self.sources + other.sources, source, row, margins)

    def only(self, pairs: Integers) -> "PairProofs":
        """Those of some pairs."""
        return PairProofs(self.sources, self.source[pairs], self.row[pairs], self.margins[pairs])

    @property
    def needed(self) -> Integers:
        """The pairs that have a proof; boxes tell the others apart, or they do not move."""
        sizes = np.zeros(len(self.row), np.int64)
        for number, made in enumerate(self.sources):
            own = self.source == number
            sizes[own] = made.sizes[self.row[own]]
        return np.flatnonzero(sizes)

    def witness(self, pair: int) -> Witness | None:
        """The proof of a pair; None if it needs none."""
        source: ProofArrays = self.sources[int(self.source[pair])]
        return source.witness(int(self.row[pair]))


class CertifiedBodies:
    """The parts of every mesh; where a proof fails, parts that have children are divided.

    `covers` are the divisions to begin with: those that the proofs of the whole plan turned out to need. `given` are parts
    of another certificate: if there are any, nothing is divided.
    """

    def __init__(
        self,
        enclosures: Mapping[str, Enclosure],
        covers: Mapping[str, Cover],
        budget: Budget,
        near: float,
        given: Mapping[str, BodyParts] | None = None,
    ) -> None:
        self.covers = {digest: covers.get(digest) or Cover.of(made) for digest, made in enclosures.items()}
        self.divided = False  # whether proofs needed more than those
        self._budget, self._near = budget, near
        self._given = given or {}
        self._parts = {digest: self._parts_of(digest) for digest in self.covers}
        self._prover = Prover(self._parts, near, budget.clearance)
        self._known: dict[tuple[object, ...], tuple[Integers, PairProofs, Array]] = {}
        self._names: dict[str, Sequence[int]] = {}  # of the parts of each refined mesh

    def _parts_of(self, digest: str) -> Parts:
        given = self._given.get(f"sha256:{digest}")
        return ordered(self.covers[digest].enclosure) if given is None else _read(given)

    def near_pairs(self, course: Course, scopes: Integers, caps: Array) -> NearPairs:
        """The pairs of a course by their distances, with the parts that nothing has refined yet."""
        return NearPairs(self._prover, course, scopes, caps)

    def prove(self, course: Course, wanted: Array | None = None) -> PairProofs | Unproven:
        """The proofs of a course, with margins `wanted` (P,) [m] where these are found; parts divided until they decide.

        Without them as much is wanted as counts at all. Pairs that have been proven along the same path before are not
        proven again, unless more is wanted.
        """
        wanted = np.full(len(course.pairs), self._near) if wanted is None else wanted
        if course.kept is not None or course.at_any_times:
            return self._proven(course, wanted)
        off = b"" if course.deviations is None else course.deviations.tobytes()
        path = id(course.tree), course.waypoints.tobytes(), off
        if path not in self._known:
            made = self._proven(course, wanted)
            if not isinstance(made, Unproven):
                self._known[path] = self._keys(course), made, wanted
            return made
        before, proofs, aims = self._known[path]
        keys = self._keys(course)
        order = np.argsort(before, kind="stable")
        place = order[np.minimum(np.searchsorted(before[order], keys), len(before) - 1)] if len(before) else order
        if len(before):
            same = (before[place] == keys) & (np.maximum(aims, proofs.margins)[place] >= wanted)
        else:
            same = np.zeros(len(keys), bool)
        old, new = np.flatnonzero(same), np.flatnonzero(~same)
        made = self._proven(replace(course, pairs=np.ascontiguousarray(course.pairs[new])), wanted[new])
        if isinstance(made, Unproven):
            return replace(made, pair=int(new[made.pair]))
        if path not in self._known:  # parts were divided
            return self.prove(course, wanted)
        return proofs.only(place[old]).joined(made, old, new)

    def _keys(self, course: Course) -> Integers:
        """A number for each pair of bodies, the same for the same bodies at the same places."""
        numbers = self._prover.numbers(course.bodies)
        return np.asarray(numbers[course.pairs[:, 0]] << 32 | numbers[course.pairs[:, 1]])

    def _proven(self, course: Course, wanted: Array) -> PairProofs | Unproven:
        while True:
            found = self._prover.arrays(course, wanted)
            if not isinstance(found, Unproven):
                return PairProofs.of(found)
            if not self._divide(course, found):
                return found

    def _divide(self, course: Course, failed: Unproven) -> bool:
        """Whether the larger of the two parts that were not proven apart could be divided."""
        if self._given:
            return False
        meshes = [course.bodies[k].mesh for k in course.pairs[failed.pair, :2]]
        numbers = [self._names[m][k] if m in self._names else k for m, k in zip(meshes, failed.parts, strict=True)]
        places = [order_of(self.covers[mesh].enclosure)[k] for mesh, k in zip(meshes, numbers, strict=True)]
        before = [self.covers[mesh] for mesh in meshes]
        finer = divided_larger(before, places, self._budget.geometry)
        if finer is None:
            return False
        self.divided = True
        for mesh, cover, old in zip(meshes, finer, before, strict=True):
            if cover is not old:
                self.covers[mesh] = cover
                self._parts[mesh] = ordered(cover.enclosure)
                self._names.pop(mesh, None)
        self._prover = Prover(self._parts, self._near, self._budget.clearance)
        self._known.clear()
        return True

    @property
    def parts(self) -> Mapping[str, Parts]:
        """The parts of every mesh, by its hash."""
        return self._parts

    def replace_parts(self, refined: Mapping[str, Parts], names: Mapping[str, Sequence[int]]) -> None:
        """Replaces the parts of some meshes by some that lie within them; `names` are the parts that those are of."""
        self._parts.update(refined)
        self._names.update(names)
        self._prover = Prover(self._parts, self._near, self._budget.clearance)
        self._known.clear()

    @property
    def refined(self) -> bool:
        """Whether any parts are replaced."""
        return bool(self._names)

    def given(self) -> dict[str, BodyParts]:
        """The parts of every mesh for a certificate, by `sha256:` and its hash."""
        result = {}
        for digest, parts in sorted(self._parts.items()):
            sizes, vertices = tuple(map(len, parts.vertices)), np.concatenate(parts.vertices)
            rounds = parts.packed.rounds.astype("<f8").tobytes() if parts.packed.rounds[:, :2].any() else b""
            result[f"sha256:{digest}"] = BodyParts(sizes, vertices.astype("<f8").tobytes(), rounds)
        return result


def _read(given: BodyParts) -> Parts:
    """The parts of a certificate, in their order."""
    vertices = np.frombuffer(given.vertices, "<f8").astype(np.float64).reshape(-1, 3)
    rounds = np.frombuffer(given.rounds, "<f8").reshape(-1, 5).tolist()
    roundings = tuple(Rounding(radius, disc, (x, y, z)) for radius, disc, x, y, z in rounds)
    parts = tuple(map(np.ascontiguousarray, np.split(vertices, np.cumsum(given.sizes)[:-1])))
    return arranged(Enclosure(parts, 0.0, roundings), list(range(len(parts))))
