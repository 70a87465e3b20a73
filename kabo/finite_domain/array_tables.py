"""The tables of a task as two arrays for kernels: one of numbers, one of bits [kabo.finite_domain.kernels.successors].

There are only two, because every array that Python passes to compiled code costs time.
"""

from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import NDArray

from kabo.finite_domain.packing import Packing
from kabo.finite_domain.tables import Tables, Test

LOWEST = 0x03F79D71B4CB0A89  # a de Bruijn number: times a single bit, its six high bits differ for each of 64 bits
HEAD = 16  # numbers before the tables


class _Numbers:
    """Rows of numbers one after the other; equal rows are stored once."""

    def __init__(self) -> None:
        self.flat = [0] * HEAD
        self._known: dict[Hashable, int] = {}

    def row(self, row: tuple[int, ...]) -> int:
        """The index at which the row begins; it is appended if it is new."""
        if row not in self._known:
            self._known[row] = len(self.flat)
            self.flat += row
        return self._known[row]


def array_tables(tables: Tables, packing: Packing) -> tuple[NDArray[np.int32], NDArray[np.uint64]]:
    """An array of numbers that begins with the index of each table, and an array of bits.

    The array of bits has pairs of rows, the bits to clear and the bits to set, and then the words of the gates
    [kabo.finite_domain.gates].
    """
    numbers, rows = _Numbers(), [*tables.always, tables.goal]
    known = {row: i for i, row in reversed(list(enumerate(rows)))}

    def row_at(row: tuple[int, int] | None) -> int:
        if row is None:
            return -1
        if row not in known:
            known[row] = len(rows)
            rows.append(row)
        return 2 * packing.words * known[row]

    def place(at: int) -> tuple[int, int]:
        return at // 64, at % 64

    def tests(tests: Sequence[Test]) -> tuple[int, int]:
        flat = tuple(n for at, mask, allowed in tests for n in (*place(at), mask, numbers.row(allowed)))
        return numbers.row(flat), len(flat)

    switches = [
        (*place(at), mask, numbers.row(tuple(row_at(o) for o in outcomes)))
        for at, mask, outcomes in tables.switches
    ]
    effects = []
    for mine, guards in zip(tables.switches_of, tables.guards_of, strict=True):
        flat = tuple(n for s in mine for n in switches[s])
        guarded = []
        for bits, asked in guards:
            first, length = tests(asked)
            guarded += [row_at(bits), first, first + length]
        first, third = numbers.row(flat), numbers.row(tuple(guarded))
        effects += [first, first + len(flat), third, third + len(guarded)]
    first, length = tests(tables.goal_tests)
    before = 2 * packing.words * len(rows)
    gates, gate_of, passing = _gates(tables, before)
    head = [packing.words, len(tables.always), len(gate_of) - 1, 2 * packing.words * len(tables.always)]
    head += [first, first + length, numbers.row(tuple(effects)), 0]
    at = len(numbers.flat)
    numbers.flat += gates
    head[7] = len(numbers.flat)
    numbers.flat += [at + start for start in gate_of]
    head.append(numbers.row(tuple(i for _, i in sorted(((((1 << i) * LOWEST) >> 58) & 63, i) for i in range(64)))))
    numbers.flat[: len(head)] = head
    size = 8 * packing.words
    words = b"".join(n.to_bytes(size, "little") for row in rows for n in row)
    words += b"".join(w.to_bytes(8, "little") for w in passing)
    return np.array(numbers.flat, np.int32), np.frombuffer(words, np.uint64).copy()


def _gates(tables: Tables, before: int) -> tuple[list[int], list[int], list[int]]:
    """Word, shift, mask and first entry of each gate; where the gates of each group begin; and the entries."""
    gates: list[int] = []
    starts, passing = [0], list[int]()
    for group in tables.gates.groups:
        for gate in group:
            gates += [gate.place // 64, gate.place % 64, gate.mask, before + len(passing)]
            passing += gate.passing
        starts.append(len(gates))
    return gates, starts, passing
