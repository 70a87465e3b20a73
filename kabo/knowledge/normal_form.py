"""One form for knowledge that says the same: states that differ only in how they say it are one node of the search.

Entries of Kx and Kor come and go with actions, and often say what another one says already: "at least one of p, q, r"
beside "at least one of p, q", "exactly one of p and q" beside "exactly one of not p and not q". Here only what may go
without any loss goes: every change that drops what remains would have dropped what went as well. So equal forms have
equal futures. The form tells nodes apart and is no state.
"""

from collections.abc import Iterable, Iterator, Sequence

from kabo.knowledge.entries import Entry
from kabo.knowledge.queries import union

_Members = frozenset[int]  # the bits that say that a member is known to hold
_Said = tuple[str, _Members]

KEPT = 50_000  # sets of entries whose form is remembered


class NormalForm:
    """The normal form of the entries in states of one task."""

    def __init__(self, entries: Iterable[Entry], width: int) -> None:
        self._entries = [entry for entry in entries if entry.active]
        self._mask = union(entry.mask for entry in self._entries)
        self._width = width  # of states: bits of the form lie above
        self._denied = {member.holds: member.denied.holds for entry in self._entries for member in entry.members}
        self._denied |= {denied: holds for holds, denied in self._denied.items()}
        self._bits: dict[_Said, int] = {}
        self._known: dict[int, int] = {0: 0}

    def of(self, state: int) -> int:
        """The state with bits of the form in the place of those of entries; equal for states that say the same."""
        own = state & self._mask
        if not own:
            return state
        form = self._known.get(own)
        if form is None:
            if len(self._known) >= KEPT:
                self._known.clear()
            form = self._known[own] = self._form(own)
        return state ^ own | form

    def _form(self, own: int) -> int:
        said = dict.fromkeys(_without_the_implied(self._pairs(self._said(own)), self._denied))
        return union(self._bit(each) for each in said)

    def _said(self, own: int) -> Iterator[_Said]:
        """What each entry of the state says, of the members that are left."""
        for entry in self._entries:
            if own & entry.active:
                left = zip(entry.members, entry.outs, strict=True)
                members = frozenset(member.holds for member, out in left if not own & out)
                yield ("exactly" if entry.exactly else "some"), members

    def _pairs(self, said: Iterable[_Said]) -> list[_Said]:
        """Two that are never equal as one thing: one of them holds, or one of them fails, or both is said."""
        found = list(dict.fromkeys(said))
        some = {members for kind, members in found if kind == "some" and len(members) == 2}
        result: list[_Said] = []
        for kind, members in found:
            both = kind == "some" and members in some and self._opposite(members) in some
            if len(members) == 2 and (kind == "exactly" or both):
                result.append(("unequal", min(members, self._opposite(members), key=sorted)))
            else:
                result.append((kind, members))
        return result

    def _opposite(self, members: _Members) -> _Members:
        return frozenset(self._denied[member] for member in members)

    def _bit(self, said: _Said) -> int:
        """A bit for what is said, above all bits of states, in the order in which such things are met."""
        if said not in self._bits:
            self._bits[said] = 1 << (self._width + len(self._bits))
        return self._bits[said]


def _without_the_implied(said: Sequence[_Said], denied: dict[int, int]) -> Iterator[_Said]:
    """Without "some of these" where that follows from something about a part of them."""
    some = [members for kind, members in said if kind == "some"]
    more = [members for kind, members in said if kind != "some"]
    more += [frozenset(denied[member] for member in members) for kind, members in said if kind == "unequal"]
    for kind, members in said:
        follows = any(part < members for part in some) or any(part <= members for part in more)
        if kind != "some" or not follows:
            yield kind, members
