"""Projection of configurations onto constraints: the interface of the Gauss-Newton kernel [K Algorithm 3]."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kabo.arrays import Array, Integers
from kabo.kinematics.constraints import ROW_TOLERANCE, Rows
from kabo.kinematics.kernels import projection as kernels
from kabo.kinematics.kernels import rows as columns
from kabo.scene.tree import KinematicTree

NO_AIMS = np.uint64(0), 0, 0  # stream, sample and tries of projections without aims: the end of a `Rule`
MAX_ITERATIONS = 50  # projections that do not succeed by then almost never do


def project(
    tree: KinematicTree,
    rows: Rows,
    seeds: ArrayLike,
    lower: ArrayLike,
    upper: ArrayLike,
    active: Sequence[bool] | NDArray[np.bool_],
    *,
    inset: float = 2 * ROW_TOLERANCE,
    hold_limits: bool = False,
) -> tuple[Array, NDArray[np.bool_]]:
    """The configurations (N, n) near the seeds at which every row holds, and which of them are valid (N,).

    Args:
        tree: the kinematic tree that the rows refer to.
        rows: (R, W) from `rows_of`; a row is fulfilled within its own tolerance, 1e-6 m or rad.
        seeds: (N, n) [rad or m].
        lower, upper: (n,) limits; a joint outside is moved back by whole turns if that suffices.
        active: the mask (n,) of the values that may change; the others keep the seed's values.
        inset: how far inside a violated interval the projection aims [m or rad], at most at the interval's middle.
        hold_limits: whether a joint that leaves its limits is stopped at the limit, instead of failing the seed.

    Raises:
        ValueError: shapes do not fit, or a number is not finite.
    """
    Q = np.array(seeds, np.float64, order="C", ndmin=2)
    low, high, moving = checked(tree, rows, lower, upper, active)
    if Q.shape[1] != tree.size or not np.all(np.isfinite(Q)):
        raise ValueError(f"seeds must be finite, (N, {tree.size}), not {Q.shape}")
    succeeded = np.zeros(len(Q), np.bool_)
    if hold_limits:
        low, high = storable_limits(low, high)
    policy = kernels.WRAPS | (kernels.FREEZES if hold_limits else 0)
    aims = np.full((len(Q), len(rows)), np.nan)
    wanted = kernels.Wanted(rows, len(rows), aims, float(inset))
    rule = kernels.Rule(MAX_ITERATIONS, policy, *NO_AIMS)
    kernels.project_seeds(Q, succeeded, wanted, limited(tree, low, high), moving, rule)
    return Q, succeeded


def satisfied(rows: Rows, q: ArrayLike, tree: KinematicTree, tolerance: float = ROW_TOLERANCE) -> bool:
    """Whether every row holds at q within `tolerance` [m or rad]; a reversed direction does not fulfil a row."""
    v = values(rows, q, tree)
    return bool(np.all((v >= rows[:, columns.LOWER] - tolerance) & (v <= rows[:, columns.UPPER] + tolerance)))


def missed(rows: Rows, q: ArrayLike, tree: KinematicTree) -> tuple[float, float]:
    """How far rows of one constraint are from holding at q: lengths [m], cosines and angles [rad], each as a norm."""
    v, lengths = values(rows, q, tree), rows[:, columns.KIND] < columns.DIRECTION
    off = np.maximum(0.0, np.maximum(rows[:, columns.LOWER] - v, v - rows[:, columns.UPPER]))
    return float(np.linalg.norm(off[lengths])), float(np.linalg.norm(off[~lengths]))


def values(rows: Rows, q: ArrayLike, tree: KinematicTree) -> Array:
    """The value of every row at q, (R,): metres for positions, cosines for directions, radians for angles."""
    found: Array = kernels.row_values(np.array(q, np.float64), rows, tree)
    return found


def jacobian(rows: Rows, q: ArrayLike, tree: KinematicTree) -> Array:
    """The derivative of `values` by q, (R, n)."""
    found: Array = kernels.row_jacobian(np.array(q, np.float64), rows, tree)
    return found


def storable_limits(lower: Array, upper: Array) -> tuple[Array, Array]:
    """The limits rounded inwards to 1e-9, so that a joint at a limit stays within it when plans round its value."""
    return np.ceil(lower * 1e9) / 1e9, np.floor(upper * 1e9) / 1e9


def arrays_of(
    tree: KinematicTree,
) -> tuple[Integers, Integers, Integers, Array, Array, Array]:
    """The arrays of a tree in the order in which kernels take them (limits are arguments of their own)."""
    return tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement


def limited(tree: KinematicTree, lower: Array, upper: Array) -> KinematicTree:
    """The tree with other limits (n,), as kernels take it."""
    return tree._replace(lower=lower, upper=upper)


def checked(
    tree: KinematicTree,
    rows: Rows,
    lower: ArrayLike,
    upper: ArrayLike,
    active: Sequence[bool] | NDArray[np.bool_],
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The limits and the mask `active` as arrays for kernels.

    Raises:
        ValueError: shapes do not fit, or a limit is not a number.
    """
    low, high = np.array(lower, np.float64), np.array(upper, np.float64)
    moving = np.array(active, np.bool_)
    if not low.shape == high.shape == moving.shape == (tree.size,):
        raise ValueError(f"limits and mask must be ({tree.size},), not {low.shape}, {high.shape}, {moving.shape}")
    if rows.ndim != 2 or rows.shape[1] != columns.WIDTH or rows.dtype != np.float64:
        raise ValueError(f"rows must be float64, (R, {columns.WIDTH}), not {rows.dtype} {rows.shape}")
    joints = rows[:, (columns.FIRST, columns.SECOND)]
    if joints.size and not (joints.min() >= 0 and joints.max() < len(tree.parent)):
        raise ValueError(f"a row names a joint outside the tree of {len(tree.parent)}")
    return low, high, moving
