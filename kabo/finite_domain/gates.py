"""Gates: tables that decide which operators are applicable in a packed state, for 64 operators at a time.

A *gate* reads a few bits of the state that some of the 64 operators test. For every content of these bits it has a
word with one bit for each operator that this content allows; an operator is applicable if all gates allow it. So a
test for a set of values costs no more than a test for a single value, small variables whose bits lie side by side
are tested together, and applicable operators are found in the order of the task.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kabo.finite_domain.normal_form import NormalTask, Tests
from kabo.finite_domain.packing import Packing

GROUP = 64  # operators that share gates: the bits of a word
ALL = (1 << GROUP) - 1  # a word that allows all of them
SPAN = 6  # bits of the state that a gate of several small variables reads at most


@dataclass(frozen=True)
class Gate:
    """The word of operators allowed for each content of the bits `mask`, from bit `place` of the state on."""

    place: int
    mask: int
    passing: list[int]


@dataclass(frozen=True)
class Gates:
    """The gates of each group of 64 operators, the most selective first, and its never applicable operators.

    Bits beyond the last operator count as never applicable.
    """

    groups: list[list[Gate]]
    never: list[int]


def build_gates(task: NormalTask, packing: Packing) -> Gates:
    """The gates of a task whose states are packed by `packing`."""
    groups, never = [], []
    for first in range(0, len(task.operators), GROUP):
        group = [None if o is None else o.tests for o in task.operators[first : first + GROUP]]
        never.append(ALL & ~sum(1 << i for i, tests in enumerate(group) if tests is not None))
        gates = [
            _gate(run, asked, packing)
            for asked in [_tested_values(group, task.sizes)]
            for run in _runs(sorted(asked), packing)
        ]
        groups.append(sorted(gates, key=lambda g: sum(w.bit_count() for w in g.passing) / len(g.passing)))
    return Gates(groups, never)


def _tested_values(group: Sequence[Tests | None], sizes: Sequence[int]) -> dict[int, list[int]]:
    """For each variable that some operator of the group tests, the word of operators that each of its values allows."""
    asked: dict[int, list[int]] = {}
    for i, tests in enumerate(group):
        for v, values in (tests or {}).items():
            words = asked.setdefault(v, [ALL] * sizes[v])
            for x in set(range(sizes[v])).difference(values):
                words[x] &= ~(1 << i)
    return asked


def _runs(variables: Sequence[int], packing: Packing) -> list[list[int]]:
    """The variables in the order of their bits, grouped so that each group fits into one gate."""
    runs: list[list[int]] = []
    for v in sorted(variables, key=lambda v: packing.place[v]):
        first = runs[-1][0] if runs else v
        near = packing.place[v] + packing.bits[v] <= packing.place[first] + SPAN
        if runs and near and packing.word[v] == packing.word[first]:
            runs[-1].append(v)
        else:
            runs.append([v])
    return runs


def _gate(run: Sequence[int], asked: Mapping[int, list[int]], packing: Packing) -> Gate:
    place = packing.place[run[0]]
    passing, width = [ALL], 0
    for v in run:
        offset = packing.place[v] - place
        passing *= 1 << (offset - width)  # bits in between that no operator tests
        words = asked[v] + [0] * (packing.mask[v] + 1 - len(asked[v]))
        passing = [high & low for high in words for low in passing]
        width = offset + packing.bits[v]
    return Gate(place, (1 << width) - 1, passing)
