"""How array kernels are compiled, and where what was compiled is kept: the only room that imports numba.

`kernel` and its relatives are decorators of the functions in `*/kernels/`; `cache_folder` is the folder of everything
that may be computed again.
"""

from kabo.compilation.cache import cache_folder
from kabo.compilation.compiling import kernel, leaf_kernel, lean_kernel, reduction_kernel, window

__all__ = ["cache_folder", "kernel", "leaf_kernel", "lean_kernel", "reduction_kernel", "window"]
