"""What is sent to joints at a time of their trajectory, on a clock whose rate may change."""

import numpy as np

from kabo.compilation import kernel


@kernel  # (k, n, 6) f8, (k + 1,) f8 [s], (m,) f8 [s] -> (m, n) f8
def places(coefficients, knots, times):
    """Where a trajectory has its joints at some times, as `Trajectory.at`: before and after it they stand still."""
    last, count = coefficients.shape[0] - 1, coefficients.shape[1]
    found = np.zeros((times.shape[0], count))
    for i in range(times.shape[0]):
        time = min(max(times[i], knots[0]), knots[last + 1])
        low, high = 0, last  # the last piece that has begun
        while low < high:
            middle = (low + high + 1) // 2
            low, high = (middle, high) if knots[middle] <= time else (low, middle - 1)
        for j in range(count):
            for k in range(5, -1, -1):
                found[i, j] = found[i, j] * (time - knots[low]) + coefficients[low, j, k]
    return found


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
