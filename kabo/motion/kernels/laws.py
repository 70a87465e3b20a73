"""The fastest law of a path in one call."""

from kabo.compilation import kernel
from kabo.motion.kernels.barrier import fastest_law
from kabo.motion.kernels.limit_rows import limit_rows
from kabo.motion.kernels.pieces import in_time


@kernel  # as `limit_rows`, f8, i8 -> (N + 1,) f8, (N, 6) f8, i8
def law_in_time(pieces, borders, curved, grid, owner, full, shares, held, precision, most):
    """The times at the grid, the parameter in time, and Newton steps: -1 if no law was found that keeps the limits."""
    rows = limit_rows(pieces, borders, curved, grid, owner, full, shares, held)
    x, g, w, steps = fastest_law(rows, precision, most)
    if steps < 0:
        x[:], g[:], w[:] = 1.0, 0.0, 0.0  # nobody asks
    times, cells = in_time(grid, x, g, w)
    return times, cells, steps
