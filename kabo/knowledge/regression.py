"""Explanations: which bits of the state before make the bits that are needed after a transition.

An explanation is a set of bits: any state that has the same values there goes through the transition to a state
that has the needed ones. It generalises solved states to all that have what their plan needs [explanation-based
generalisation; as in goal regression, with the closure's inferences among the reasons].
"""

from kabo.knowledge.closure import Closure
from kabo.knowledge.entries import Entry, Trace
from kabo.knowledge.progression import Effects
from kabo.knowledge.queries import GeometricOracle, optimistic, union


def before_closure(closure: Closure, trace: Trace, after: int, needed: int) -> int:
    """Bits before the closure that give the needed bits after it.

    Args:
        closure: what may follow.
        trace: what did follow, in order.
        after: the closed state.
        needed: bits of it.
    """
    if needed & ~after & closure.makes or needed & after & closure.clears:
        needed |= closure.reads  # that nothing else follows depends on everything from which it could
    for written, reason in reversed(trace):
        if needed & written:
            needed = needed & ~written | reason
    return needed


def why_contradiction(trace: Trace) -> int:
    """Bits before the closure that make it contradict itself; the trace ends with the contradiction."""
    needed = trace[-1][1]
    for written, reason in reversed(trace[:-1]):
        if needed & written:
            needed = needed & ~written | reason
    return needed


def before_effects(effects: Effects, state: int, needed: int, test: GeometricOracle = optimistic) -> int:
    """Bits of the state before that give the bits `needed` after the updates, and that the updates are consistent."""
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
