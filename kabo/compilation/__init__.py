"""Compiling of array kernels, and the folder where compiled code is kept: the only room that imports numba.

`kernel` and its relatives decorate the functions in `*/kernels/`. `cache_folder` is the folder of everything that can be
computed again.
"""

from kabo.compilation.cache import cache_folder, keep_below
from kabo.compilation.compiling import (
    brief_kernel,
    call_first,
    joined_kernel,
    kernel,
    leaf_kernel,
    lean_kernel,
    note_compiled,
    settled,
    usual_kernels_compiled,
    window,
)
from kabo.compilation.lanes import (
    absolute,
    all_four,
    any_greater,
    farthest,
    four,
    fused,
    inner,
    minus,
    near_columns,
    plus,
    put_four,
    sums,
    times,
)

__all__ = [
    "absolute",
    "all_four",
    "any_greater",
    "farthest",
    "four",
    "fused",
    "inner",
    "minus",
    "near_columns",
    "plus",
    "put_four",
    "sums",
    "times",
    "brief_kernel",
    "cache_folder",
    "keep_below",
    "call_first",
    "joined_kernel",
    "kernel",
    "leaf_kernel",
    "lean_kernel",
    "note_compiled",
    "settled",
    "usual_kernels_compiled",
    "window",
]
