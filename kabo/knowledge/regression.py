"""Explanations: the bits of the state before a transition that decide the bits needed after it.

An explanation is a set of bits: the transition leads every state with the same values of these bits to a state with the
same needed bits. So a solved state is generalised to all states that fulfil what its plan needs [explanation-based
generalisation; as in goal regression, with the closure's inferences among the reasons].
"""

from kabo.knowledge.closure import Closure
from kabo.knowledge.entries import Entry, Trace
from kabo.knowledge.progression import Effects
from kabo.knowledge.queries import GeometricOracle, optimistic, union


def before_closure(closure: Closure, trace: Trace, after: int, needed: int) -> int:
    """The bits of the state before the closure that decide the bits `needed` of the state after it.

    Args:
        closure: all inferences of the problem.
        trace: the inferences that the closure drew, in order.
        after: the closed state.
        needed: bits of the closed state.
    """
    if needed & ~after & closure.makes or needed & after & closure.clears:
        needed |= closure.reads  # that nothing else was inferred depends on all bits from which it could be
    for written, reason in reversed(trace):
        if needed & written:
            needed = needed & ~written | reason
    return needed


def why_contradiction(trace: Trace) -> int:
    """The bits of the state before the closure that cause the contradiction with which the trace ends."""
    needed = trace[-1][1]
    for written, reason in reversed(trace[:-1]):
        if needed & written:
            needed = needed & ~written | reason
    return needed


def before_effects(effects: Effects, state: int, needed: int, test: GeometricOracle = optimistic) -> int:
    """The bits of `state` that decide the bits `needed` after the updates.

    They also decide that the updates do not contradict each other.
    """
    relevant, before, kept = needed | effects.contested, 0, needed
    entries = [entry for entry in effects.entries if entry.mask & needed]
    if entries:
        made = union(update.make for update in effects.updates if update.condition.holds(state, test))
        entries = [entry for entry in entries if not entry.active & made]
    for update in effects.updates:
        bits = update.assignment.bits.mask if update.assignment else 0
        bits |= union(c.whether for c in effects.conjunctions if c.about & update.touch)
        dropped = [entry for entry in entries if _touches(update.touch, entry)]
        if not (update.writes | bits) & relevant and not dropped:
            continue
        before |= update.condition.support(state, test)
        if not update.condition.holds(state, test):
            continue
        kept &= ~(update.writes | bits)
        if update.assignment is not None:
            before |= update.assignment.value.reads
        before |= union(entry.mask for entry in dropped)
    return before | kept


def _touches(touch: int, entry: Entry) -> bool:
    return any(member.group.mask & touch for member in entry.members)
