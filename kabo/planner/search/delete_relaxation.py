"""The delete relaxation of a knowledge task, in which no fact that was ever true or known is lost.

Its facts are: the bits of knowledge states (known true, known false, known whether …); that a bit is not set, if
some condition requires it; and that an atom is *unknown*. Sensing requires that the atom is unknown, and adds both
outcomes. A known atom becomes unknown only if an action forgets it, so that sensing a known atom achieves nothing.
"""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from kabo import tuning
from kabo.arrays import Integers
from kabo.finite_domain import Estimate, RelaxedOperator, RelaxedTask
from kabo.knowledge import GroundAction, GroundedTask, Query
from kabo.knowledge.entries import Entry, LastValue
from kabo.knowledge.facts import Claim, open_entries
from kabo.knowledge.progression import Effects, Update
from kabo.knowledge.queries import All, AllOf, AnyOf, Some, bits_of, union
from kabo.language.formulas import GroundCall


class Relaxation:
    """Estimates the cost from a knowledge state to goal conjuncts, and finds the preferred actions."""

    def __init__(self, task: GroundedTask, refused: frozenset[GroundCall] = frozenset()) -> None:
        """The relaxation without the actions whose calls are `refused`."""
        builder = _KnowledgeRelaxation(task, [action for action in task.actions if action.call not in refused])
        self._width, self._zeros, self._sensed = task.width, builder.zeros, builder.sensed
        self._parts = [builder.facts_of(part.query) for part in task.goal]
        self._goals: dict[tuple[int, ...], tuple[int, ...]] = {}
        self._known: dict[tuple[int, tuple[int, ...]], Estimate] = {}  # one search comes where another one was
        asked = sorted({f for o in builder.operators for f in o.preconditions}.union(*self._parts))
        self._place = {fact: place for place, fact in enumerate(asked)}  # what nobody asks for is left out
        self._asked = np.array([fact for fact in asked if fact < 3 * task.width], np.int64)
        self._bytes = (3 * task.width + 7) // 8
        self.operators = list(self._needed(builder.operators))
        self.task = RelaxedTask(len(asked), self.operators, ())

    def _needed(self, operators: Iterable[RelaxedOperator]) -> Iterator[RelaxedOperator]:
        """The operators, restricted to facts that some condition asks for."""
        place = self._place
        kept: dict[tuple[int, ...], tuple[int, ...]] = {}  # operators share what they add
        for preconditions, made, cost, owner in operators:
            adds = kept.get(made)
            if adds is None:
                adds = kept[made] = tuple([place[fact] for fact in made if fact in place])
            if adds:
                yield RelaxedOperator(tuple([place[f] for f in preconditions]), adds, cost, owner)

    def estimate(self, state: int, parts: Sequence[int]) -> Estimate:
        """The cost and the preferred actions of a relaxed plan from a state to some goal conjuncts."""
        chosen = tuple(parts)
        known = self._known.get((state, chosen))
        if known is None:
            if len(self._known) >= tuning.MAX_REMEMBERED_ESTIMATES:
                self._known.clear()
            known = self._known[state, chosen] = self._estimated(state, chosen)
        return known

    def _estimated(self, state: int, chosen: tuple[int, ...]) -> Estimate:
        return self.task.evaluate(self.true_in(state), self.goal_of(chosen))

    def goal_of(self, chosen: tuple[int, ...]) -> tuple[int, ...]:
        """The facts of the relaxation that some goal conjuncts require."""
        goal = self._goals.get(chosen)
        if goal is None:
            goal = tuple(dict.fromkeys(self._place[fact] for part in chosen for fact in self._parts[part]))
            self._goals[chosen] = goal
        return goal

    def true_in(self, state: int) -> Integers:
        """The indices of the facts of the relaxation that are true in a state."""
        width = self._width
        unknown = self._sensed & ~(state << 1 | state << 2)
        pending = (unknown & state) >> 1
        facts = state | (~state & self._zeros) << width | (unknown | pending) << 2 * width
        bits = np.unpackbits(np.frombuffer(facts.to_bytes(self._bytes, "little"), np.uint8), bitorder="little")
        return bits.take(self._asked).view(np.bool_).nonzero()[0]


class _KnowledgeRelaxation:
    """Makes the operators of the relaxation.

    Fact k means that bit k is set, and fact width + k that it is clear. For the bit k of Kw or Kv, fact 2 width + k
    means unknown so far, and fact 2 width + k - 1 means sensed and still open.
    """

    def __init__(self, task: GroundedTask, actions: Sequence[GroundAction]) -> None:
        self._width, self._whether = task.width, task.whether
        self.operators: list[RelaxedOperator] = []
        self.auxiliary = 0
        self.zeros = 0
        self._known: dict[Query, int] = {}
        self._updates: dict[int, list[Update]] = {}
        self._facts_made: dict[tuple[int, int], tuple[int, ...]] = {}
        self.sensed = task.pending
        self._choices = {entry: union(c.make for c in b.choices) for entry, b in task.branchings.items()}
        self._known_of = {entry: union(c.make for c in b.choices) & ~entry for entry, b in task.branchings.items()}
        conditions = [(action, self.facts_of(action.precondition)) for action in actions]
        effects = [
            (action, update, (*facts, *self.facts_of(update.condition)))
            for action, facts in conditions
            for update in self._merged(action.effects)
        ]
        rules = [(rule, self.facts_of(rule.condition)) for rule in task.closure.rules]
        for part in task.goal:
            self.facts_of(part.query)
        for action, update, facts in effects:
            self._effect(action, update, facts)
        for rule, facts in rules:
            self._axiom(facts, self._changed(rule.make, rule.clear))
        for entry, made in self._choices.items():
            self._axiom((2 * self._width + _number(entry) - 1,), self._changed(made, 0))
        for propagator in task.closure.propagators:
            if isinstance(propagator, Entry):
                self._entry(propagator)
            elif isinstance(propagator, LastValue):
                term = propagator.term
                claims = [term.claim(value, False) for value in term.equal]
                self._all_but_one([c.holds for c in claims], [c.denied for c in claims], ())

    # ---------------------------------------------------------------------------------------------- conditions
    def facts_of(self, query: Query) -> tuple[int, ...]:
        """Facts that must all be true before the query can hold; conditions on numbers and geometry are ignored."""
        match query:
            case AllOf(mask, value):
                zeros = mask & ~value
                self.zeros |= zeros
                return tuple(_numbers(value) + _numbers(zeros << self._width))
            case All():
                return tuple(dict.fromkeys(fact for part in query.parts for fact in self.facts_of(part)))
            case AnyOf(mask):
                return (self._one_of(query, (AllOf(bit, bit) for bit in bits_of(mask))),)
            case Some():
                return (self._one_of(query, query.parts),)
        return ()

    def _one_of(self, query: Query, parts: Iterable[Query]) -> int:
        """A new fact that is true as soon as one of the parts is."""
        if query not in self._known:
            self._known[query] = self._fact()
            for part in parts:
                self._axiom(self.facts_of(part), (self._known[query],))
        return self._known[query]

    def _fact(self) -> int:
        self.auxiliary += 1
        return 3 * self._width + self.auxiliary - 1

    # ------------------------------------------------------------------------------------------------- effects
    def _merged(self, effects: Effects) -> Sequence[Update]:
        """The updates of an action: equal conditions merged, sensing kept apart; cached, for actions share effects."""
        known = self._updates.get(id(effects))
        if known is None:
            known = self._updates[id(effects)] = list(self._merge(effects))
        return known

    def _merge(self, effects: Effects) -> Iterator[Update]:
        merged: dict[Query, Update] = {}
        for update in effects.updates:
            if open_entries(update.make, self._whether):
                yield update
                continue
            bits = update.assignment.bits.known | update.assignment.bits.whether if update.assignment else 0
            other = merged.get(update.condition)
            clear, make = (other.clear, other.make) if other else (0, 0)
            merged[update.condition] = Update(update.condition, clear | update.clear, make | update.make | bits)
        yield from merged.values()

    def _effect(self, action: GroundAction, update: Update, facts: tuple[int, ...]) -> None:
        opened = open_entries(update.make, self._whether)
        if not opened:
            self._operator(facts, self._changed(update.make, update.clear), action)
            return
        for entry in bits_of(opened):
            made = update.make | self._choices.get(entry, 0)
            unknown = (2 * self._width + _number(entry),) if entry in self._choices else ()
            self._operator((*facts, *unknown), self._changed(made, update.clear), action)

    def _changed(self, make: int, clear: int) -> tuple[int, ...]:
        """The facts that an update makes true."""
        known = self._facts_made.get((make, clear))
        if known is None:
            known = self._facts_made[make, clear] = self._found_changed(make, clear)
        return known

    def _found_changed(self, make: int, clear: int) -> tuple[int, ...]:
        made = _numbers(make) + _numbers((clear & ~make & self.zeros) << self._width)
        for entry in bits_of(clear & ~make & self.sensed):
            if not make & self._known_of.get(entry, 0):
                made.append(2 * self._width + _number(entry))
        return tuple(made)

    def _operator(self, preconditions: Sequence[int], adds: tuple[int, ...], action: GroundAction) -> None:
        if adds:
            self.operators.append(RelaxedOperator(tuple(dict.fromkeys(preconditions)), adds, 1, action.index))

    def _axiom(self, preconditions: Sequence[int], adds: tuple[int, ...]) -> None:
        if adds:
            self.operators.append(RelaxedOperator(tuple(preconditions), adds, 0))

    # ------------------------------------------------------------------------------------------------- entries
    def _entry(self, entry: Entry) -> None:
        active = (_number(entry.active),) if entry.active else ()
        if entry.exactly:
            for member in entry.members:
                others = union(other.denied.makes for other in entry.members if other is not member)
                self._axiom((_number(member.holds), *active), self._changed(others, 0))
        self._all_but_one([member.fails for member in entry.members], entry.members, active)

    def _all_but_one(self, fails: Sequence[int], claims: Sequence[Claim], also: tuple[int, ...]) -> None:
        """Axioms: each claim follows if all others fail; facts for prefixes and suffixes keep their number linear."""
        numbers = [_number(bit) for bit in fails]
        before, behind = self._running(numbers), self._running(numbers[::-1])[::-1]
        for i, claim in enumerate(claims):
            left = (before[i - 1],) if i else ()
            right = (behind[i + 1],) if i + 1 < len(claims) else ()
            self._axiom((*left, *right, *also), self._changed(claim.makes, 0))

    def _running(self, numbers: Sequence[int]) -> list[int]:
        """For each position a fact that is true if all up to there are."""
        running = list(numbers[:1])
        for number in numbers[1:]:
            fact = self._fact()
            self._axiom((running[-1], number), (fact,))
            running.append(fact)
        return running


def _number(bit: int) -> int:
    return bit.bit_length() - 1


def _numbers(mask: int) -> list[int]:
    """The numbers of the bits of a mask, from the lowest on."""
    return [bit.bit_length() - 1 for bit in bits_of(mask)]
