"""A task prepared once for many searches: packed, as tables, with what searches derive from it when they need it."""

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

Never = NDArray[np.uint64]  # (groups of 64 operators,) a bit for each that must not be used


def as_number(never: Never) -> int:
    """The same bits as one Python int."""
    return int.from_bytes(never.tobytes(), "little")


@dataclass(frozen=True)
class ChangingFacts:
    """Facts of the variables that some operator may change, numbered on their own."""

    offset: tuple[int, ...]  # of each variable where its facts begin; -1: it never changes
    facts: int


class CompiledTask:
    """A task, packed. What is cached here depends on the task alone, not on starts or forbidden operators.

    It also counts what searches did in plain Python, since after a while the compiled twins are the quicker way.
    """

    def __init__(self, task: FiniteTask) -> None:
        self.task = task
        self._plain_spent: dict[str, int] = {}

    def plain_left(self, search: str, most: int) -> int:
        """How much of its work a search may still do in plain Python, over all searches of this task."""
        return max(0, most - self._plain_spent.get(search, 0))

    def spend(self, search: str, work: int) -> None:
        """Takes note of work done in plain Python."""
        self._plain_spent[search] = self._plain_spent.get(search, 0) + work

    @cached_property
    def normal(self) -> NormalTask:
        """The operators with their effects sorted."""
        return normal_form(self.task)

    @cached_property
    def packing(self) -> Packing:
        """Where variables lie in states."""
        return pack(self.normal.sizes)

    @cached_property
    def tables(self) -> Tables:
        """Successors as lists."""
        return build_tables(self.normal, self.packing)

    @cached_property
    def plain(self) -> PlainStates:
        """Successors in plain Python."""
        return PlainStates(self.tables)

    @cached_property
    def arrays(self) -> tuple[NDArray[np.int32], NDArray[np.uint64]]:
        """Successors for kernels."""
        return array_tables(self.tables, self.packing)

    @cached_property
    def relaxed(self) -> RelaxedFacts:
        """The delete relaxation, as operators over facts."""
        return relaxed_facts(self.normal)

    @cached_property
    def relaxation(self) -> RelaxedTask:
        """The delete relaxation, ready to be asked."""
        return RelaxedTask(self.relaxed.all_facts, self.relaxed.operators, self.relaxed.goals)

    @cached_property
    def fact_task(self) -> FactTask:
        """The operators over facts."""
        return fact_task(self.normal, self.relaxed.offset)

    @cached_property
    def goal_facts(self) -> tuple[tuple[int, ...], ...]:
        """Of each condition of the goal the facts one of which must hold."""
        return tuple(tuple(self.relaxed.offset[v] + x for x in values) for v, values in self.normal.goal.items())

    @cached_property
    def changing(self) -> ChangingFacts:
        """The facts by which states can differ."""
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
        """Facts that are never true together, from the task's initial values on."""
        return mutexes(self.fact_task, self.relaxed.of(self.task.initial))

    @cached_property
    def agenda(self) -> Agenda:
        """The reasonable orders of the goal's conditions."""
        return agenda(self.fact_task, self.mutexes, self.goal_facts)

    def start(self, values: Sequence[int] | None) -> int:
        """A packed start: these values, or the task's initial ones.

        Raises:
            ValueError: not one value of its range for every variable.
        """
        values = self.task.initial if values is None else values
        sizes = self.normal.sizes
        if len(values) != len(sizes) or any(not 0 <= x < n for x, n in zip(values, sizes, strict=True)):
            raise ValueError(f"a start needs a value for each of the {len(sizes)} variables, not {values}")
        return self.packing.number(values)

    def never(self, forbidden: Sequence[int] | NDArray[Any] | None) -> Never:
        """(groups,) a bit for each operator that cannot or must not be used; `forbidden` has 1 for each of these."""
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
        """What a plan costs."""
        return sum(self.task.operators[o].cost for o in plan)


@dataclass
class Budget:
    """How long a search may go on: expansions, bytes, and a caller who is asked now and then whether to stop."""

    expansions: int | None = None
    memory: int = 4 << 30  # bytes
    stop: Callable[[], bool] | None = None

    def stopped(self) -> bool:
        """Whether the caller wants the search to end."""
        return self.stop is not None and self.stop()

    def left(self, expanded: int, most: int) -> int:
        """How many states to expand before looking up again; 0: the budget is spent."""
        return most if self.expansions is None else max(0, min(most, self.expansions - expanded))
