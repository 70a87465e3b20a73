"""The arrays of a collision view as other kernels take them, and what those arrays do not decide."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from kabo.arrays import Array, Integers


@dataclass(frozen=True)
class KernelChecks:
    """What a kernel needs to check configurations and segments itself, without a call from Python for each.

    Attributes:
        memory: the array of `first_hit`.
        sweep: the arguments of `first_swept_hit` behind both ends of a segment.
        free_counts: whether what the kernels find free is free; else it remains to be asked.
        hit_counts: whether what the kernels find blocked is blocked; else it remains to be asked.
        configurations_hit: answers that question for configurations (N, n): -1, or the index of a pair, for each.
        segment_hit: answers it for a straight segment.
    """

    memory: Array
    sweep: tuple[Any, ...]
    free_counts: bool
    hit_counts: bool
    configurations_hit: Callable[[Array], Integers]
    segment_hit: Callable[[Array, Array], int]
