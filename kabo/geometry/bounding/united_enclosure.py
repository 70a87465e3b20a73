"""Enclosures of bodies that consist of several elements: the union of the elements' enclosures, trees included."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from kabo.geometry.parts import Enclosure


def united(enclosures: Sequence[Enclosure]) -> Enclosure:
    """The enclosure of a union of bodies, from their own enclosures in the same frame.

    Roots come first, then the other parts of each tree. To refine a part refines the enclosure that it belongs to.

    Raises:
        ValueError: there is no enclosure.
    """
    if not enclosures:
        raise ValueError("a union of no bodies encloses nothing")
    if len(enclosures) == 1:
        return enclosures[0]
    ordered = _places(enclosures)
    number = {place: index for index, place in enumerate(ordered)}
    parts = tuple(enclosures[own].parts[i] for own, i in ordered)
    roundings = tuple(enclosures[own].rounding_of(i) for own, i in ordered)
    children = []
    for own, i in ordered:
        below = enclosures[own].children_of(i)
        children.append((number[own, below[0]] if below else 0, len(below)))

    return Enclosure(
        parts,
        max(each.deviation for each in enclosures),
        roundings if any(each.roundings for each in enclosures) else (),
        tuple(enclosures[own].deviation_of(i) for own, i in ordered),
        tuple(children) if any(each.children for each in enclosures) else (),
        sum(len(each.root_parts) for each in enclosures),
        _FinerUnion(tuple(enclosures), tuple(ordered)) if any(each.finer for each in enclosures) else None,
    )


@dataclass(frozen=True, eq=False)
class _FinerUnion:
    """Refines a union: a part has children where the enclosure that it belongs to has."""

    enclosures: tuple[Enclosure, ...]
    places: tuple[tuple[int, int], ...]  # of the parts of the union: enclosure and part
    made: dict[int, Enclosure] = field(default_factory=dict)

    def __call__(self, part: int) -> Enclosure:
        """The union in which a part has children; ValueError if there is no finer cover of it."""
        if part not in self.made:
            own, i = self.places[part]
            refine = self.enclosures[own].finer
            if refine is None:
                raise ValueError(f"part {part} of an enclosure has no finer one")
            self.made[part] = united([refine(i) if k == own else each for k, each in enumerate(self.enclosures)])
        return self.made[part]


def _places(enclosures: Sequence[Enclosure]) -> list[tuple[int, int]]:
    """All parts as (enclosure, part): the roots of each, then the rest of each, whose order is kept."""
    roots = [(own, i) for own, each in enumerate(enclosures) for i in each.root_parts]
    rest = [(own, i) for own, each in enumerate(enclosures) for i in range(len(each.root_parts), len(each.parts))]
    return [*roots, *rest]
