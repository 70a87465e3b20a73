"""Poses of bodies as they are seen: whether they are poses, and how far points are from where they should be."""

import numpy as np

from kabo.compilation import kernel


@kernel  # (k, 4, 4) f8 -> f8
def distortion(poses):
    """By how much axes of poses are longer or shorter than one, or not at right angles; of a mirror infinite.

    It is no number if one of a pose is none.
    """
    most = 0.0
    for k in range(poses.shape[0]):
        turn = poses[k]
        for a in range(3):
            if not np.isfinite(turn[a, 3]):
                return np.nan
            for b in range(3):
                off = -1.0 if a == b else 0.0
                for i in range(3):
                    off += turn[a, i] * turn[b, i]
                if not np.isfinite(off):
                    return np.nan
                most = max(most, abs(off))
        for i in range(4):
            off = abs(turn[3, i] - (1.0 if i == 3 else 0.0))
            if not np.isfinite(off):
                return np.nan
            most = max(most, off)
        volume = 0.0
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            volume += turn[0, i] * (turn[1, a] * turn[2, b] - turn[1, b] * turn[2, a])
        if volume < 0.0:
            return np.inf
    return most


@kernel  # (n, 4, 4) f8, (n, 4, 4) f8, (n, p, 3) f8 [m] -> (n, p, 3) f8 [m], (n,) f8 [m]
def displaced(wanted, found, points):
    """What points of bodies, in their own frames, are displaced by; and the greatest of these distances of each body."""
    moves, sizes = np.empty(points.shape), np.zeros(points.shape[0])
    for n in range(points.shape[0]):
        for p in range(points.shape[1]):
            square = 0.0
            for r in range(3):
                off = found[n, r, 3] - wanted[n, r, 3]
                for c in range(3):
                    off += (found[n, r, c] - wanted[n, r, c]) * points[n, p, c]
                moves[n, p, r] = off
                square += off * off
            sizes[n] = max(sizes[n], square)
        sizes[n] = np.sqrt(sizes[n])
    return moves, sizes
