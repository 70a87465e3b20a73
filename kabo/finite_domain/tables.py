"""What operators set in packed states, as lists that plain Python and kernels share."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from kabo.finite_domain.gates import Gates, build_gates
from kabo.finite_domain.normal_form import NormalOperator, NormalTask, Tests
from kabo.finite_domain.packing import Packing

Bits = tuple[int, int]  # what to clear, and then what to put, over all words of a state
Test = tuple[int, int, tuple[int, ...]]  # place and mask of a variable, and of each value 1 or 0: allowed or not


@dataclass(frozen=True)
class Tables:
    """What can be done, what operators always set, and what depends on values before."""

    gates: Gates
    always: list[Bits]
    switches: list[tuple[int, int, tuple[Bits | None, ...]]]  # place and mask, of each value what is set
    switches_of: list[tuple[int, ...]]
    guards_of: list[tuple[tuple[Bits, tuple[Test, ...]], ...]]
    goal: Bits  # clear: all bits of variables of which the goal asks for one value, put: these values
    goal_tests: tuple[Test, ...]  # what else it asks


def build_tables(task: NormalTask, packing: Packing) -> Tables:
    """The tables of a task whose states are packed so."""
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
