"""Enclosures of bodies that consist of several elements: the union of the elements' enclosures, trees included."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from kabo.geometry.parts import Enclosure

_Places = tuple[tuple[int, int], ...]  # of the parts of a union: enclosure, and part in it


def united(enclosures: Sequence[Enclosure]) -> Enclosure:
    """The enclosure of a union of bodies, from their own enclosures in the same frame.

    Roots come first, then the other parts of each tree. To refine a part refines the enclosure that it belongs to, and
    adds its children at the end: parts keep their numbers.

    Raises:
        ValueError: there is no enclosure.
    """
    if not enclosures:
        raise ValueError("a union of no bodies encloses nothing")
    if len(enclosures) == 1:
        return enclosures[0]
    roots = [(own, i) for own, each in enumerate(enclosures) for i in each.root_parts]
    rest = [(own, i) for own, each in enumerate(enclosures) for i in range(len(each.root_parts), len(each.parts))]
    return _united(tuple(enclosures), (*roots, *rest))


def _united(enclosures: tuple[Enclosure, ...], places: _Places) -> Enclosure:
    """The union with its parts at the given places."""
    number = {place: index for index, place in enumerate(places)}
    children = []
    for own, i in places:
        below = enclosures[own].children_of(i)
        children.append((number[own, below[0]] if below else 0, len(below)))
    return Enclosure(
        tuple(enclosures[own].parts[i] for own, i in places),
        max(each.deviation for each in enclosures),
        tuple(enclosures[own].rounding_of(i) for own, i in places)
        if any(each.roundings for each in enclosures)
        else (),
        tuple(enclosures[own].deviation_of(i) for own, i in places),
        tuple(children) if any(each.children for each in enclosures) else (),
        sum(len(each.root_parts) for each in enclosures),
        _FinerUnion(enclosures, places) if any(each.finer for each in enclosures) else None,
    )


@dataclass(frozen=True, eq=False)
class _FinerUnion:
    """Refines a union: a part has children where the enclosure that it belongs to has."""

    enclosures: tuple[Enclosure, ...]
    places: _Places
    made: dict[int, Enclosure] = field(default_factory=dict)

    def __call__(self, part: int) -> Enclosure:
        """The union in which a part has children; ValueError if there is no finer cover of it."""
        if part not in self.made:
            own, i = self.places[part]
            before = self.enclosures[own]
            if before.finer is None:
                raise ValueError(f"part {part} of an enclosure has no finer one")
            after = before.finer(i)
            changed = tuple(after if k == own else each for k, each in enumerate(self.enclosures))
            added = tuple((own, k) for k in range(len(before.parts), len(after.parts)))
            self.made[part] = _united(changed, (*self.places, *added))
        return self.made[part]
