"""The refusal table compiled into a finite-domain task: refusals become conditions, suspicions become costs.

Each component that a refusal or suspicion names gets a variable for its provenance; one value of the variable
stands for all provenances that no refusal or suspicion names. Calls set the variable. Each operator is replaced by
variants whose preconditions exclude the refusals of its call. Variants whose preconditions also exclude the
suspicions cost less than the others. The packed searches thus use everything that was learnt from geometry, at
full speed.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from kabo import tuning
from kabo.finite_domain import CompiledTask, Effect, FiniteTask, Operator, StateVariable
from kabo.knowledge import GroundAction
from kabo.language.formulas import GroundCall
from kabo.planner.search.skeleton import LearntRefusals, Pattern, Provenance

OTHER = 0  # the value of a variable whose provenance is not named

Allowed = dict[int, frozenset[int]]  # variable: the values that it may have


@dataclass(frozen=True)
class LearntTask:
    """A finite-domain task with compiled refusals, and for each operator the attempt at its call.

    `whole`: whether all variants of the operators are included; if not, the task may be unsolvable although a plan
    exists.
    """

    compiled: CompiledTask
    attempts: tuple[int, ...]
    whole: bool


def learnt_task(base: FiniteTask, actions: Sequence[GroundAction], learnt_refusals: LearntRefusals) -> LearntTask:
    """The finite-domain task `base` extended by the refusals and suspicions that were learnt.

    Args:
        base: the task without geometry.
        actions: the actions of the knowledge task; each operator stores the index of its action in this list.
        learnt_refusals: the refusals, the suspicions, and the provenances that they name.
    """
    return _Learnt(base, actions, learnt_refusals).made()


class _Learnt:
    def __init__(self, base: FiniteTask, actions: Sequence[GroundAction], learnt_refusals: LearntRefusals) -> None:
        self.base, self.actions, self.learnt_refusals = base, actions, learnt_refusals
        self.whole = True
        named: dict[int, list[int]] = {}
        for component, number in learnt_refusals.named:
            named.setdefault(component, []).append(number)
        self._variables: list[StateVariable] = []
        self._initial: list[int] = []
        self._number: dict[int, int] = {}  # variable of a component
        self._value: dict[Provenance, int] = {}
        for component, numbers in named.items():
            self._number[component] = len(base.variables) + len(self._variables)
            self._variables.append(StateVariable(f"lineage {component}", 1 + len(numbers)))
            self._value.update({(component, number): 1 + k for k, number in enumerate(numbers)})
            self._initial.append(self._value.get((component, 0), OTHER))
        self._made: dict[tuple[GroundCall, int], list[tuple[Provenance, Pattern]]] = {}
        for entry, origins in learnt_refusals.origins.items():
            for origin in origins:
                self._made.setdefault((origin.call, origin.attempt), []).append((entry, origin.reads))
        self._sizes = {n: v.size for n, v in enumerate(self._variables, len(base.variables))}

    def made(self) -> LearntTask:
        operators: list[Operator] = []
        attempts: list[int] = []
        for plain in self.base.operators:
            call = self.actions[plain.owner].call
            scaled = replace(plain, cost=plain.cost * tuning.ACTION_PRICE)
            for operator, attempt in [(scaled, 0)] if call is None else self._with_call(scaled, call):
                operators.append(operator)
                attempts.append(attempt)
        variables = (*self.base.variables, *self._variables)
        task = FiniteTask(variables, (*self.base.initial, *self._initial), tuple(operators), self.base.goal)
        return LearntTask(CompiledTask(task), tuple(attempts), self.whole)

    def _with_call(self, plain: Operator, call: GroundCall) -> Iterable[tuple[Operator, int]]:
        """An operator for every attempt that remains, where it is not refused; those without a suspicion come first."""
        refusals = self.learnt_refusals.refusals.get(call, ())
        often = min(tuning.REFUSAL_PRICE * len(refusals), tuning.MAX_REFUSAL_PRICE)
        for attempt in range(self.learnt_refusals.attempts):
            before = [{}] if attempt == 0 else [self._holding(p) for p in self._leading(call, attempt - 1)]
            if not before:
                return
            refused = [pattern for first, pattern in refusals if first <= attempt]
            effects = (*plain.effects, *self._effects(call, attempt))
            cost = plain.cost + tuning.RETRY_PRICE * attempt + often
            free = self._avoiding(before, refused)
            clear = self._avoiding(free, self.learnt_refusals.suspicions.get(call, ()))
            for allowed, price in [(each, 0) for each in clear] + [
                (each, tuning.SUSPICION_PRICE) for each in free if each not in clear
            ]:
                conditions = tuple((n, tuple(sorted(values))) for n, values in sorted(allowed.items()))
                made = replace(
                    plain,
                    preconditions=(*plain.preconditions, *conditions),
                    effects=effects,
                    cost=cost + price,
                )
                yield made, attempt

    def _leading(self, call: GroundCall, attempt: int) -> list[Pattern]:
        """The patterns in which an attempt led to a named provenance."""
        return list(dict.fromkeys(reads for _, reads in self._made.get((call, attempt), ())))

    def _effects(self, call: GroundCall, attempt: int) -> Iterable[Effect]:
        for component in self.learnt_refusals.moves(call):
            number = self._number.get(component)
            if number is None:
                continue
            yield Effect((), number, OTHER)
            for entry, reads in self._made.get((call, attempt), ()):
                if entry[0] == component:
                    holding = self._holding(reads)
                    conditions = tuple((n, tuple(sorted(values))) for n, values in sorted(holding.items()))
                    yield Effect(conditions, number, self._value[entry])

    def _holding(self, pattern: Pattern) -> Allowed:
        """The values of variables with which a pattern of provenances holds."""
        return {self._number[i]: frozenset([self._value[i, number]]) for i, number in pattern}

    def _avoiding(self, ways: Sequence[Allowed], patterns: Iterable[Pattern]) -> list[Allowed]:
        """The given conditions, narrowed so that none of the patterns holds; none of them contains another."""
        found = list(ways)
        for pattern in sorted(dict.fromkeys(patterns), key=lambda p: (len(p), sorted(p))):
            split = [narrowed for way in found for narrowed in self._without(way, pattern)]
            found = _largest(split)
            if len(found) > tuning.MAX_CONDITIONS:
                found, self.whole = found[: tuning.MAX_CONDITIONS], False
        return found

    def _without(self, way: Allowed, pattern: Pattern) -> list[Allowed]:
        entries = [(self._number[i], self._value[i, number]) for i, number in sorted(pattern)]
        if any(n in way and value not in way[n] for n, value in entries):
            return [way]
        narrowed = []
        for n, value in entries:
            left = way.get(n, frozenset(range(self._sizes[n]))) - {value}
            if left:
                narrowed.append({**way, n: left})
        return narrowed


def _largest(ways: Sequence[Allowed]) -> list[Allowed]:
    """The conditions without those that another one contains; of equals the first."""
    kept: list[Allowed] = []
    for way in ways:
        if not any(_contains(other, way) for other in kept):
            kept = [other for other in kept if not _contains(way, other)]
            kept.append(way)
    return kept


def _contains(wide: Mapping[int, frozenset[int]], narrow: Mapping[int, frozenset[int]]) -> bool:
    return all(n in narrow and narrow[n] <= values for n, values in wide.items())
