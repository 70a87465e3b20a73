"""What can be done in a packed state, as gates that 64 neighbouring operators share.

A gate is a few bits of the state about which some of the 64 ask something; for every content it has a word with a bit
for each operator that lets it pass. The bits left after all gates can be done. So sets of values cost no more than one
value, small variables that lie side by side cost no more than one, and operators come in the order of the task.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kabo.finite_domain.normal_form import NormalTask, Tests
from kabo.finite_domain.packing import Packing

GROUP = 64
ALL = (1 << GROUP) - 1
SPAN = 6  # bits of small variables in one gate


@dataclass(frozen=True)
class Gate:
    """Of `mask` + 1 contents of the bits from `place` on, what each lets pass, a word each."""

    place: int
    mask: int
    passing: list[int]


@dataclass(frozen=True)
class Gates:
    """The gates of each 64 operators, those first that stop most; and what can never be done, a word for each 64.

    Places beyond the last operator count as what can never be done.
    """

    groups: list[list[Gate]]
    never: list[int]


def build_gates(task: NormalTask, packing: Packing) -> Gates:
    """The gates of a task whose states are packed so."""
    groups, never = [], []
    for first in range(0, len(task.operators), GROUP):
        group = [None if o is None else o.tests for o in task.operators[first : first + GROUP]]
        never.append(ALL & ~sum(1 << i for i, tests in enumerate(group) if tests is not None))
        gates = [
            _gate(run, asked, packing)
            for asked in [_asked(group, task.sizes)]
            for run in _runs(sorted(asked), packing)
        ]
        groups.append(sorted(gates, key=lambda g: sum(w.bit_count() for w in g.passing) / len(g.passing)))
    return Gates(groups, never)


def _asked(group: Sequence[Tests | None], sizes: Sequence[int]) -> dict[int, list[int]]:
    """Of each variable that some operator tests, the words of its values."""
    asked: dict[int, list[int]] = {}
    for i, tests in enumerate(group):
        for v, values in (tests or {}).items():
            words = asked.setdefault(v, [ALL] * sizes[v])
            for x in set(range(sizes[v])).difference(values):
                words[x] &= ~(1 << i)
    return asked


def _runs(variables: Sequence[int], packing: Packing) -> list[list[int]]:
    """The variables in the order of their places, those together that fit into one gate."""
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
        passing *= 1 << (offset - width)  # bits of variables that nobody asks about
        words = asked[v] + [0] * (packing.mask[v] + 1 - len(asked[v]))
        passing = [high & low for high in words for low in passing]
        width = offset + packing.bits[v]
    return Gate(place, (1 << width) - 1, passing)
