"""The equations of cubic splines, which are tridiagonal: each row has its neighbours only [de Boor, IV]."""

import numpy as np

from kabo.compilation import kernel


@kernel  # (m,) f8 x 3, (m, n) f8 -> (m, n) f8
def solved_rows(lower, diagonal, upper, right):
    """The solution (m, n) of tridiagonal equations, by elimination from the first row on, without pivots.

    Args:
        lower, diagonal, upper: of each row; the first of `lower` and the last of `upper` are 0.
        right: (m, n), one column for each unknown of a row.
    """
    m, n = right.shape
    found, above = np.empty((m, n)), np.empty(m)
    pivot = diagonal[0]
    for j in range(n):
        found[0, j] = right[0, j] / pivot
    for i in range(1, m):
        above[i - 1] = upper[i - 1] / pivot
        pivot = diagonal[i] - lower[i] * above[i - 1]
        for j in range(n):
            found[i, j] = (right[i, j] - lower[i] * found[i - 1, j]) / pivot
    for i in range(m - 2, -1, -1):
        for j in range(n):
            found[i, j] -= above[i] * found[i + 1, j]
    return found
