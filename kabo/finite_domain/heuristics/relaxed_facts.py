"""The delete relaxation of a finite-domain task, its conditional effects not expanded.

Fact `offset[v] + x` says that variable v has value x. Further facts stand between: that one of several values is there,
that an operator is done, and that something is done that has some effect if its condition holds. So each operator pays
once, and what many of them do alike is told once.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

from kabo.finite_domain.heuristics.relaxation import RelaxedOperator
from kabo.finite_domain.normal_form import Assignments, NormalTask, Tests


@dataclass(frozen=True)
class RelaxedFacts:
    """The relaxation; owners are indices of operators, and everything else is an axiom."""

    offset: tuple[int, ...]
    facts: int  # those of variables alone; the others follow
    all_facts: int
    operators: tuple[RelaxedOperator, ...]
    goals: tuple[int, ...]  # a fact for each condition of the goal, in the order of `NormalTask.goal`

    def of(self, values: Sequence[int]) -> list[int]:
        """The facts of a state."""
        return [at + x for at, x in zip(self.offset, values, strict=True)]

    @cached_property
    def prices(self) -> tuple[int, ...]:
        """What each operator costs."""
        return tuple(o.cost for o in self.operators)


def relaxed_facts(task: NormalTask) -> RelaxedFacts:
    """The relaxation of a task."""
    return _Builder(task).build()


class _Builder:
    def __init__(self, task: NormalTask) -> None:
        self.task = task
        *self.offset, self.facts = accumulate(task.sizes, initial=0)
        self.count, self.found = self.facts, list[RelaxedOperator]()
        self._users = Counter(s for o in task.operators if o is not None for s in o.switches)
        self._switches: dict[int, tuple[int, ...]] = {}
        self._effects: dict[tuple[int, int, Assignments], int] = {}
        self._any: dict[tuple[int, tuple[int, ...]], int] = {}

    def build(self) -> RelaxedFacts:
        for i, o in enumerate(self.task.operators):
            if o is None:
                continue
            adds = list(self.facts_of(o.always))
            for s in o.switches:
                adds += self.switch(s)
            if o.guarded:
                adds.append(self.new())
            for tests, assignments in o.guarded:
                self.axiom((adds[-1], *self.conditions(tests)), self.facts_of(assignments))
            self.found.append(RelaxedOperator(self.conditions(o.tests), tuple(adds), o.cost, i))
        goals = self.conditions(self.task.goal)
        return RelaxedFacts(tuple(self.offset), self.facts, self.count, tuple(self.found), goals)

    def switch(self, s: int) -> tuple[int, ...]:
        """The facts that the effects of a switch may count; one for all of them where operators share it."""
        if s not in self._switches:
            switch = self.task.switches[s]
            effects = tuple(self.effect(switch.variable, x, made) for x, made in switch.outcomes.items())
            if self._users[s] > 1:
                shared = self.new()
                self.axiom((shared,), effects)
                effects = (shared,)
            self._switches[s] = effects
        return self._switches[s]

    def effect(self, v: int, x: int, assignments: Assignments) -> int:
        """The fact that something is done that makes these assignments if variable v has value x."""
        key = (v, x, assignments)
        if key not in self._effects:
            self._effects[key] = self.new()
            self.axiom((self._effects[key], self.offset[v] + x), self.facts_of(assignments))
        return self._effects[key]

    def new(self) -> int:
        self.count += 1
        return self.count - 1

    def axiom(self, needed: tuple[int, ...], adds: Iterable[int]) -> None:
        self.found.append(RelaxedOperator(needed, tuple(adds), 0))

    def facts_of(self, assignments: Assignments) -> tuple[int, ...]:
        return tuple(self.offset[v] + x for v, x in assignments)

    def conditions(self, tests: Tests) -> tuple[int, ...]:
        return tuple(self.any(v, values) for v, values in tests.items())

    def any(self, v: int, values: tuple[int, ...]) -> int:
        """The fact that the variable has one of these values."""
        if len(values) == 1:
            return self.offset[v] + values[0]
        if (v, values) not in self._any:
            fact = self._any[v, values] = self.new()
            for x in values:
                self.axiom((self.offset[v] + x,), (fact,))
        return self._any[v, values]
