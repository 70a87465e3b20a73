"""Rigid transforms: 4x4 matrices, quaternions (x, y, z, w), and the rounded form in which states keep them."""

import math
from collections.abc import Sequence

import numpy as np

from kabo.arrays import Array

Matrix = Array

_IDENTITY: Array = np.eye(4)
POSITION_DECIMALS, QUATERNION_DECIMALS = 9, 12


def length(vector: Array) -> float:
    """The length of a vector (k,), summed in the order of its numbers.

    `np.linalg.norm` takes longer, and its last bits depend on the processor.
    """
    total = 0.0
    for number in vector.tolist():
        total += number * number
    return math.sqrt(total)


def rotation(quaternion: Sequence[float]) -> Matrix:
    """The 3x3 rotation of a quaternion (x, y, z, w), normalised first."""
    numbers = np.asarray(quaternion, dtype=float)
    x, y, z, w = (numbers / length(numbers)).tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def transform(position: Sequence[float], quaternion: Sequence[float] = (0.0, 0.0, 0.0, 1.0)) -> Matrix:
    """The 4x4 transform of a position [m] and a quaternion (x, y, z, w)."""
    result: Matrix = _IDENTITY.copy()
    result[:3, :3] = rotation(quaternion)
    result[:3, 3] = position
    return result


def inverse(matrix: Matrix) -> Matrix:
    """The inverse of a rigid 4x4 transform."""
    result: Matrix = _IDENTITY.copy()
    result[:3, :3] = matrix[:3, :3].T
    result[:3, 3] = -np.add.reduce(matrix[:3, :3] * matrix[:3, 3:])  # the same bits on each processor
    return result


def quaternion(matrix: Matrix) -> tuple[float, float, float, float]:
    """The unit quaternion (x, y, z, w) of a transform or rotation, the first non-zero of (w, x, y, z) positive."""
    r = matrix[:3, :3]
    # The largest of the four squares is at least 1/4, so the division is safe [Shepperd 1978].
    squares = np.array([r[0, 0], r[1, 1], r[2, 2], r[0, 0] + r[1, 1] + r[2, 2]])
    k = int(np.argmax(squares))
    q = np.empty(4)
    if k == 3:
        q[:] = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], 1 + squares[3]
    else:
        i, j = (k + 1) % 3, (k + 2) % 3
        q[k], q[i], q[j] = 1 + r[k, k] - r[i, i] - r[j, j], r[i, k] + r[k, i], r[j, k] + r[k, j]
        q[3] = r[j, i] - r[i, j]
    q /= length(q)
    lead = next((value for value in (q[3], *q[:3]) if abs(value) > 10**-QUATERNION_DECIMALS), 1.0)
    x, y, z, w = (float(value) for value in (q if lead > 0 else -q))
    return x, y, z, w


def rounded(values: Sequence[float], decimals: int) -> tuple[float, ...]:
    """The values rounded to `decimals` decimals, with 0.0 in place of -0.0."""
    return tuple(round(float(value), decimals) + 0.0 for value in values)


def flat(matrix: Matrix) -> Matrix:
    """The 12 numbers of a 4x4 transform: rotation row-major, then translation."""
    return np.concatenate([matrix[:3, :3].ravel(), matrix[:3, 3]])


def unflat(numbers: Matrix) -> Matrix:
    """The 4x4 transform given by 12 numbers, the inverse of `flat`."""
    result: Matrix = _IDENTITY.copy()
    result[:3, :3] = np.asarray(numbers[:9]).reshape(3, 3)
    result[:3, 3] = numbers[9:]
    return result
