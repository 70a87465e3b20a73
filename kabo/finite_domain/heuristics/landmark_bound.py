"""LM-cut for any delete relaxation: a lower bound of the cost of a goal from given facts.

Operators with the same owner share its cost: one additional operator, which has their common preconditions, pays
it, and the original operators follow from it at no cost. Otherwise an owner with two conditional effects could be
counted twice, and the bound could be too high.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kabo.finite_domain.heuristics.landmarks import relaxation_tables
from kabo.finite_domain.heuristics.relaxation import RelaxedOperator

INFINITE_COST = 1 << 60  # the kernel's bound for a goal that is out of reach


class LandmarkBound:
    """Lower bounds of the cost of one goal; two threads must not share one object."""

    def __init__(
        self, facts: int, operators: Iterable[RelaxedOperator], goal: Iterable[int], costs: Mapping[int, int]
    ) -> None:
        """Prepares the tables.

        Args:
            facts: how many facts there are; they are numbered from 0 on.
            operators: the relaxation; operators without an owner are axioms, which cost nothing.
            goal: the facts that must hold.
            costs: the cost of each owner, >= 0.
        """
        sharing = _Sharing(facts, costs)
        made = list(sharing.of(operators))
        made.append(RelaxedOperator(tuple(dict.fromkeys(goal)), (sharing.facts,), 0))
        facts = sharing.facts + 1
        self._table = relaxation_tables(made, facts)
        self._holding = np.zeros(facts, np.uint8)
        self._prices = np.array([o.cost for o in made], np.int64)

    def below(self, true: NDArray[Any]) -> int | None:
        """A lower bound of the goal's cost when the facts `true` hold; None if the goal is unreachable."""
        self._holding[:] = 0
        self._holding[true] = 1
        bound = int(_kernel()(self._relaxation, False))
        return None if bound >= INFINITE_COST else bound

    @cached_property
    def _relaxation(self) -> Any:
        return room_for(self._table, self._prices, self._holding)


class _Sharing:
    """Rewrites operators so that each owner's cost is paid by a single operator."""

    def __init__(self, facts: int, costs: Mapping[int, int]) -> None:
        self.facts, self._costs = facts, costs

    def of(self, operators: Iterable[RelaxedOperator]) -> Iterator[RelaxedOperator]:
        """The same operators, and for each owner of several the operator that pays for them."""
        owned: dict[int, list[RelaxedOperator]] = {}
        for operator in operators:
            if operator.owner < 0:
                yield operator._replace(cost=0)
            else:
                owned.setdefault(operator.owner, []).append(operator)
        for owner, those in owned.items():
            if len(those) == 1:
                yield those[0]._replace(cost=self._costs[owner])
            else:
                yield from self._shared(those, self._costs[owner])

    def _shared(self, those: Sequence[RelaxedOperator], cost: int) -> Iterator[RelaxedOperator]:
        common = frozenset.intersection(*(frozenset(o.preconditions) for o in those))
        done, self.facts = self.facts, self.facts + 1
        adds = [done]
        for operator in those:
            rest = tuple([f for f in operator.preconditions if f not in common])
            if rest:
                yield RelaxedOperator((done, *rest), operator.adds, 0)
            else:
                adds += operator.adds
        yield RelaxedOperator(tuple(sorted(common)), tuple(dict.fromkeys(adds)), cost, those[0].owner)


def room_for(tables: NDArray[np.int32], prices: NDArray[np.int64], holding: NDArray[np.uint8]) -> Any:
    """The bundle of a relaxation that LM-cut takes, with scratch for as many operators and facts."""
    from kabo.finite_domain.kernels.landmark_cut import Relaxation  # numba: only once a bound is asked for

    operators, facts = len(prices), len(holding)
    heap, place, mark, stack = (np.empty(facts, np.int32) for _ in range(4))
    return Relaxation(
        lm=tables,
        prices=prices,
        holding=holding,
        price=np.empty(operators, np.int64),
        operator=np.empty((operators, 2), np.int64),
        cost=np.empty(facts, np.int64),
        heap=heap,
        place=place,
        mark=mark,
        stack=stack,
        cut=np.empty(operators, np.int32),
    )


@cache
def _kernel() -> Any:
    from kabo.finite_domain.kernels.landmark_cut import bound_of_facts  # numba: only once a bound is asked for

    return bound_of_facts
