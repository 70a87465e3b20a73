"""The delete relaxation of a finite-domain task without expanding its conditional effects.

Fact `offset[v] + x` says that variable v has value x. Auxiliary facts stand for "v has one of several values", "the
operator was applied", and "some operator with this conditional effect was applied". So each operator's cost is paid
once, and an effect that many operators share is written once.
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
    """The delete relaxation: operators whose owners are the task's operators (by index), and axioms."""

    offset: tuple[int, ...]
    facts: int  # the number of facts of variables; auxiliary facts follow
    all_facts: int  # with the auxiliary ones
    operators: tuple[RelaxedOperator, ...]
    goals: tuple[int, ...]  # a fact for each condition of the goal, in the order of `NormalTask.goal`

    def of(self, values: Sequence[int]) -> list[int]:
        """The facts that hold in a state, one for each variable."""
        return [at + x for at, x in zip(self.offset, values, strict=True)]

    @cached_property
    def prices(self) -> tuple[int, ...]:
        """The cost of each operator of the relaxation."""
        return tuple(o.cost for o in self.operators)


def relaxed_facts(task: NormalTask) -> RelaxedFacts:
    """The delete relaxation of a task."""
    return _RelaxationBuilder(task).build()


class _RelaxationBuilder:
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
        """The facts that enable the effects of a switch; a single one where several operators share the switch."""
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
        """The fact that some operator was applied that makes these assignments where variable v had value x."""
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
        """The fact that variable v has one of these values."""
        if len(values) == 1:
            return self.offset[v] + values[0]
        if (v, values) not in self._any:
            fact = self._any[v, values] = self.new()
            for x in values:
                self.axiom((self.offset[v] + x,), (fact,))
        return self._any[v, values]
