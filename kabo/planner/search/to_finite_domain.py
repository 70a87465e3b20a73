"""Translates tasks without sensing to finite domains: a variable for the knowledge of each atom or term.

The packed searches of `kabo.finite_domain` then find the plan. Tasks that finite domains cannot express (with
numbers, inference, excluded values, geometric tests or sensing) are left to the searches over knowledge states.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import lcm

from kabo import tuning
from kabo.finite_domain import CompiledTask, Effect, FiniteTask, Operator, StateVariable
from kabo.finite_domain.task import Conditions
from kabo.knowledge import GroundAction, GroundedTask, Query
from kabo.knowledge.facts import AtomBits, TermBits
from kabo.knowledge.progression import Update
from kabo.knowledge.queries import All, AllOf, AnyOf, Some, union


class _NotFiniteDomain(Exception):
    """The task cannot be expressed in finite domains; caught in this module."""


def classical_task(task: GroundedTask) -> CompiledTask | None:
    """The compiled finite-domain task, or None if the task cannot be expressed; operators store action indices."""
    if task.branchings or not task.closure.is_empty:
        return None
    try:
        return CompiledTask(_Converter(task).converted())
    except _NotFiniteDomain:
        return None


@dataclass
class _KnowledgeVariable:
    """A variable: the bits of one atom or term, and the patterns of these bits that are its values."""

    number: int
    text: str
    mask: int
    patterns: list[int]


class _Converter:
    """Converts one task; equal updates are converted once."""

    def __init__(self, task: GroundedTask) -> None:
        self.task = task
        self.places: list[_KnowledgeVariable] = []
        self._home: dict[int, _KnowledgeVariable] = {}
        written = union(update.writes for action in task.actions for update in action.effects.updates)
        for group in task.groups:
            plain = isinstance(group, AtomBits) or (isinstance(group, TermBits) and not group.unequal)
            if not plain and (group.mask & written or not isinstance(group, TermBits)):
                raise _NotFiniteDomain
            place = _KnowledgeVariable(len(self.places), group.text, group.mask, [task.initial & group.mask])
            self.places.append(place)
            mask = group.mask
            while mask:
                bit = mask & -mask
                self._home[bit] = place
                mask ^= bit
        self._updates: dict[int, list[Effect]] = {}
        self._find_patterns()

    def _find_patterns(self) -> None:
        """Finds all patterns that updates can make, starting from the initial ones."""
        updates = {id(u): u for action in self.task.actions for u in action.effects.updates}
        writing: dict[int, list[tuple[int, int]]] = {}
        for update in updates.values():
            if update.assignment is not None:
                raise _NotFiniteDomain
            for place in self._touched(update.writes):
                writing.setdefault(place.number, []).append((update.clear, update.make))
        for number, pairs in writing.items():
            place = self.places[number]
            distinct = dict.fromkeys((clear & place.mask, make & place.mask) for clear, make in pairs)
            known = set(place.patterns)
            for pattern in place.patterns:  # grows while it is read
                for clear, make in distinct:
                    after = pattern & ~clear | make
                    if after not in known:
                        known.add(after)
                        place.patterns.append(after)

    def converted(self) -> FiniteTask:
        """The finite-domain task."""
        goals = self._alternatives(self.task.goal_query)
        if len(goals) != 1:
            raise _NotFiniteDomain
        scale = lcm(*(self._cost(action).denominator for action in self.task.actions))
        operators = tuple(o for action in self.task.actions for o in self._operators(action, scale))
        variables = tuple(StateVariable(place.text, len(place.patterns)) for place in self.places)
        return FiniteTask(variables, (0,) * len(variables), operators, goals[0])

    def _cost(self, action: GroundAction) -> Fraction:
        return Fraction(action.cost).limit_denominator(1000)

    def _operators(self, action: GroundAction, scale: int) -> Iterator[Operator]:
        cost = int(self._cost(action) * scale)
        for conditions in self._alternatives(action.precondition):
            effects = self._effects(action, conditions)
            yield Operator(str(action), conditions, effects, cost, action.index)

    # ---------------------------------------------------------------------------------------------- conditions
    def _alternatives(self, query: Query) -> list[Conditions]:
        """The query as a disjunction of conditions on variables; empty if it can never hold."""
        match query:
            case AllOf(mask, value):
                found = tuple(self._test(place, mask, value) for place in self._touched(mask))
                return [found] if all(values for _, values in found) else []
            case AnyOf(mask):
                return [
                    alternative
                    for place in self._touched(mask)
                    if (alternative := ((place.number, self._having(place, mask)),))[0][1]
                ]
            case Some():
                alternatives = [one for part in query.parts for one in self._alternatives(part)]
            case All():
                parts = [self._alternatives(part) for part in query.parts]
                alternatives = []
                if sum(len(part) > 1 for part in parts) > tuning.MAX_DISJUNCTIONS:
                    raise _NotFiniteDomain
                for chosen in product(*parts):
                    alternatives.append(tuple(condition for one in chosen for condition in one))
            case _:
                raise _NotFiniteDomain
        if len(alternatives) > tuning.MAX_ALTERNATIVES:
            raise _NotFiniteDomain
        return alternatives

    def _test(self, place: _KnowledgeVariable, mask: int, value: int) -> tuple[int, tuple[int, ...]]:
        own = mask & place.mask
        values = tuple(i for i, pattern in enumerate(place.patterns) if pattern & own == value & place.mask)
        return place.number, values

    def _having(self, place: _KnowledgeVariable, mask: int) -> tuple[int, ...]:
        return tuple(i for i, pattern in enumerate(place.patterns) if pattern & mask)

    def _touched(self, mask: int) -> list[_KnowledgeVariable]:
        found = []
        while mask:
            place = self._home[mask & -mask]
            found.append(place)
            mask &= ~place.mask
        return found

    # ------------------------------------------------------------------------------------------------- effects
    def _effects(self, action: GroundAction, conditions: Conditions) -> tuple[Effect, ...]:
        by_variable: dict[int, list[tuple[Effect, bool]]] = {}
        for update in action.effects.updates:
            for effect in self._converted_update(update):
                by_variable.setdefault(effect.variable, []).append((effect, bool(update.make)))
        effects: list[Effect] = []
        for found in by_variable.values():
            if len({effect.value for effect, _ in found}) == 1:
                effects += dict.fromkeys(effect for effect, _ in found)
            else:
                effects += self._add_wins(found, conditions)
        return tuple(effects)

    def _converted_update(self, update: Update) -> list[Effect]:
        known = self._updates.get(id(update))
        if known is None:
            known = self._updates[id(update)] = [
                effect
                for conditions in self._alternatives(update.condition)
                for place in self._touched(update.writes)
                for effect in self._on_place(place, update, conditions)
            ]
        return known

    def _on_place(self, place: _KnowledgeVariable, update: Update, conditions: Conditions) -> Iterator[Effect]:
        """The effects of an update on one variable; one for each old value where the new value depends on it."""
        clear, make = update.clear & place.mask, update.make & place.mask
        allowed = set(range(len(place.patterns)))
        for number, values in conditions:
            if number == place.number:
                allowed &= set(values)
        after = {old: place.patterns.index(place.patterns[old] & ~clear | make) for old in sorted(allowed)}
        if not make and all(old == new for old, new in after.items()):
            return  # what adds is kept, even if it changes nothing: it wins over, or is at odds with, other effects
        if len(set(after.values())) == 1:
            yield Effect(conditions, place.number, next(iter(after.values())))
            return
        for old, new in after.items():
            if old != new:
                yield Effect((*conditions, (place.number, (old,))), place.number, new)

    def _add_wins(self, found: Sequence[tuple[Effect, bool]], conditions: Conditions) -> Iterator[Effect]:
        """Resolves different effects on one variable: those that only forget give way to those that add.

        Packed searches let conditional effects win over unconditional ones: so forgetting that happens in any case
        need not say when it does not; then actions whose conditional effects are equal share them.
        """
        adding = list(dict.fromkeys(effect for effect, adds in found if adds))
        if not _exclude_each_other(adding):
            raise _NotFiniteDomain
        yield from adding
        for effect in dict.fromkeys(effect for effect, adds in found if not adds):
            sure = _without_implied(effect, dict(conditions))
            if not sure.conditions and all(other.conditions for other in adding):
                yield sure
                continue
            waiting = [effect]
            for other in adding:
                waiting = [
                    Effect((*one.conditions, (number, others)), one.variable, one.value)
                    for one in waiting
                    for number, values in other.conditions
                    if (others := self._others(number, values))
                ]
            if len(waiting) > tuning.MAX_ALTERNATIVES:
                raise _NotFiniteDomain
            yield from waiting

    def _others(self, number: int, values: Iterable[int]) -> tuple[int, ...]:
        excluded = set(values)
        return tuple(i for i in range(len(self.places[number].patterns)) if i not in excluded)


def _without_implied(effect: Effect, known: dict[int, tuple[int, ...]]) -> Effect:
    """The effect without the conditions that the preconditions imply."""
    left = tuple((n, v) for n, v in effect.conditions if n not in known or not set(known[n]) <= set(v))
    return Effect(left, effect.variable, effect.value)


def _exclude_each_other(effects: Sequence[Effect]) -> bool:
    """Whether no two effects with different values can happen at once."""
    tested = [dict(effect.conditions) for effect in effects]
    return all(
        one.value == other.value
        or any(
            number in tested[j] and set(values).isdisjoint(tested[j][number])
            for number, values in tested[i].items()
        )
        for i, one in enumerate(effects)
        for j, other in enumerate(effects[:i])
    )
