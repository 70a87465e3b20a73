"""Operations on four numbers at once, and on whole rows: in kernels, instructions of the processor's vector unit.

numba's loops over three or four numbers become scalar code, which is several times as many instructions. Here are the
operations as Python functions; `kabo.compilation.lane_lowering` tells numba which instructions they are. Four numbers
are a tuple. In kernels a product that something is added to may be rounded once with the sum.
"""

from collections.abc import Sequence
from typing import Any

Four = tuple[float, float, float, float]


def four(flat: Any, at: int) -> Four:
    """Four numbers of a flat array."""
    return flat[at], flat[at + 1], flat[at + 2], flat[at + 3]


def put_four(flat: Any, at: int, numbers: Four) -> None:
    """Writes four numbers into a flat array."""
    flat[at : at + 4] = numbers


def all_four(number: float) -> Four:
    """A number four times."""
    return number, number, number, number


def times(first: Four, second: Four) -> Four:
    """Products."""
    return tuple(a * b for a, b in zip(first, second, strict=True))  # type: ignore[return-value]


def fused(first: Four, second: Four, third: Four) -> Four:
    """Products, with a third number added."""
    return tuple(a * b + c for a, b, c in zip(first, second, third, strict=True))  # type: ignore[return-value]


def inner(first: Sequence[float], second: Sequence[float]) -> float:
    """The inner product of two vectors of three numbers."""
    return first[0] * second[0] + (first[1] * second[1] + first[2] * second[2])


def minus(first: Four, second: Four) -> Four:
    """Differences."""
    return tuple(a - b for a, b in zip(first, second, strict=True))  # type: ignore[return-value]


def plus(first: Four, second: Four) -> Four:
    """Sums."""
    return tuple(a + b for a, b in zip(first, second, strict=True))  # type: ignore[return-value]


def absolute(numbers: Four) -> Four:
    """Absolute values."""
    return tuple(abs(a) for a in numbers)  # type: ignore[return-value]


def sums(first: Four, second: Four, third: Four) -> Four:
    """The sums of three fours; the last number is the third one's again."""
    a, b, c = ((v[0] + v[1]) + (v[2] + v[3]) for v in (first, second, third))
    return a, b, c, c


def any_greater(first: Four, second: Four) -> bool:
    """Whether any of the first three numbers is greater than its counterpart; a NaN is not."""
    return bool(first[0] > second[0] or first[1] > second[1] or first[2] > second[2])


def farthest(blocks: Any, row: int, count: int, along: Sequence[float], offset: float) -> Any:
    """The key of the corner of a row of (B, 3, K) farthest along (x, y, z): its index in the low six bits.

    Greater keys are farther. `offset` is a power of two of at least twice every corner's absolute value, so that
    products plus offset are positive and their bits order as integers. The vector has length 1, `count` is a multiple
    of eight. Of equal corners the one with the higher index is taken.
    """
    import numpy as np  # here, as in kernels it is not needed

    best, (x, y, z) = np.int64(0), along
    for i in range(count):
        product = blocks[row, 0, i] * x + (blocks[row, 1, i] * y + (blocks[row, 2, i] * z + offset))
        best = max(best, (np.float64(product).view(np.int64) & np.int64(-64)) | np.int64(i))
    return best


def near_columns(rows: Any, start: int, low: Sequence[Any], high: Sequence[Any]) -> Any:
    """A bit for each of 32 boxes, columns (6, N) f4 of lower and upper corners, that meets the box from low to high."""
    own, bits = rows[:, start : start + 32], 0
    for i in range(32):
        below = all(low[r] <= own[3 + r, i] for r in range(3))
        bits |= int(below and all(high[r] >= own[r, i] for r in range(3))) << i
    return bits
