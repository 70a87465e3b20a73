"""Pairs of facts that are never true together: h², forward, with conditional effects [Haslum, Geffner 2000].

An impossible pair may be taken for possible, never the reverse, since a fact that a conditional effect may change
is also kept as possible. The pairs found impossible are an invariant: they stay impossible from every start in
which none of them is true.
"""

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kabo import tuning
from kabo.finite_domain.normal_form import Assignments, NormalOperator, NormalTask, Tests

Condition = tuple[int, ...]  # facts of one variable of which one must hold


# Conditions, and the facts that are achieved under them.
Group = tuple[tuple[tuple[Condition, ...], tuple[int, ...]], ...]


@dataclass(frozen=True)
class FactOperator:
    """An operator over facts; at most one conditional effect of each of its groups happens."""

    needs: tuple[Condition, ...]
    always: tuple[int, ...]
    depends: tuple["Group", ...]


@dataclass(frozen=True)
class FactTask:
    """A task over numbered facts: fact `offset[v] + x` says that variable v has value x."""

    facts: int
    offset: tuple[int, ...]
    sizes: tuple[int, ...]
    operators: tuple[FactOperator, ...]

    @cached_property
    def variable(self) -> tuple[int, ...]:
        """The variable of each fact."""
        return tuple(v for v, n in enumerate(self.sizes) for _ in range(n))

    @cached_property
    def siblings(self) -> tuple[int, ...]:
        """For each variable the mask of its facts."""
        return tuple(((1 << n) - 1) << at for at, n in zip(self.offset, self.sizes, strict=True))


def fact_task(task: NormalTask, offset: tuple[int, ...]) -> FactTask:
    """The task over facts, without the operators that are never applicable."""

    def needs(tests: Tests) -> tuple[Condition, ...]:
        return tuple(tuple(offset[v] + x for x in values) for v, values in sorted(tests.items()))

    def facts(assignments: Assignments) -> tuple[int, ...]:
        return tuple(sorted(offset[v] + x for v, x in assignments))

    switched = [
        tuple((((offset[s.variable] + x,),), facts(set_to)) for x, set_to in s.outcomes.items())
        for s in task.switches
    ]

    def operator(o: NormalOperator) -> FactOperator:
        guarded = tuple((needs(tests), facts(set_to)) for tests, set_to in o.guarded)
        depends = tuple(switched[s] for s in o.switches) + tuple((g,) for g in guarded)
        return FactOperator(needs(o.tests), facts(o.always), depends)

    operators = tuple(operator(o) for o in task.operators if o is not None)
    return FactTask(sum(task.sizes), offset, task.sizes, operators)


@dataclass(frozen=True)
class Mutexes:
    """The pairs of facts that may be true together: bit g of `together[f]` says that facts f and g may be.

    Bit f of `together[f]` says that fact f may be true at all.
    """

    together: tuple[int, ...]

    def exclude(self, first: int, second: int) -> bool:
        """Whether the two facts are never true together."""
        return not self.together[first] >> second & 1

    def allow(self, state: Sequence[int]) -> bool:
        """Whether no two facts of the state are mutex; only then are the mutexes valid from this state on."""
        bits = sum(1 << f for f in state)
        return all(bits & ~self.together[f] == 0 for f in state)

    def never_with(self, conditions: Iterable[Condition]) -> int:
        """The bits of the facts that are false whenever all these conditions hold."""
        everything, found = (1 << len(self.together)) - 1, 0
        for facts in conditions:
            possible = 0
            for f in facts:
                possible |= self.together[f]
            found |= everything & ~possible
        return found


def variables_alone(task: FactTask) -> Mutexes:
    """The mutexes that need no computation: two values of one variable are never true together."""
    everything = (1 << task.facts) - 1
    return Mutexes(tuple(everything & ~task.siblings[v] | 1 << f for f, v in enumerate(task.variable)))


class _Pairs:
    """The pairs found possible so far, and the time when the row of each fact grew last."""

    def __init__(self, task: FactTask, start: Sequence[int]) -> None:
        self.rows, self.grown, self.time = [0] * task.facts, [0] * task.facts, 1
        self.task = task
        self.reached, self.reached_at = sum(1 << f for f in start), 1
        for f in start:
            self.rows[f], self.grown[f] = self.reached, 1

    def with_all(self, conditions: tuple[Condition, ...], known: int) -> int:
        """The bits of those known facts that may be true together with all conditions; 0 if these cannot all hold."""
        for facts in conditions:
            possible = 0
            for f in facts:
                possible |= self.rows[f]
            known &= possible
        return known if all(any(known >> f & 1 for f in facts) for facts in conditions) else 0

    def stamp(self, conditions: tuple[Condition, ...]) -> int:
        """The time when the rows of these conditions' facts grew last."""
        return max((self.grown[f] for facts in conditions for f in facts), default=self.reached_at)

    def note_together(self, made: tuple[int, ...], after: int) -> None:
        """Notes that each fact of `made` may be true together with all facts of `after`."""
        for f in made:
            new = after & ~self.rows[f]
            if new:
                self.time += 1
                self.rows[f] |= new
                self.grown[f] = self.time
                if new >> f & 1:
                    self.reached, self.reached_at = self.reached | 1 << f, self.time
            while new:
                lowest = new & -new
                g = lowest.bit_length() - 1
                self.rows[g] |= 1 << f
                self.grown[g] = self.time
                new ^= lowest

    def after(self, kept: int, made: tuple[int, ...]) -> int:
        """The facts that may hold after the variables of `made` are set, of those that may hold before."""
        put = 0
        for f in made:
            kept &= ~self.task.siblings[self.task.variable[f]]
            put |= 1 << f
        return kept | put


def plain_mutexes(task: FactTask, start: Sequence[int]) -> Mutexes:
    """The mutexes of all states reachable from a start, which is given by its facts; computed in plain Python."""
    pairs, seen, before = _Pairs(task, start), [0] * len(task.operators), 0
    while before != pairs.time:
        before = pairs.time
        for i, o in enumerate(task.operators):
            inside = (pairs.stamp(c) for group in o.depends for c, _ in group)
            if seen[i] < max(pairs.stamp(o.needs), *inside, 0):
                seen[i] = pairs.time
                _do(pairs, o)
    return Mutexes(tuple(pairs.rows))


def _do(pairs: _Pairs, o: FactOperator) -> None:
    possible = pairs.with_all(o.needs, pairs.reached)
    if not possible:
        return
    pairs.note_together(o.always, pairs.after(possible, o.always) | _made(pairs, o, possible, None))
    for group in o.depends:
        for conditions, made in group:
            kept = pairs.with_all(conditions, possible)
            if kept and pairs.with_all(o.needs, kept):
                set_to = o.always + made
                pairs.note_together(made, pairs.after(kept, set_to) | _made(pairs, o, kept, group))


def _made(pairs: _Pairs, o: FactOperator, known: int, but: Group | None) -> int:
    """The facts that all groups but `but` may achieve when only the known facts are possible."""
    found = 0
    for group in o.depends:
        for conditions, made in group if group is not but else ():
            if all(any(known >> f & 1 for f in facts) for facts in conditions):
                for f in made:
                    found |= 1 << f
    return found


def mutexes(task: FactTask, start: Sequence[int]) -> Mutexes:
    """The mutexes of all states reachable from a start, which is given by its facts.

    They are computed in plain Python if that is quick, else by compiled code. For tasks so large that checking all
    pairs would take too long, only pairs of two values of one variable are returned.
    """
    groups = {id(group): len(group) for o in task.operators for group in o.depends}
    variants = len(task.operators) + sum(groups[id(group)] for o in task.operators for group in o.depends)
    if variants <= tuning.PLAIN_MUTEX_VARIANTS:
        return plain_mutexes(task, start)
    if task.facts > tuning.MAX_MUTEX_FACTS or variants * task.facts > tuning.MAX_MUTEX_WORK:
        return variables_alone(task)
    return compiled_mutexes(task, start)


def compiled_mutexes(task: FactTask, start: Sequence[int]) -> Mutexes:
    """The same mutexes as `plain_mutexes` finds, computed by the compiled kernel."""
    from kabo.finite_domain.kernels.pairs import grow  # numba: only for tasks that plain Python is too slow for

    words = (task.facts + 63) // 64
    rows, grown = np.zeros((task.facts, words), np.uint64), np.zeros(task.facts + 1, np.int64)
    bits = np.frombuffer(sum(1 << f for f in start).to_bytes(8 * words, "little"), np.uint64)
    for f in start:
        rows[f], grown[f] = bits, 1
    grown[task.facts] = 1
    scratch = np.zeros((4, words), np.uint64)
    scratch[0] = bits
    grow(_numbers(task), rows, grown, np.zeros(len(task.operators), np.int64), scratch, 1)
    return Mutexes(tuple(int.from_bytes(row.tobytes(), "little") for row in rows))


def _numbers(task: FactTask) -> NDArray[np.int32]:
    """A fact task as one array for the kernel, in which every part is named by the index at which it begins."""
    flat = [task.facts, len(task.sizes), 0, 0, len(task.operators), 0]
    known: dict[Hashable, int] = {}
    effects: dict[int, tuple[int, int]] = {}

    def put(key: Hashable, row: list[int]) -> int:
        if key not in known:
            known[key] = len(flat)
            flat.extend(row)
        return known[key]

    def facts(facts: tuple[int, ...]) -> int:
        return put((0, facts), [len(facts), *facts])

    def conditions(conditions: tuple[Condition, ...]) -> int:
        return put((1, conditions), [len(conditions), *(n for c in conditions for n in (len(c), *c))])

    def effect(effect: tuple[tuple[Condition, ...], tuple[int, ...]]) -> tuple[int, int]:
        if id(effect) not in effects:
            effects[id(effect)] = conditions(effect[0]), facts(effect[1])
        return effects[id(effect)]

    def group(group: Group) -> int:
        if id(group) not in known:
            put(id(group), [len(group), *(n for e in group for n in effect(e))])
        return known[id(group)]

    flat[2] = put("offsets", [*task.offset, task.facts])
    flat[3] = put("variable", list(task.variable))
    records = []
    for i, o in enumerate(task.operators):
        alone = put((2, o.always), [1, conditions(()), facts(o.always)])
        groups = [alone, *(group(g) for g in o.depends)]
        records.append(put((3, i), [conditions(o.needs), facts(o.always), len(groups), *groups]))
    flat[5] = put("operators", records)
    return np.array(flat, np.int32)
