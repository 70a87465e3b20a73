"""The tables of LM-cut: the relaxation, and for each goal that it holds at the end.

Deletes come in by one observation. If a goal that holds is false whenever something is done that makes what is needed
on every way to the goal, then it has to be made again. That is told by pairs of facts that are never true together
[kabo.finite_domain.mutexes], so it stays a lower bound. And if it is false whenever another
goal is made, it is made after that one. This sees through goals that hold at the start and all have to be given up.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from kabo.finite_domain.compiled_task import CompiledTask
from kabo.finite_domain.heuristics.relaxation import RelaxedOperator
from kabo.finite_domain.mutexes import Condition, FactTask, Mutexes

HEAD = 21  # numbers before the tables


def landmark_tables(
    compiled: CompiledTask, mutexes: Mutexes
) -> tuple[NDArray[np.int32], tuple[RelaxedOperator, ...]]:
    """The tables as the kernel reads them, and the operators whose costs it wants. `mutexes` hold from the start on."""
    relaxed, goals = compiled.relaxed, compiled.goal_facts
    ends = relaxed.all_facts
    facts = ends + len(goals) + 1
    consequences = _consequences(compiled.fact_task, mutexes, goals, ends, facts)
    before = [
        frozenset(k for k in range(len(goals)) if k != j and ends + j in consequences[ends + k])
        for j in range(len(goals))
    ]
    can_make = _can_make(compiled)
    operators = tuple(copy for o in relaxed.operators for copy in _with_ends(o, goals, ends, before, can_make))
    operators += (RelaxedOperator(tuple(range(ends, facts - 1)), (facts - 1,), 0),)
    flat = _Flat(operators, facts)
    packing, sizes = compiled.packing, compiled.normal.sizes

    def place(v: int) -> tuple[int, int, int]:
        return packing.word[v], packing.shift[v], packing.mask[v]

    flat.tables.append(flat.put(n for v, at in enumerate(relaxed.offset) for n in (*place(v), at)))
    tests = [
        (*place(v), flat.put(int(x in values) for x in range(sizes[v])))
        for v, values in compiled.normal.goal.items()
    ]
    flat.tables.append(flat.put(n for test in tests for n in test))
    flat.tables += flat.rows(consequences)
    return flat.finished(len(sizes), len(goals), ends), operators


def relaxation_tables(operators: Sequence[RelaxedOperator], facts: int) -> NDArray[np.int32]:
    """The tables of a relaxation alone, for which whoever asks says what holds.

    The last fact is the goal, and the last operator asks that all of it holds.
    """
    return _Flat(operators, facts).finished(0, 0, facts - 1)


class _Flat:
    """Tables one after the other, behind a head that says how large all is and where each begins."""

    def __init__(self, operators: Sequence[RelaxedOperator], facts: int) -> None:
        self.numbers = [0] * HEAD
        needs = [sorted(set(o.preconditions)) for o in operators]
        adds = [sorted(set(o.adds).difference(o.preconditions)) for o in operators]
        free = [i for i, needed in enumerate(needs) if not needed]
        self.tables = [*self.rows(needs), *self.rows(adds)]
        self.tables += [*self.rows(_users(needs, facts)), *self.rows(_users(adds, facts)), self.put(free)]
        self._sizes = facts, len(operators), len(free)

    def put(self, row: Iterable[int]) -> int:
        """Appends a table; returns where it begins."""
        at = len(self.numbers)
        self.numbers.extend(row)
        return at

    def rows(self, rows: Sequence[Sequence[int]]) -> list[int]:
        """Appends where each row begins, and all rows."""
        return [self.put(accumulate(map(len, rows), initial=0)), self.put(n for row in rows for n in row)]

    def finished(self, variables: int, goals: int, ends: int) -> NDArray[np.int32]:
        """Everything as one array [kabo.finite_domain.kernels.landmark_cut]."""
        facts, operators, free = self._sizes
        self.numbers[:8] = [facts, operators, facts - 1, variables, goals, ends, free, 0]
        self.numbers[8 : 8 + len(self.tables)] = self.tables
        return np.array(self.numbers, np.int32)


def _with_ends(
    o: RelaxedOperator,
    goals: Sequence[Condition],
    ends: int,
    before: Sequence[frozenset[int]],
    can_make: Mapping[int, frozenset[int]],
) -> list[RelaxedOperator]:
    """What makes facts of goals also makes that they hold at the end, once the goals that come before do.

    Doing it earlier is another operator, since one and the same doing cannot be both. A goal comes before if this one is
    false whenever that one is made: then it is made for the last time no later, at the latest by the same doing.
    """
    made = [k for k, facts in enumerate(goals) if any(f in o.adds for f in facts)]
    if not made:
        return [o]
    final = o.adds + tuple(ends + k for k in made)
    first = frozenset.intersection(*(before[k] for k in made)) if o.owner >= 0 else frozenset()
    if first:
        first = first.difference(k for k, facts in enumerate(goals) if not can_make[o.owner].isdisjoint(facts))
    if not first:
        return [RelaxedOperator(o.preconditions, final, o.cost, o.owner)]
    return [o, RelaxedOperator(o.preconditions + tuple(ends + k for k in sorted(first)), final, o.cost, o.owner)]


def _can_make(compiled: CompiledTask) -> dict[int, frozenset[int]]:
    """Of each operator the facts that it makes, on whatever condition."""
    made = {}
    can_be_done = (i for i, o in enumerate(compiled.normal.operators) if o is not None)
    for i, o in zip(can_be_done, compiled.fact_task.operators, strict=True):
        made[i] = frozenset(o.always).union(*(facts for group in o.depends for _, facts in group))
    return made


def _users(rows: Sequence[Sequence[int]], facts: int) -> list[list[int]]:
    users: list[list[int]] = [[] for _ in range(facts)]
    for i, row in enumerate(rows):
        for f in row:
            users[f].append(i)
    return users


def _consequences(
    task: FactTask, mutexes: Mutexes, goals: Sequence[Condition], ends: int, facts: int
) -> list[list[int]]:
    """Of each fact, and of each goal that has to be made, what else has to be made or held on every way to it."""
    ways = _ways(task, mutexes)
    found: list[list[int]] = [[] for _ in range(facts)]
    for f in range(task.facts):
        found[f] = _common(ways[f], goals, ends)
    for k, goal in enumerate(goals):
        found[ends + k] = _common([way for f in goal for way in ways[f]], goals, ends)
    return found


Way = tuple[
    frozenset[int], int
]  # facts that it needs, and the bits of facts that are false just before it is gone


def _ways(task: FactTask, mutexes: Mutexes) -> list[list[Way]]:
    """Of each fact the ways to make it that are open at all."""
    ways: list[list[Way]] = [[] for _ in range(task.facts)]
    for o in task.operators:
        never = mutexes.never_with(o.needs)
        needed = frozenset(c[0] for c in o.needs if len(c) == 1)
        if not _open(o.needs, never):
            continue
        for f in o.always:
            ways[f].append((needed, never))
        for group in o.depends:
            for conditions, made in group:
                both = never | mutexes.never_with(conditions)
                if _open((*o.needs, *conditions), both):
                    way = needed.union(c[0] for c in conditions if len(c) == 1), both
                    for f in made:
                        ways[f].append(way)
    return ways


def _open(conditions: Sequence[Condition], never: int) -> bool:
    return all(any(not never >> f & 1 for f in facts) for facts in conditions)


def _common(ways: Sequence[Way], goals: Sequence[Condition], ends: int) -> list[int]:
    """What all ways need, and the goals that are false before all of them."""
    if not ways:
        return []
    needed, never = ways[0]
    for more, other in ways[1:]:
        needed, never = needed & more, never & other
    return sorted(needed) + [ends + k for k, goal in enumerate(goals) if all(never >> f & 1 for f in goal)]
