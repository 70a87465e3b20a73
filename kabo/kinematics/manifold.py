"""What constraints leave free at a configuration: rank and null space of their Jacobian [K 5.2.2].

An interval that is not at its bound takes nothing away: only the active rows count.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kabo.arrays import Array
from kabo.kinematics.constraints import ROW_TOLERANCE, Rows
from kabo.kinematics.kernels import rows as columns
from kabo.kinematics.projection import jacobian, values
from kabo.scene.tree import KinematicTree

SINGULAR_CUTOFF = (
    1e-6  # singular values below [m/rad, m/m] count as zero: ten times what tolerances of 1e-6 m make of them
)


@dataclass(frozen=True)
class Tangent:
    """The linear view of a constraint manifold at one of its points.

    `basis` (n, k) spans, orthonormal, the velocities that keep every active row; `rank` is n_active - k;
    `active` (R,) says which rows hold something there; `singular_values` descend [m per rad or m].
    """

    rank: int
    basis: Array
    active: NDArray[np.bool_]
    singular_values: Array

    @property
    def freedom(self) -> int:
        """The dimension of the manifold there."""
        return int(self.basis.shape[1])


def tangent(
    tree: KinematicTree,
    rows: Rows,
    q: ArrayLike,
    moving: Sequence[bool] | NDArray[np.bool_] | None = None,
    *,
    tolerance: float = ROW_TOLERANCE,
    cut: float = SINGULAR_CUTOFF,
) -> Tangent:
    """Rank and null space at q (n,) of the rows that hold something there: equalities, and bounds that are reached.

    Args:
        tree, rows, q: as for `values`; q should fulfil the rows.
        moving: (n,) the values that may change, so not those at a limit that they were clamped to; default all.
        tolerance: how near to its bound [m or rad] an interval counts as having reached it.
        cut: singular values up to this are zero: rows that say the same twice, and singular poses.
    """
    at = np.asarray(q, np.float64)
    free = np.ones(tree.size, np.bool_) if moving is None else np.asarray(moving, np.bool_)
    low, high = rows[:, columns.LOWER], rows[:, columns.UPPER]
    found = values(rows, at, tree)
    active = (found <= low + tolerance) | (found >= high - tolerance)
    J = (rows[:, columns.SCALE, None] * jacobian(rows, at, tree))[active][:, free]
    _, singular, turned = np.linalg.svd(J, full_matrices=True)
    rank = int(np.sum(singular > cut))
    basis = np.zeros((tree.size, int(free.sum()) - rank))
    basis[free] = turned[rank:].T
    return Tangent(rank, basis, active, singular)
