"""Constraints on a motion: proofs that a segment fulfils constraints, and projection for path planning."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kabo.arrays import Array
from kabo.kinematics.constraints import Rows
from kabo.kinematics.kernels import motion_bounds as kernels
from kabo.kinematics.kernels import rows as columns
from kabo.kinematics.kernels.projection import FREEZES, WRAPS, Pull, pull_of
from kabo.kinematics.projection import MAX_ITERATIONS, checked, limited, project, storable_limits
from kabo.scene.tree import KinematicTree

Projector = Callable[[Array], Array | None]

INTERVAL_INSET = 0.02  # [m or rad] inside an interval, where the projector aims: room for the chord between poses
POSE_ROUNDING = 1e-9  # [m or rad] subtracted from the tolerance


def keeps(tree: KinematicTree, rows: Rows, q0: ArrayLike, q1: ArrayLike, tolerance: ArrayLike = 1e-3) -> bool:
    """Whether every row is proven to hold all along the joint-linear segment from q0 to q1.

    True is a proof that no row is violated by more than `tolerance` [m or rad], one number or one for each row.
    False may also mean that the slack is too small to decide.

    Raises:
        ValueError: q0 or q1 is not finite or has the wrong shape, or a row is an azimuth.
    """
    return unkept_row(tree, rows, q0, q1, tolerance) is None


def unkept_row(
    tree: KinematicTree, rows: Rows, q0: ArrayLike, q1: ArrayLike, tolerance: ArrayLike = 1e-3
) -> int | None:
    """The index of a row that is not proven to hold throughout the segment (see `keeps`); None if all rows are."""
    start, end = np.array(q0, np.float64), np.array(q1, np.float64)
    if not start.shape == end.shape == (tree.size,) or not np.all(np.isfinite(start + end)):
        raise ValueError(f"the ends of a segment must be finite, ({tree.size},), not {start.shape}, {end.shape}")
    _require_no_azimuth(rows)
    slack = np.ascontiguousarray(np.broadcast_to(np.asarray(tolerance, np.float64) - POSE_ROUNDING, (len(rows),)))
    pieces = kernels.pieces_of(len(rows), len(tree.parent), tree.size)
    found = kernels.first_row_not_kept(rows, slack, start, end, tree, pieces)
    return None if found < 0 else int(found)


@dataclass(frozen=True)
class KeptRows:
    """Rows that must hold along a motion, as kernels take them: to prove segments, and to project configurations.

    `Projections` as those of `projector`, proofs as those of `keeps`.
    """

    rows: Rows
    tolerances: Array  # (R,)
    tree: KinematicTree
    pieces: kernels.Pieces
    pull: Pull
    iterations: int
    policy: int

    @classmethod
    def of(
        cls, tree: KinematicTree, rows: Rows, active: Sequence[bool] | NDArray[np.bool_], tolerance: float
    ) -> "KeptRows":
        """The rows with one tolerance [m or rad]; only `active` values are projected.

        Raises:
            ValueError: shapes do not fit, or a row is an azimuth.
        """
        low, high, moving = checked(tree, rows, tree.lower, tree.upper, active)
        _require_no_azimuth(rows)
        low, high = storable_limits(low, high)
        pull = pull_of(rows, INTERVAL_INSET, limited(tree, low, high), moving)
        pieces = kernels.pieces_of(len(rows), len(tree.parent), tree.size)
        slack = np.full(len(rows), tolerance - POSE_ROUNDING)
        return cls(rows, slack, tree, pieces, Pull(*pull), MAX_ITERATIONS, WRAPS | FREEZES)


def _require_no_azimuth(rows: Rows) -> None:
    if np.any(rows[:, columns.KIND] == columns.AZIMUTH):
        raise ValueError("an azimuth jumps from pi to -pi: it cannot be kept along a motion")


def projector(
    tree: KinematicTree,
    rows: Rows,
    lower: ArrayLike,
    upper: ArrayLike,
    active: Sequence[bool] | NDArray[np.bool_],
    *,
    inset: float = INTERVAL_INSET,
) -> Projector:
    """A function that projects a configuration onto the rows, slightly inside intervals; it returns None on failure.

    A joint that would leave its limits stops at the limit. A configuration that fulfils the rows is returned
    unchanged.

    Raises:
        ValueError: shapes do not fit.
    """
    checked(tree, rows, lower, upper, active)

    def pull(q: Array) -> Array | None:
        Q, succeeded = project(tree, rows, q, lower, upper, active, inset=inset, hold_limits=True)
        return Q[0] if succeeded[0] else None

    return pull
