"""The tables of LM-cut: the delete relaxation, and a fact "holds at the end" for each goal.

The bound takes some deletes into account. Suppose that a goal holds now and that every plan must still achieve
some fact. If the goal is false whenever that fact is achieved, then the goal has to be achieved again. Pairs of
facts that are never true together prove this [kabo.finite_domain.mutexes], so the bound stays a lower bound.
Likewise, a goal that is false whenever another goal is achieved must be achieved after that other goal. So the
bound also counts goals that hold at the start and have to be given up on the way.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from kabo.finite_domain.heuristics.relaxation import RelaxedOperator
from kabo.finite_domain.heuristics.relaxed_facts import RelaxedFacts
from kabo.finite_domain.mutexes import Condition, FactTask, Mutexes
from kabo.finite_domain.normal_form import NormalTask
from kabo.finite_domain.packing import Packing

HEAD = 21  # numbers before the tables, as in the kernel


def landmark_tables(
    task: NormalTask,
    packing: Packing,
    relaxed: RelaxedFacts,
    facts_of_task: FactTask,
    *,
    goals: Sequence[Condition],
    mutexes: Mutexes,
) -> tuple[NDArray[np.int32], tuple[RelaxedOperator, ...]]:
    """The tables of LM-cut as one array for the kernel, and the relaxed operators in the kernel's order.

    Args:
        task: the task with its effects sorted by kind.
        packing: the packing of the task's states.
        relaxed: the delete relaxation of the task.
        facts_of_task: the task's operators as conditions and effects over facts.
        goals: for each condition of the goal the facts that fulfil it.
        mutexes: the pairs of facts that are never true together from the search's start on.
    """
    ends = relaxed.all_facts
    facts = ends + len(goals) + 1
    consequences = _consequences(facts_of_task, mutexes, goals, ends, facts)
    before = [
        frozenset(k for k in range(len(goals)) if k != j and ends + j in consequences[ends + k])
        for j in range(len(goals))
    ]
    can_make = _can_make(task, facts_of_task)
    operators = tuple(copy for o in relaxed.operators for copy in _with_ends(o, goals, ends, before, can_make))
    operators += (RelaxedOperator(tuple(range(ends, facts - 1)), (facts - 1,), 0),)
    flat = _Flat(operators, facts)

    def place(v: int) -> tuple[int, int, int]:
        return packing.word[v], packing.shift[v], packing.mask[v]

    flat.tables.append(flat.put(n for v, at in enumerate(relaxed.offset) for n in (*place(v), at)))
    tests = [
        (*place(v), flat.put(int(x in values) for x in range(task.sizes[v]))) for v, values in task.goal.items()
    ]
    flat.tables.append(flat.put(n for test in tests for n in test))
    flat.tables += flat.rows(consequences)
    return flat.finished(len(task.sizes), len(goals), ends), operators


def relaxation_tables(operators: Sequence[RelaxedOperator], facts: int) -> NDArray[np.int32]:
    """The tables of a delete relaxation that comes from no task; the caller gives the true facts each time.

    The last fact is the goal; the last operator achieves it.
    """
    return _Flat(operators, facts).finished(0, 0, facts - 1)


class _Flat:
    """One array of several tables, which begins with their sizes and the index of each."""

    def __init__(self, operators: Sequence[RelaxedOperator], facts: int) -> None:
        self.numbers = [0] * HEAD
        needs = [sorted(set(o.preconditions)) for o in operators]
        adds = [sorted(set(o.adds).difference(o.preconditions)) for o in operators]
        free = [i for i, needed in enumerate(needs) if not needed]
        self.tables = [*self.rows(needs), *self.rows(adds)]
        self.tables += [*self.rows(_users(needs, facts)), *self.rows(_users(adds, facts)), self.put(free)]
        self._sizes = facts, len(operators), len(free)

    def put(self, row: Iterable[int]) -> int:
        """Appends a table and returns the index at which it begins."""
        at = len(self.numbers)
        self.numbers.extend(row)
        return at

    def rows(self, rows: Sequence[Sequence[int]]) -> list[int]:
        """Appends the start of each row, and then the rows; returns the index of both."""
        return [self.put(accumulate(map(len, rows), initial=0)), self.put(n for row in rows for n in row)]

    def finished(self, variables: int, goals: int, ends: int) -> NDArray[np.int32]:
        """All tables as one array [kabo.finite_domain.kernels.landmark_cut]."""
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
    """The operator, and a copy that also achieves "holds at the end" of its goals once the goals before these do.

    Two operators are needed, since one application is either the last one for a goal or not. Goal A is before goal B
    if B is false whenever A is achieved: then A is achieved for the last time before B is, or by the same operator.
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


def _can_make(task: NormalTask, facts: FactTask) -> dict[int, frozenset[int]]:
    """For each operator the facts that it may achieve, under whatever condition."""
    made = {}
    can_be_done = (i for i, o in enumerate(task.operators) if o is not None)
    for i, o in zip(can_be_done, facts.operators, strict=True):
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
    """For each fact, and for each goal to be achieved, what must hold or be achieved whichever way it is achieved."""
    ways = _ways(task, mutexes)
    found: list[list[int]] = [[] for _ in range(facts)]
    for f in range(task.facts):
        found[f] = _common(ways[f], goals, ends)
    for k, goal in enumerate(goals):
        found[ends + k] = _common([way for f in goal for way in ways[f]], goals, ends)
    return found


# A way to achieve a fact: the facts that it needs, and the bits of those facts that are false just before.
Way = tuple[frozenset[int], int]


def _ways(task: FactTask, mutexes: Mutexes) -> list[list[Way]]:
    """For each fact the ways to achieve it that are possible at all."""
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
    """The facts that all ways need, and the goals that are false before each of them."""
    if not ways:
        return []
    needed, never = ways[0]
    for more, other in ways[1:]:
        needed, never = needed & more, never & other
    return sorted(needed) + [ends + k for k, goal in enumerate(goals) if all(never >> f & 1 for f in goal)]
