"""The degrees of freedom that constraints leave at a configuration: rank and null space of their Jacobian [K 5.2.2].

A row with an interval is active only where one of its bounds is reached.
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

SINGULAR_CUTOFF = 1e-6  # [m/rad, m/m] of singular values: ten times what row tolerances of 1e-6 m cause


@dataclass(frozen=True)
class Tangent:
    """The tangent space of a constraint manifold at one of its points.

    `basis` (n, k) is an orthonormal basis of the velocities that keep every active row; `rank` is n_active - k;
    `active` (R,) is the mask of the active rows; `singular_values` descend [m per rad or m].
    """

    rank: int
    basis: Array
    active: NDArray[np.bool_]
    singular_values: Array

    @property
    def freedom(self) -> int:
        """The dimension of the constraint manifold at this point."""
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
    """Rank and null space at q (n,) of the active rows: equalities, and intervals at one of their bounds.

    Args:
        tree: the kinematic tree that the rows refer to.
        rows: the constraint rows (R, W).
        q: a configuration (n,) that fulfils the rows.
        moving: the mask (n,) of the values that may change, without those clamped to a limit; None: all values.
        tolerance: the distance [m or rad] within which an interval counts as having reached its bound.
        cut: singular values up to this count as zero, as at redundant rows and singular poses.
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
