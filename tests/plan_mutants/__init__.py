"""Plans that are wrong by construction, made from right ones: one kind of fault each, of a strength that is drawn."""

from collections.abc import Iterator, Sequence
from itertools import count

import numpy as np

from tests.plan_mutants import actions, records, scenes, statements, strokes, trajectories  # noqa: F401 (register kinds)
from tests.plan_mutants.core import MUTATIONS, Case, Mutant, Mutation

__all__ = ["MUTATIONS", "Case", "Mutant", "Mutation", "mutants"]


def mutants(
    cases: Sequence[Case], total: int, seed: int, kinds: Sequence[Mutation] | None = None
) -> Iterator[Mutant]:
    """So many mutants of all kinds in turn, each of a case that is drawn; equal seeds give equal ones."""
    made, barren, chosen = 0, 0, tuple(MUTATIONS.values()) if kinds is None else kinds
    for number in count():
        for which, mutate in enumerate(chosen):
            if made == total:
                return
            rng = np.random.default_rng((seed, number, which))
            order = rng.permutation(len(cases))
            found = next((m for m in (mutate(cases[k], rng) for k in order) if m is not None), None)
            if found is not None:
                made += 1
                yield found
            barren = 0 if found is not None else barren + 1
            assert barren < 10 * len(chosen), "no mutation fits any case"
