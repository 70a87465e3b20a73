"""Entries of Kx and Kor (exactly one, or at least one, of some claims holds), and their inferences by unit propagation.

An entry whose members no action changes is *permanent*: every state has it, and it takes no bits. Any other entry has
a bit that says whether the state has it, and one for each member that was dropped because it is known to be false.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

from kabo.knowledge.facts import Claim, TermBits

Event = tuple[int, int]  # the bits that an inference wrote, and the bits of the state before that are its reason
Trace = list[Event]


@dataclass(frozen=True)
class Entry:
    """An entry of Kx (`exactly`) or Kor; if it is permanent, `active` is 0 and `outs` is empty."""

    exactly: bool
    members: tuple[Claim, ...]
    active: int = 0
    outs: tuple[int, ...] = ()
    holds: int = field(init=False)
    fails: int = field(init=False)
    mask: int = field(init=False)  # its own bits

    def __post_init__(self) -> None:
        for name, bits in (
            ("holds", [member.holds for member in self.members]),
            ("fails", [member.fails for member in self.members]),
            ("mask", [self.active, *self.outs]),
        ):
            object.__setattr__(self, name, _union(bits))

    def __hash__(self) -> int:
        return hash((self.exactly, self.holds))

    @property
    def watches(self) -> int:
        """The bits whose change may lead to an inference; of a permanent Kor only those of false members."""
        return self.fails | self.active | (self.holds if self.exactly or self.active else 0)

    @property
    def makes(self) -> int:
        """The bits that an inference may set."""
        learned = _union(member.makes | (member.denied.makes if self.exactly else 0) for member in self.members)
        return learned | _union(self.outs)

    @cached_property
    def _member_by_failure(self) -> dict[int, Claim]:
        return {member.fails: member for member in self.members}

    def dropped_by(self, state: int, touched: int) -> bool:
        """Whether a change of the groups with the bits `touched` removes the entry.

        The change does so if one of these groups has a remaining member of the entry.
        """
        return bool(state & self.active) and any(
            member.group.mask & touched and not state & out
            for member, out in zip(self.members, self.outs, strict=True)
        )

    def propagate(self, state: int, trace: Trace | None) -> int | None:
        """The state with all inferences from the entry; None if the entry contradicts the state."""
        if not self.active:
            return self._permanent(state, trace)
        return self._revocable(state, trace) if state & self.active else state

    def _permanent(self, state: int, trace: Trace | None) -> int | None:
        held = state & self.holds
        if held:
            return self._others_fail(state, held, trace) if self.exactly else state
        left = self.fails & ~state
        if left & (left - 1):
            return state
        if not left:
            return contradiction(self.fails, trace)
        return learn(state, self._member_by_failure[left], self.fails & ~left, trace)

    def _others_fail(self, state: int, held: int, trace: Trace | None) -> int | None:
        if held & (held - 1):
            return contradiction(held, trace)
        after: int | None = state
        for member in self.members:
            if member.holds != held and after is not None and not after & member.fails:
                after = learn(after, member.denied, held, trace)
        return after

    def _revocable(self, state: int, trace: Trace | None) -> int | None:
        inside = []
        for member, out in zip(self.members, self.outs, strict=True):
            if state & out:
                continue
            if state & member.fails:
                note(trace, out, self.active | member.fails | out)
                state |= out
            else:
                inside.append((member, out))
        if not inside:
            return contradiction(self.mask, trace)
        held = [(member, out) for member, out in inside if state & member.holds]
        if held:
            return self._satisfied(state, inside, held, trace)
        if len(inside) > 1:
            return state
        after = learn(state, inside[0][0], self.mask, trace)
        return None if after is None else self._gone(after, self.mask, trace)

    def _satisfied(
        self, state: int, inside: list[tuple[Claim, int]], held: list[tuple[Claim, int]], trace: Trace | None
    ) -> int | None:
        true, out = held[0]
        reason = self.active | out | true.holds
        after: int | None = state
        if self.exactly:
            if len(held) > 1:
                return contradiction(reason | held[1][1] | held[1][0].holds, trace)
            for member, _ in inside:
                if member is not true and after is not None:
                    after = learn(after, member.denied, reason, trace)
        return None if after is None else self._gone(after, reason, trace)

    def _gone(self, state: int, reason: int, trace: Trace | None) -> int:
        note(trace, self.mask, reason)
        return state & ~self.mask


@dataclass(frozen=True)
class LastValue:
    """The inference that a term has its last value once all others are excluded."""

    term: TermBits

    @property
    def watches(self) -> int:
        """The bits whose change may lead to an inference."""
        return self.term.excluded | self.term.known

    @property
    def makes(self) -> int:
        """The bits that an inference may set."""
        return self.term.mask

    def propagate(self, state: int, trace: Trace | None) -> int | None:
        """The state in which the last possible value is known; None if all values are excluded."""
        term = self.term
        if state & term.known:
            return state
        left = term.excluded & ~state
        if not left:
            return contradiction(term.excluded, trace)
        if left & (left - 1):
            return state
        value = next(value for value, bit in term.unequal.items() if bit == left)
        return learn(state, term.claim(value, True), term.excluded & ~left, trace)


def learn(state: int, claim: Claim, reason: int, trace: Trace | None) -> int | None:
    """The state in which the claim is known, too; None, for a contradiction, if its complement is known."""
    if state & claim.fails:
        return contradiction(reason | claim.fails, trace)
    note(trace, claim.makes & ~state, reason)
    return state | claim.makes


def note(trace: Trace | None, written: int, reason: int) -> None:
    """Appends an inference to the trace, if there is one."""
    if trace is not None and written:
        trace.append((written, reason))


def contradiction(reason: int, trace: Trace | None) -> int | None:
    """Returns None for a contradiction; appends its reason to the trace as the last event, which writes no bit."""
    if trace is not None:
        trace.append((0, reason))
    return None


def _union(bits: Iterable[int]) -> int:
    result = 0
    for bit in bits:
        result |= bit
    return result
