"""What is sent to joints at a time of their trajectory, on a clock whose rate may change."""

import numpy as np

from kabo.compilation import kernel


@kernel  # (n, 6) f8, f8 [s], f8, f8 [1/s] -> (3, n) f8
def setpoint(coefficients, time, rate, change):
    """Values, velocities and accelerations of polynomials in increasing powers of the time since their beginning."""
    found = np.empty((3, coefficients.shape[0]))
    for j in range(coefficients.shape[0]):
        value, first, second = 0.0, 0.0, 0.0  # halves of the second derivative [Horner]
        for k in range(5, -1, -1):
            second = second * time + first
            first = first * time + value
            value = value * time + coefficients[j, k]
        found[0, j] = value
        found[1, j] = first * rate
        found[2, j] = 2.0 * second * rate * rate + first * change
    return found
