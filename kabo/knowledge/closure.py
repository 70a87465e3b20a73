"""The closure of knowledge after every change: entries, last values and update rules, to a fixpoint.

Source: docs/explanation/knowledge.md; P.

Inference is by unit propagation: polynomial and sound, without case splits. With a trace, every step records the bits
that it wrote and the bits that are its reason, so that inferences can be explained (see `regression.py`).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from kabo.errors import Diagnostic, InputError
from kabo.knowledge.entries import Entry, Trace, contradiction, note
from kabo.knowledge.queries import Query, bits_of, union
from kabo.language.formulas import Place

MAX_ROUNDS = 1000  # rounds of update rules; rules that still change something then are refused
MAX_REMEMBERED = 20_000  # closures kept, since search, reordering and explanation ask for the same ones


class UnitPropagator(Protocol):
    """A source of inferences by unit propagation: an entry of Kx or Kor, or the values of a term."""

    @property
    def watches(self) -> int:
        """The bits whose change may lead to an inference."""
        ...

    @property
    def makes(self) -> int:
        """The bits that an inference may set."""
        ...

    def propagate(self, state: int, trace: Trace | None) -> int | None:
        """The state with all inferences from this source; None if they contradict the state."""
        ...


@dataclass(frozen=True)
class Rule:
    """A ground update rule: when the condition holds, the bits `clear` are cleared, then the bits `make` set."""

    condition: Query
    clear: int
    make: int
    against: int = 0  # bits that contradict its conclusions
    place: Place | None = None

    @property
    def watches(self) -> int:
        """The bits that the rule reads, and those that it writes: forgotten conclusions are drawn again."""
        return self.condition.reads | self.clear | self.make


@dataclass(frozen=True)
class AlwaysMonitor:
    """The monitor of a goal `always(φ)`: the bit `held` is cleared as soon as φ does not hold in a state."""

    condition: Query
    held: int


class Closure:
    """All inferences of one problem, applied to states until nothing changes."""

    def __init__(
        self,
        propagators: Sequence[UnitPropagator] = (),
        rules: Sequence[Rule] = (),
        monitors: Sequence[AlwaysMonitor] = (),
        exclusive: Iterable[int] = (),
    ) -> None:
        self.propagators, self.rules, self.monitors = tuple(propagators), tuple(rules), tuple(monitors)
        self._exclusive = tuple(exclusive)  # masks of bits of which rules must not set two
        self._watching: dict[int, list[int]] = {}
        for number, propagator in enumerate(self.propagators):
            for bit in bits_of(propagator.watches):
                self._watching.setdefault(bit, []).append(number)
        self._watched = union(self._watching)
        self._active = [p.active if isinstance(p, Entry) else 0 for p in self.propagators]  # 0: always
        # From a permanent entry nothing follows while two members may hold (and, of Kx, none is known to hold).
        self._fails = [p.fails if isinstance(p, Entry) and not p.active else 0 for p in self.propagators]
        self._decisive = [p.holds if isinstance(p, Entry) and p.exactly else 0 for p in self.propagators]
        # Nor from a permanent Kor of which a member is known to hold.
        self._settled = [
            p.holds if isinstance(p, Entry) and not p.exactly and not p.active else 0 for p in self.propagators
        ]
        self._known: dict[tuple[int, int], tuple[int | None, Trace]] = {}  # state and what changed in it
        self._rule_watch = union(rule.watches for rule in self.rules)
        self._telling = self._watched | self._rule_watch
        self._rules_of: dict[int, list[int]] = {}
        for number, rule in enumerate(self.rules):
            for bit in bits_of(rule.watches) if rule.watches else [0]:
                self._rules_of.setdefault(bit, []).append(number)
        self.is_empty = not (self.propagators or self.rules or self.monitors)
        entries = [p for p in self.propagators if isinstance(p, Entry)]
        self.reads = self._telling | union(entry.mask | entry.holds for entry in entries)
        self._revocable = [entry for entry in entries if entry.active]
        self._entering = union(entry.active for entry in self._revocable)
        # Bits that inference may clear, or set although they were 0: explaining their values takes all of `reads`.
        self.clears = union(rule.clear for rule in self.rules)
        self.makes = union(p.makes for p in self.propagators) | union(rule.make for rule in self.rules)

    def complete(self, state: int, changed: int, trace: Trace | None = None) -> int | None:
        """The closure of a state that differs from a closed state in the bits `changed` only.

        Returns:
            the closed state, or None if the state contradicts itself; then the last event of the trace is the reason.

        Raises:
            InputError: the update rules still change something after `MAX_ROUNDS` rounds.
        """
        if not (changed & self._telling or self.monitors):
            return state
        known = self._known.get((state, changed))
        if known is None:
            events: Trace = []
            if len(self._known) >= MAX_REMEMBERED:
                self._known.clear()
            known = self._known[state, changed] = self._completed(state, changed, events), events
        if trace is not None:
            trace += known[1]
        return known[0]

    def _completed(self, state: int, changed: int, trace: Trace) -> int | None:
        for _ in range(MAX_ROUNDS):
            after = self._propagated(state, changed, trace) if changed & self._watched else state
            if after is None:
                return None
            changed |= state ^ after
            state = after
            if not self.rules or not changed & self._rule_watch:
                break
            after = self._fired(state, changed, trace)
            if after is None:
                return None
            if after == state:
                break
            changed, state = state ^ after, after
        else:
            raise _unsettled(self.rules)
        return self._monitored(state, trace)

    def consistent_by(self, made: int, written: int, trace: Trace) -> int:
        """The bits that decide that an action's effects and the inferences from them do not contradict each other.

        Args:
            made: the bits that the action set.
            written: the bits that the action may write.
            trace: the inferences that the closure drew from the effects.
        """
        entries = [entry for entry in self._revocable if entry.active & made] if made & self._entering else []
        needed = union(entry.holds | entry.fails for entry in entries)
        own = union(entry.mask for entry in entries)
        if entries and any(bits & ~own for bits, _ in trace):
            needed |= self.reads
        if written & self._rule_watch:
            needed |= union(rule.watches | rule.against for rule in self.rules if rule.watches & written)
        return needed

    def _propagated(self, state: int, changed: int, trace: Trace | None) -> int | None:
        waiting = [number for bit in bits_of(changed & self._watched) for number in self._watching[bit]]
        waiting = list(dict.fromkeys(waiting))
        queued = set(waiting)
        for number in waiting:
            queued.discard(number)
            active = self._active[number]
            if active and not state & active:
                continue
            if state & self._settled[number]:
                continue
            left = self._fails[number] & ~state
            if left & (left - 1) and not state & self._decisive[number]:
                continue
            after = self.propagators[number].propagate(state, trace)
            if after is None:
                return None
            if after != state:
                for bit in bits_of((state ^ after) & self._watched):
                    for other in self._watching[bit]:
                        if other not in queued:
                            queued.add(other)
                            waiting.append(other)
                state = after
        return state

    def _fired(self, state: int, changed: int, trace: Trace | None) -> int | None:
        """The state after one round of rules, all of whose conditions are evaluated first."""
        clear = make = reason = 0
        numbers = sorted({n for bit in bits_of(changed & self._rule_watch) for n in self._rules_of[bit]})
        for number in (*self._rules_of.get(0, ()), *numbers):
            rule = self.rules[number]
            if state & ~rule.clear | rule.make != state and rule.condition.holds(state):
                if trace is not None:
                    reason |= rule.condition.support(state)
                if state & rule.against:
                    return contradiction(reason | state & rule.against, trace)
                clear, make = clear | rule.clear, make | rule.make
        if not make and not clear:
            return state
        for mask in self._exclusive:
            if make & mask and make & mask & ((make & mask) - 1):
                return contradiction(reason, trace)
        after = state & ~clear | make
        note(trace, state ^ after, reason)
        return after

    def _monitored(self, state: int, trace: Trace | None) -> int:
        for monitor in self.monitors:
            if state & monitor.held:
                if trace is not None:
                    trace.append((monitor.held, monitor.held | monitor.condition.support(state)))
                if not monitor.condition.holds(state):
                    state &= ~monitor.held
        return state


def _unsettled(rules: Sequence[Rule]) -> InputError:
    place = next((rule.place for rule in rules if rule.place is not None), None)
    message = f"the update rules still change something after {MAX_ROUNDS} rounds"
    where = (place.file, place.line, place.column) if place else ("", 1, 1)
    return InputError([Diagnostic(*where, message)])
