"""Trees of parts in use: what is refined is remembered, and covers hold just the parts that a question needs.

Whether a part is divided depends on its own deviation alone, never on what is known of its children. So what has
been refined before changes no answer.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from kabo.arrays import Integers
from kabo.geometry.collision.kernels.bundles import OPEN
from kabo.geometry.parts import Enclosure

_REFINED: "WeakKeyDictionary[Enclosure, Enclosure]" = (
    WeakKeyDictionary()
)  # an enclosure as it was given -> as known


def known(enclosure: Enclosure) -> Enclosure:
    """An enclosure with all children that this process has made of it."""
    return _REFINED.get(enclosure, enclosure)


def refine(enclosure: Enclosure, part: int) -> None:
    """Makes the children of a part of `known(enclosure)`.

    Raises:
        ValueError: the part's children cannot be made.
    """
    now = known(enclosure)
    if now.children_of(part):
        return
    if now.finer is None:
        raise ValueError(f"part {part} deviates by {now.deviation_of(part):g} m and cannot be refined")
    finer = now.finer(part)
    if len(finer.root_parts) != len(now.root_parts) or not finer.children_of(part):
        raise ValueError(f"refining part {part} of an enclosure changed its roots, or gave no children")
    _REFINED[enclosure] = finer


def is_final(enclosure: Enclosure, part: int, geometry: float) -> bool:
    """Whether a part is near enough to its body to decide: its deviation is at most `geometry` [m]."""
    return enclosure.deviation_of(part) <= geometry


def require_fine(enclosure: Enclosure, geometry: float) -> None:
    """Raises an error unless every part is near enough to the body, or has children, or can be given some.

    Raises:
        ValueError: a part deviates by more than the budget allows, finally.
    """
    most = max(enclosure.deviation, enclosure.deviation_of_roots)
    if enclosure.finer is not None or (not enclosure.children and most <= geometry):
        return
    open_ones = (enclosure.every_deviation > geometry) & (enclosure.every_child[:, 1] == 0)
    coarse = enclosure.every_deviation[open_ones].tolist()
    if coarse or (not enclosure.children and not enclosure.deviation <= geometry):
        deviation = max(coarse, default=enclosure.deviation)
        raise ValueError(f"an enclosure deviates by {deviation:g} m, the budget allows {geometry:g} m")


def deviation_within(enclosure: Enclosure, geometry: float) -> float:
    """How far the parts that decide may be from the body [m], whatever has been refined."""
    return enclosure.deviation if is_flat(enclosure, geometry) else geometry


def is_flat(enclosure: Enclosure, geometry: float) -> bool:
    """Whether the roots alone decide every question."""
    return enclosure.deviation_of_roots <= geometry


def children_within(enclosure: Enclosure, geometry: float) -> Integers:
    """The first child and the number of children (B, 2) of every part; of those near enough none, OPEN if not known."""
    found = enclosure.within.get(geometry)
    if found is None:
        found = np.where(enclosure.every_child[:, 1:] > 0, enclosure.every_child, (0, OPEN))
        found[enclosure.every_deviation <= geometry] = 0
        enclosure.within[geometry] = found
    return found


@dataclass(frozen=True, eq=False)
class Cover:
    """Parts of a tree that cover its body together: the roots at first, children in place of those that were divided."""

    given: Enclosure
    nodes: tuple[int, ...]

    @classmethod
    def of(cls, enclosure: Enclosure) -> "Cover":
        """The roots."""
        return cls(enclosure, tuple(enclosure.root_parts))

    @cached_property
    def enclosure(self) -> Enclosure:
        """The cover as an enclosure without a tree; the given one where nothing is divided."""
        now = known(self.given)
        if self.nodes == tuple(range(len(self.given.parts))) and not self.given.children:
            return self.given
        deviations = tuple(now.deviation_of(node) for node in self.nodes)
        return Enclosure(
            tuple(now.parts[node] for node in self.nodes),
            max(deviations, default=0.0),
            tuple(now.roundings[node] for node in self.nodes) if now.roundings else (),
            deviations,
        )

    def is_final(self, place: int, geometry: float) -> bool:
        """Whether the part at a place of the cover is near enough to decide, or cannot be divided."""
        now = known(self.given)
        part = self.nodes[place]
        return is_final(now, part, geometry) or (now.finer is None and not now.children_of(part))

    def divided(self, place: int) -> "Cover":
        """The cover with its children in place of a part.

        Raises:
            ValueError: as `refine`.
        """
        refine(self.given, self.nodes[place])
        children = known(self.given).children_of(self.nodes[place])
        return Cover(self.given, (*self.nodes[:place], *children, *self.nodes[place + 1 :]))


def divided_larger(covers: Sequence[Cover], places: Sequence[int], geometry: float) -> list[Cover] | None:
    """The covers with the larger of the parts at the given places divided; None if all of them decide."""
    open_ones = [i for i, place in enumerate(places) if not covers[i].is_final(place, geometry)]
    if not open_ones:
        return None
    largest = max(open_ones, key=lambda i: covers[i].enclosure.packed.diameters[places[i]])
    return [cover.divided(places[i]) if i == largest else cover for i, cover in enumerate(covers)]


def finest(enclosure: Enclosure, geometry: float) -> Enclosure:
    """The enclosure of all parts near enough to decide, divided as far as that takes.

    Raises:
        ValueError: as `refine`.
    """
    cover, place = Cover.of(enclosure), 0
    while place < len(cover.nodes):
        if cover.is_final(place, geometry):
            place += 1
        else:
            cover = cover.divided(place)
    return cover.enclosure
