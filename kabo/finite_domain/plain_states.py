"""Successors of packed states in plain Python, where a state is one int; kernels/successors.py computes the same."""

from kabo.finite_domain.gates import ALL, GROUP, Gates
from kabo.finite_domain.tables import Tables, Test


class PlainStates:
    """Applicable operators, successors and the goal test for states that are Python ints."""

    def __init__(self, tables: Tables) -> None:
        self._tables = tables
        self._gates = _joined(tables.gates)
        self._all = sum((~word & ALL) << GROUP * g for g, word in enumerate(tables.gates.never))

    def applicable(self, state: int, forbidden: int = 0) -> list[int]:
        """The applicable operators in the order of the task; bit o of `forbidden` leaves out operator o."""
        able = self._all & ~forbidden
        for place, mask, passing in self._gates:
            able &= passing[(state >> place) & mask]
        found = []
        while able:
            lowest = able & -able
            found.append(lowest.bit_length() - 1)
            able ^= lowest
        return found

    def after(self, state: int, o: int) -> int:
        """The state after operator o, which must be applicable."""
        tables = self._tables
        clear, put = tables.always[o]
        result = (state & ~clear) | put
        for s in tables.switches_of[o]:
            place, mask, outcomes = tables.switches[s]
            bits = outcomes[(state >> place) & mask]
            if bits is not None:
                result = (result & ~bits[0]) | bits[1]
        for bits, tests in tables.guards_of[o]:
            if _passes(tests, state):
                result = (result & ~bits[0]) | bits[1]
        return result

    def at_goal(self, state: int) -> bool:
        """Whether the state fulfils the goal."""
        clear, put = self._tables.goal
        return state & clear == put and _passes(self._tables.goal_tests, state)


def _passes(tests: tuple[Test, ...], state: int) -> bool:
    return all(allowed[(state >> place) & mask] for place, mask, allowed in tests)


def _joined(gates: Gates) -> list[tuple[int, int, list[int]]]:
    """The gates of all groups joined: the bits of all operators are one Python int, of any length."""
    joined: dict[tuple[int, int], list[int]] = {}
    everything = (1 << GROUP * len(gates.groups)) - 1
    for g, group in enumerate(gates.groups):
        for gate in group:
            row = joined.setdefault((gate.place, gate.mask), [everything] * (gate.mask + 1))
            for x, word in enumerate(gate.passing):
                row[x] &= ~((~word & ALL) << GROUP * g)
    return [(place, mask, row) for (place, mask), row in sorted(joined.items())]
