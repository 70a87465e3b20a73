"""The delete relaxation over abstract facts: a goal's estimated cost, and operators that seem to help [FF, HSP].

Facts are numbers whose meaning only the caller knows. Estimates are computed in plain Python at first, and by a
compiled kernel once this process has computed so many that loading the kernel pays; both give the same estimates.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import accumulate
from math import gcd
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo import tuning
from kabo.arrays import Integers
from kabo.finite_domain.heuristics.plain_relaxation import PlainTables, relaxed_plan

Facts = Sequence[int] | NDArray[Any] | int  # an int is a set of bits: bit i says that fact i is true
Engine = Literal["automatic", "python", "compiled"]
BUCKETS = 1024  # of the queue of facts, at most
UNREACHED_BELOW = 1 << 28  # h_add is cut off here: it only serves to compare supporters


class RelaxedOperator(NamedTuple):
    """An operator without deletes. Operators may share an owner; a plan pays only the dearest of each owner."""

    preconditions: tuple[int, ...]
    adds: tuple[int, ...]
    cost: int = 1  # >= 0; with cost 0 and owner -1 it is an axiom
    owner: int = -1  # a number of the caller's, >= 0; -1: none


class Estimate(NamedTuple):
    """The cost of a relaxed plan, the operators with which it begins, and the facts that it achieves."""

    value: int | None  # its cost; None: the goal is out of reach even relaxed
    preferred: tuple[int, ...]  # owners of its operators that are applicable now, if need be by axioms; sorted
    plan_facts: tuple[int, ...]  # the facts that it achieves and that do not hold yet, from the goal backwards


class KernelView(NamedTuple):
    """The kernel's arguments except the true facts [kabo.finite_domain.kernels.relaxed_plan]."""

    table: NDArray[np.int32]
    scratch: NDArray[np.int32]
    goal: NDArray[np.int32]
    out: NDArray[np.int32]


NOTHING = Estimate(None, (), ())


class RelaxedTask:
    """Operators over the facts 0 … facts − 1 and a goal, prepared for many estimates.

    The supporter of a fact is its cheapest achiever by h_add; among equally cheap achievers, the one found first.
    In this comparison an operator of cost 0 that has an owner counts as dearer than an axiom, but cheaper than an
    operator with a positive cost. Two threads must not share one object.
    """

    def __init__(
        self,
        facts: int,
        operators: Sequence[RelaxedOperator],
        goal: Iterable[int],
        *,
        engine: Engine = "automatic",
    ) -> None:
        """Raises ValueError for a fact out of range, a negative cost, or a cost above 2³¹ − 1."""
        self.facts, self.goal = facts, tuple(goal)
        self._core = _Core(facts, operators, engine)
        self._core.require(self.goal)

    def with_goal(self, goal: Iterable[int]) -> "RelaxedTask":
        """The same operators with another goal; both objects share the prepared tables."""
        other = object.__new__(RelaxedTask)
        other.facts, other.goal, other._core = self.facts, tuple(goal), self._core
        self._core.require(other.goal)
        return other

    def evaluate(self, true: Facts, goal: tuple[int, ...] | None = None) -> Estimate:
        """The estimate by a relaxed plan from the true facts to the goal.

        `true` lists the true facts, or is an int whose bit i says that fact i is true. `goal` replaces the goal of
        this object in this call.
        """
        return self._core.evaluate(true, self.goal if goal is None else goal)

    def for_kernels(self) -> "KernelView":
        """The arrays with which a kernel can call `relaxed_plan`; they are this object's own scratch memory."""
        return self._core.view(self.goal)

    def reachable(self, true: Facts) -> NDArray[np.bool_]:
        """(facts,) whether each fact can become true when nothing ever becomes false."""
        return self.layers(true) >= 0

    def layers(self, true: Facts) -> Integers:
        """(facts,) the layer in which each fact is first reached if all applicable operators are applied at once.

        A layer includes what axioms derive from its facts; −1 says that the fact is never reached.
        """
        return self._core.layers(list(_numbers(true)))


class _Core:
    """The tables for plain Python and for the kernel, and the choice between the two."""

    def __init__(self, facts: int, operators: Sequence[RelaxedOperator], engine: Engine) -> None:
        self.facts, self._engine = facts, engine
        self._names = sorted({o.owner for o in operators if o.owner >= 0})
        self._plain = _plain_tables(facts, operators, {name: i for i, name in enumerate(self._names)})
        self._visits = len(operators) + sum(len(o.preconditions) + len(o.adds) for o in operators)
        self._goals: dict[tuple[int, ...], NDArray[np.int32]] = {}
        self._table: NDArray[np.int32] | None = None
        self._switched = False
        self._words = np.empty(0, np.uint64)
        self._none = np.empty(0, np.int32)

    def require(self, goal: Sequence[int]) -> None:
        if any(not 0 <= f < self.facts for f in goal):
            raise ValueError(f"a goal names a fact beyond the {self.facts} there are: {sorted(goal)}")

    def evaluate(self, true: Facts, goal: tuple[int, ...]) -> Estimate:
        if not self._compiled():
            _spent.visits += self._visits
            value, owners, made = relaxed_plan(self._plain, _numbers(true), goal)
            return NOTHING if value is None else self._estimate(value, owners, made)
        return self._evaluate_compiled(true, goal)

    def _compiled(self) -> bool:
        """Whether to use the kernel: it is loaded already, or loading it would have paid by now."""
        if self._engine == "python":
            return False
        if self._switched:
            return True
        if (
            self._engine == "automatic"
            and _spent.visits < tuning.PLAIN_RELAXATION_VISITS
            and not _load.cache_info().currsize
        ):
            return False
        self._prepare()
        self._switched = True
        return True

    def _prepare(self) -> None:
        if self._table is not None:
            return
        tables = self._plain
        self._table = _array_table(self.facts, tables, len(self._names))
        size = 1 + 2 * tables.buckets + 8 * self.facts + 3 * len(tables.costs) + 2 * len(self._names)
        self._scratch = np.zeros(size, np.int32)
        self._scratch[1 : 1 + 2 * tables.buckets] = -1
        self._out = np.zeros(2 + len(self._names) + self.facts, np.int32)

    def view(self, goal: tuple[int, ...]) -> KernelView:
        self._prepare()
        assert self._table is not None
        return KernelView(self._table, self._scratch, np.array(goal, np.int32), self._out)

    def _evaluate_compiled(self, true: Facts, goal: tuple[int, ...]) -> Estimate:
        goals = self._goals.get(goal)
        if goals is None:
            self.require(goal)
            goals = self._goals[goal] = np.array(goal, np.int32)
        words, listed = self._words, self._none
        if isinstance(true, int):
            words = np.frombuffer(true.to_bytes((self.facts + 63) // 64 * 8, "little"), np.uint64)
        else:
            listed = np.asarray(true, np.int32)
        out = self._out
        value = _load()(self._table, self._scratch, words, listed, goals, out)
        if value < 0:
            return NOTHING
        owned, needed = out[:2].tolist()
        first = 2 + len(self._names)
        return self._estimate(value, out[2 : 2 + owned].tolist(), out[first : first + needed].tolist())

    def _estimate(self, value: int, owners: list[int], made: list[int]) -> Estimate:
        names = self._names
        return Estimate(value, tuple([names[w] for w in sorted(owners)]), tuple(made))

    def layers(self, true: list[int]) -> Integers:
        tables = self._plain
        found = np.full(self.facts, -1, np.int64)
        waiting = list(tables.waiting)
        found[true] = 0
        layer, now, ready = 0, sorted(set(true)), list(tables.free)
        while now or ready:
            later: list[int] = []
            while now or ready:  # axioms add to this layer, all others to the next
                for f in now:
                    for o in tables.uses[f]:
                        waiting[o] -= 1
                        if not waiting[o]:
                            ready.append(o)
                now = []
                for o in ready:
                    axiom = not tables.costs[o] and tables.owners[o] < 0
                    for f in tables.adds[o]:
                        if axiom and not 0 <= found[f] <= layer:
                            found[f] = layer
                            now.append(f)
                        elif not axiom and found[f] < 0:
                            found[f] = layer + 1
                            later.append(f)
                ready = []
            now = [f for f in later if found[f] == layer + 1]
            layer += 1
        return found


def _plain_tables(facts: int, operators: Sequence[RelaxedOperator], owners: dict[int, int]) -> PlainTables:
    preconditions = [sorted(set(o.preconditions)) for o in operators]
    adds = [sorted(set(o.adds).difference(o.preconditions)) for o in operators]
    uses: list[list[int]] = [[] for _ in range(facts)]
    for i, (needed, made) in enumerate(zip(preconditions, adds, strict=True)):
        if needed and not 0 <= needed[0] <= needed[-1] < facts or made and not 0 <= made[0] <= made[-1] < facts:
            raise ValueError(f"an operator names a fact beyond the {facts} there are: {operators[i]}")
        if not 0 <= operators[i].cost < 1 << 31:
            raise ValueError(f"the cost of an operator must be from 0 to 2^31 - 1: {operators[i]}")
        for f in needed:
            uses[f].append(i)
    prices = _prices(operators)
    most, dearest = max(map(len, preconditions), default=0), max(prices, default=0)
    return PlainTables(
        preconditions=preconditions,
        adds=adds,
        uses=uses,
        waiting=[len(needed) for needed in preconditions],
        prices=prices,
        costs=[o.cost for o in operators],
        owners=[owners.get(o.owner, -1) for o in operators],
        free=[i for i, needed in enumerate(preconditions) if not needed],
        limit=min(UNREACHED_BELOW, ((1 << 31) - 1 - dearest) // max(most, 1)),  # so that sums stay below 2^31
        unit=max(1, min((p for p in prices if p), default=1)),
        buckets=BUCKETS,
    )


def _prices(operators: Sequence[RelaxedOperator]) -> list[int]:
    """Costs in multiples of their greatest common divisor; an operator of cost 0 with an owner costs a quarter of it."""
    unit = gcd(*{o.cost for o in operators}) or 1
    scale = 4 if any(not o.cost and o.owner >= 0 for o in operators) else 1
    prices = [scale * (o.cost // unit) or int(o.owner >= 0) for o in operators]
    shift = max(0, max(prices, default=0).bit_length() - 26)
    return [max(1, p >> shift) if p else 0 for p in prices]


def _array_table(facts: int, tables: PlainTables, owners: int) -> NDArray[np.int32]:
    """The tables as one array for the kernel, which begins with the index of each."""
    lists: list[list[int]] = []
    for nested in (tables.preconditions, tables.adds, tables.uses):
        flat = [i for row in nested for i in row]
        lists += [[0, *accumulate(map(len, nested))], flat]
    fresh = [x for o, price in enumerate(tables.prices) for x in (len(tables.preconditions[o]), price)]
    lists += [fresh, tables.costs, tables.owners, tables.free]
    head = [facts, len(tables.costs), tables.buckets, tables.unit, tables.limit, len(tables.free), owners, 0]
    starts = list(accumulate(map(len, lists), initial=len(head) + len(lists) + 2))
    # Starts of rows count from the start of their flat list, whose index the kernel adds.
    return np.array([*head, *starts, 0, *(i for row in lists for i in row)], np.int32)


def _numbers(true: Facts) -> list[int]:
    if isinstance(true, np.ndarray):
        return true.tolist()  # type: ignore[no-any-return]
    if not isinstance(true, int):
        return list(true)
    numbers = []
    while true:
        lowest = true & -true
        numbers.append(lowest.bit_length() - 1)
        true ^= lowest
    return numbers


@dataclass
class _Spent:
    """The work that plain Python has done in this process, over all tasks."""

    visits: int = 0


_spent = _Spent()


@cache
def _load() -> Any:
    from kabo.finite_domain.kernels.relaxed_plan import relaxed_plan as compiled  # numba: only once it pays

    return compiled
