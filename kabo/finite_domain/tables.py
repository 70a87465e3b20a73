"""The effects of operators on packed states: lists for plain Python, from which the kernels' arrays are made."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from kabo.finite_domain.gates import Gates, build_gates
from kabo.finite_domain.normal_form import NormalOperator, NormalTask, Tests
from kabo.finite_domain.packing import Packing

Bits = tuple[int, int]  # the bits to clear, and then the bits to set, over all words of a state
Test = tuple[int, int, tuple[int, ...]]  # first bit and mask of a variable, and for each value 1 if it is allowed


@dataclass(frozen=True)
class Tables:
    """The gates of all operators, their unconditional and conditional effects, and the goal, on packed states."""

    gates: Gates
    always: list[Bits]
    switches: list[tuple[int, int, tuple[Bits | None, ...]]]  # first bit and mask, and for each value what is set
    switches_of: list[tuple[int, ...]]
    guards_of: list[tuple[tuple[Bits, tuple[Test, ...]], ...]]
    goal: Bits  # all bits of the variables for which the goal allows one value, and these values
    goal_tests: tuple[Test, ...]  # the other conditions of the goal


def build_tables(task: NormalTask, packing: Packing) -> Tables:
    """The tables of a task whose states are packed by `packing`."""
    single = {v: values for v, values in task.goal.items() if len(values) == 1}
    rest = {v: values for v, values in task.goal.items() if v not in single}
    switches = []
    for s in task.switches:
        outcomes = [
            _bits(s.outcomes[x], packing) if x in s.outcomes else None for x in range(task.sizes[s.variable])
        ]
        switches.append((packing.place[s.variable], packing.mask[s.variable], tuple(outcomes)))
    return Tables(
        build_gates(task, packing),
        [_bits(() if o is None else o.always, packing) for o in task.operators],
        switches,
        [() if o is None else o.switches for o in task.operators],
        [() if o is None else _guards(o, task.sizes, packing) for o in task.operators],
        _bits(((v, x) for v, (x,) in single.items()), packing),
        _tests(rest, task.sizes, packing),
    )


def _bits(assignments: Iterable[tuple[int, int]], packing: Packing) -> Bits:
    clear = put = 0
    for v, x in assignments:
        place, mask = packing.place[v], packing.mask[v] << packing.place[v]
        clear, put = clear | mask, (put & ~mask) | x << place
    return clear, put


def _tests(tests: Tests, sizes: Sequence[int], packing: Packing) -> tuple[Test, ...]:
    return tuple(
        (packing.place[v], packing.mask[v], tuple(int(x in values) for x in range(sizes[v])))
        for v, values in sorted(tests.items())
    )


def _guards(
    o: NormalOperator, sizes: Sequence[int], packing: Packing
) -> tuple[tuple[Bits, tuple[Test, ...]], ...]:
    return tuple((_bits(assignments, packing), _tests(tests, sizes, packing)) for tests, assignments in o.guarded)
