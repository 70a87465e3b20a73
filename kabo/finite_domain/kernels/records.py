"""What the compiled searches have in common: outcomes, the head of `progress`, the first columns of `rows`, a task."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

RUNNING, SOLVED, UNSOLVABLE, FULL = 0, 1, 2, 3  # FULL: arrays must grow first
COUNT, EXPANDED, GENERATED, GOAL, OWN = 0, 1, 2, 3, 4  # places of `progress`; from OWN on a search's own
PARENT, OPERATOR, FIRST_OWN = 0, 1, 2  # columns of `rows`; from FIRST_OWN on a search's own


class Task(NamedTuple):
    """The tables of a task [kabo.finite_domain.array_tables], and a bit for each operator that must not be used."""

    numbers: NDArray[np.int32]
    bits: NDArray[np.uint64]
    never: NDArray[np.uint64]
