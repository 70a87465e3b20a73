"""A task prepared once for many searches: packed states, tables, and what searches derive from it on demand."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kabo.finite_domain.agenda import Agenda, agenda
from kabo.finite_domain.array_tables import array_tables
from kabo.finite_domain.heuristics.relaxation import RelaxedTask
from kabo.finite_domain.heuristics.relaxed_facts import RelaxedFacts, relaxed_facts
from kabo.finite_domain.mutexes import FactTask, Mutexes, fact_task, mutexes
from kabo.finite_domain.normal_form import NormalTask, normal_form
from kabo.finite_domain.packing import Packing, pack
from kabo.finite_domain.plain_states import PlainStates
from kabo.finite_domain.tables import Tables, build_tables
from kabo.finite_domain.task import FiniteTask

Never = NDArray[np.uint64]  # (words,) bit o mod 64 of word o div 64 is set if operator o must not be used


def as_number(never: Never) -> int:
    """The bits of the array `never` as one Python int."""
    return int.from_bytes(never.tobytes(), "little")


@dataclass(frozen=True)
class ChangingFacts:
    """The facts of those variables that some operator may change, numbered from 0 on."""

    offset: tuple[int, ...]  # for each variable the number of its first fact; -1: it never changes
    facts: int  # how many there are


class CompiledTask:
    """A task with the tables that searches need; no table depends on a search's start or forbidden operators.

    It also counts the work that searches have done in plain Python, since from some amount on compiled searches
    are quicker.
    """

    def __init__(self, task: FiniteTask) -> None:
        self.task = task
        self._plain_spent: dict[str, int] = {}

    def plain_left(self, search: str, most: int) -> int:
        """The work that this search may still do in plain Python: `most` less the work of its earlier runs."""
        return max(0, most - self._plain_spent.get(search, 0))

    def spend(self, search: str, work: int) -> None:
        """Adds to the count of the work that the search of this name has done in plain Python."""
        self._plain_spent[search] = self._plain_spent.get(search, 0) + work

    @cached_property
    def normal(self) -> NormalTask:
        """The task with its effects sorted by kind."""
        return normal_form(self.task)

    @cached_property
    def packing(self) -> Packing:
        """The bits of a packed state that hold each variable."""
        return pack(self.normal.sizes)

    @cached_property
    def tables(self) -> Tables:
        """The tables of applicability and effects, as lists."""
        return build_tables(self.normal, self.packing)

    @cached_property
    def plain(self) -> PlainStates:
        """Applicable operators and successors, computed in plain Python."""
        return PlainStates(self.tables)

    @cached_property
    def arrays(self) -> tuple[NDArray[np.int32], NDArray[np.uint64]]:
        """The tables of applicability and effects, as arrays for kernels."""
        return array_tables(self.tables, self.packing)

    @cached_property
    def relaxed(self) -> RelaxedFacts:
        """The delete relaxation, as operators over facts."""
        return relaxed_facts(self.normal)

    @cached_property
    def relaxation(self) -> RelaxedTask:
        """The delete relaxation, prepared for computing relaxed plans."""
        return RelaxedTask(self.relaxed.all_facts, self.relaxed.operators, self.relaxed.goals)

    @cached_property
    def fact_task(self) -> FactTask:
        """The operators as conditions and effects over numbered facts."""
        return fact_task(self.normal, self.relaxed.offset)

    @cached_property
    def goal_facts(self) -> tuple[tuple[int, ...], ...]:
        """For each condition of the goal the facts that fulfil it."""
        return tuple(tuple(self.relaxed.offset[v] + x for x in values) for v, values in self.normal.goal.items())

    @cached_property
    def changing(self) -> ChangingFacts:
        """The facts of the variables that some operator may change."""
        made = {f for o in self.fact_task.operators for f in o.always}
        made.update(
            f for o in self.fact_task.operators for group in o.depends for _, facts in group for f in facts
        )
        changed = {self.fact_task.variable[f] for f in made}
        offset, count = [], 0
        for v, size in enumerate(self.normal.sizes):
            offset.append(count if v in changed else -1)
            count += size if v in changed else 0
        return ChangingFacts(tuple(offset), count)

    @cached_property
    def mutexes(self) -> Mutexes:
        """The pairs of facts that are never true together in states reachable from the task's initial values."""
        return mutexes(self.fact_task, self.relaxed.of(self.task.initial))

    @cached_property
    def agenda(self) -> Agenda:
        """The reasonable orders of the goal's conditions."""
        return agenda(self.fact_task, self.mutexes, self.goal_facts)

    def start(self, values: Sequence[int] | None) -> int:
        """The packed state in which the variables have these values; None stands for the task's initial values.

        Raises:
            ValueError: `values` does not give every variable one value of its range.
        """
        values = self.task.initial if values is None else values
        sizes = self.normal.sizes
        if len(values) != len(sizes) or any(not 0 <= x < n for x, n in zip(values, sizes, strict=True)):
            raise ValueError(f"a start needs a value for each of the {len(sizes)} variables, not {values}")
        return self.packing.number(values)

    def never(self, forbidden: Sequence[int] | NDArray[Any] | None) -> Never:
        """(words,) an array with a bit set for each operator that is never applicable or is forbidden.

        `forbidden` (operators,) is not 0 for each operator that must not be used; None forbids no operator.
        """
        never = np.array(self.tables.gates.never, np.uint64)
        if forbidden is None:
            return never
        operators = len(self.task.operators)
        array = np.zeros(64 * len(never), np.uint8)
        if np.shape(forbidden) != (operators,):
            raise ValueError(f"`forbidden` needs one entry for each of the {operators} operators")
        array[:operators] = np.asarray(forbidden) != 0
        return never | np.packbits(array, bitorder="little").view(np.uint64)

    def cost(self, plan: Sequence[int]) -> int:
        """The sum of the costs of the plan's operators."""
        return sum(self.task.operators[o].cost for o in plan)


@dataclass
class SearchBudget:
    """The limits of a search: expansions, bytes of memory, and a repeatedly called function that may stop it."""

    expansions: int | None = None  # None: without limit
    memory: int = 4 << 30  # bytes
    stop: Callable[[], bool] | None = None
    told: Callable[[int], None] | None = None  # called with the number of expansions so far, often

    def stopped(self) -> bool:
        """Whether the caller's `stop` asks the search to end."""
        return self.stop is not None and self.stop()

    def left(self, expanded: int, most: int) -> int:
        """The number of states to expand before the next check, at most `most`; 0 if the budget is spent."""
        if self.told is not None:
            self.told(expanded)
        return most if self.expansions is None else max(0, min(most, self.expansions - expanded))
