"""Candidates for Monte Carlo searches in the unit cube: uniform, and around valid trials."""

import numpy as np

from kabo.arrays import Array
from kabo.streams import Key, uniforms


def spread_candidates(key: Key, count: int, known: Array, scale: float) -> Array:
    """Points of the unit cube (count, d): half of them anywhere, half around the points `known` (m, d).

    In six dimensions hardly any point of the whole cube is believed valid; near valid trials many are.

    Args:
        key: the stream from which they are drawn.
        known: valid points, at least one.
        scale: the standard deviation around a known point, in each dimension.
    """
    d = known.shape[1]
    anywhere = uniforms(key, 0, count // 2, d)
    return np.vstack([anywhere, around(key, count // 2, count - count // 2, known, scale)])


def around(key: Key, first: int, count: int, centres: Array, scale: float) -> Array:
    """Points (count, d), each normally distributed around one of the `centres` (m, d), folded back into the cube."""
    from scipy.special import ndtri  # with scikit-learn

    drawn = uniforms(key, first, count, centres.shape[1] + 1)
    chosen = centres[(drawn[:, 0] * len(centres)).astype(int)]
    normal = ndtri(np.clip(drawn[:, 1:], 2.0**-54, 1.0 - 2.0**-53))
    return folded(chosen + scale * normal)


def folded(points: Array) -> Array:
    """Points outside the unit cube, mirrored at its sides until they are inside."""
    turned = np.mod(points, 2.0)
    found: Array = np.where(turned > 1.0, 2.0 - turned, turned)
    return found
