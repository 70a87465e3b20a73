"""A normal form of states: states with equivalent entries are one node of the search.

Actions add and remove entries of Kx and Kor, which often imply each other: "at least one of p, q, r" follows from
"at least one of p, q", and "exactly one of p and q" is "exactly one of not p and not q". An entry that follows
from another entry is left out of the normal form only if every action that removes the other entry would also
remove it. So states with equal normal forms have equal futures. A normal form identifies a search node; it is not
a state.
"""

from collections.abc import Iterable, Iterator, Sequence

from kabo.knowledge.entries import Entry
from kabo.knowledge.queries import union

_Members = frozenset[int]  # the bits that say that a member is known to hold
_Constraint = tuple[str, _Members]

MAX_REMEMBERED = 50_000  # sets of entries whose form is kept


class NormalForm:
    """Computes the normal form of the entries in states of one task."""

    def __init__(self, entries: Iterable[Entry], width: int) -> None:
        self._entries = [entry for entry in entries if entry.active]
        self._mask = union(entry.mask for entry in self._entries)
        self._width = width  # bits of a state; bits of forms lie above
        self._denied = {member.holds: member.denied.holds for entry in self._entries for member in entry.members}
        self._denied |= {denied: holds for holds, denied in self._denied.items()}
        self._bits: dict[_Constraint, int] = {}
        self._known: dict[int, int] = {0: 0}

    def of(self, state: int) -> int:
        """The state with its entries' bits replaced by those of their normal form; equal for equivalent states."""
        own = state & self._mask
        if not own:
            return state
        form = self._known.get(own)
        if form is None:
            if len(self._known) >= MAX_REMEMBERED:
                self._known.clear()
            form = self._known[own] = self._form(own)
        return state ^ own | form

    def _form(self, own: int) -> int:
        constraints = dict.fromkeys(_without_the_implied(self._pairs(self._constraints(own)), self._denied))
        return union(self._bit(each) for each in constraints)

    def _constraints(self, own: int) -> Iterator[_Constraint]:
        """The constraint that each entry of the state puts on the members that are left."""
        for entry in self._entries:
            if own & entry.active:
                left = zip(entry.members, entry.outs, strict=True)
                members = frozenset(member.holds for member, out in left if not own & out)
                yield ("exactly" if entry.exactly else "some"), members

    def _pairs(self, constraints: Iterable[_Constraint]) -> list[_Constraint]:
        """Constraints on two complementary members in one spelling: at least one holds, at least one fails, or both."""
        found = list(dict.fromkeys(constraints))
        some = {members for kind, members in found if kind == "some" and len(members) == 2}
        result: list[_Constraint] = []
        for kind, members in found:
            both = kind == "some" and members in some and self._opposite(members) in some
            if len(members) == 2 and (kind == "exactly" or both):
                result.append(("unequal", min(members, self._opposite(members), key=sorted)))
            else:
                result.append((kind, members))
        return result

    def _opposite(self, members: _Members) -> _Members:
        return frozenset(self._denied[member] for member in members)

    def _bit(self, constraint: _Constraint) -> int:
        """The bit of a constraint, above all bits of states, in the order in which constraints first occur."""
        if constraint not in self._bits:
            self._bits[constraint] = 1 << (self._width + len(self._bits))
        return self._bits[constraint]


def _without_the_implied(constraints: Sequence[_Constraint], denied: dict[int, int]) -> Iterator[_Constraint]:
    """The constraints without each "at least one of these" that follows from a constraint on some of its members."""
    some = [members for kind, members in constraints if kind == "some"]
    more = [members for kind, members in constraints if kind != "some"]
    more += [frozenset(denied[member] for member in members) for kind, members in constraints if kind == "unequal"]
    for kind, members in constraints:
        follows = any(part < members for part in some) or any(part <= members for part in more)
        if kind != "some" or not follows:
            yield kind, members
