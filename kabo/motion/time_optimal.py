"""The fastest way to follow a path within limits of velocity and acceleration: TOPP-RA [Pham, Pham 2018]."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kabo.arrays import Array

GRID_SPACING = 0.01  # [rad] of the path between grid points, where the limits are checked
MIN_GRID_POINTS = 9  # on each piece of the path, with both ends
LIMIT_SHARE = 0.985  # share of the limits, for points between grid points


class Path(Protocol):
    """The interface of a once differentiable path whose parameter runs from 0 to `length`."""

    @property
    def length(self) -> float:
        """The parameter at the end of the path."""
        ...

    @property
    def borders(self) -> Array:
        """The parameters where the path's second derivative jumps, and the parameters of both ends."""
        ...

    def at(self, places: ArrayLike, order: int = 0) -> Array:
        """The points (…, n) of the path at parameters, or its derivative of the given order."""
        ...


def fastest(
    path: Path, velocity: ArrayLike, acceleration: ArrayLike, *, through: Sequence[float] = ()
) -> tuple[Array, Array]:
    """Parameters along a path and their times [s], from rest to rest, as fast as the limits allow.

    Args:
        path: a path of n joints.
        velocity, acceleration: (n,) limits of the absolute values, positive for joints that move.
        through: parameters that the result must contain.

    Raises:
        ImportError: toppra is not installed; the message says the remedy.
        ValueError: the path cannot be followed within the limits.
    """
    grid = _grid(path, through)
    moving = np.ptp(path.at(grid), axis=0) > 0.0
    speeds = _speeds(
        path, grid, np.asarray(velocity, float)[moving], np.asarray(acceleration, float)[moving], moving
    )
    times = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(grid) / (speeds[:-1] + speeds[1:]))])
    return grid, times


def between(grid: Array, times: Array, wanted: ArrayLike) -> Array:
    """The parameters at times `wanted` on a path whose grid is passed at `times`, with constant acceleration in between."""
    at = np.asarray(wanted, float)
    k = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    steps = np.diff(times)
    mean = np.diff(grid) / steps
    # The speed at the grid: from rest, each mean is the middle of the speeds at both ends.
    speeds = np.zeros(len(grid))
    for i, value in enumerate(mean):
        speeds[i + 1] = max(0.0, 2.0 * value - speeds[i])
    dt = at - times[k]
    return np.asarray(
        np.clip(
            grid[k] + dt * (speeds[k] + 0.5 * dt * (speeds[k + 1] - speeds[k]) / steps[k]), grid[k], grid[k + 1]
        )
    )


def _grid(path: Path, through: Sequence[float]) -> Array:
    """The grid: parameters from 0 to the end, among them all borders and `through`."""
    borders = np.unique(np.concatenate([path.borders, through]))
    borders = borders[np.concatenate([[True], np.diff(borders) > 1e-9])]
    pieces = [
        np.linspace(a, b, max(MIN_GRID_POINTS, int(np.ceil((b - a) / GRID_SPACING)) + 1))[:-1]
        for a, b in zip(borders, borders[1:], strict=False)
    ]
    return np.concatenate([*pieces, borders[-1:]])


def _speeds(path: Path, grid: Array, velocity: Array, acceleration: Array, moving: NDArray[np.bool_]) -> Array:
    """The speeds (len(grid),) of the parameter along the grid."""
    try:
        from toppra.algorithm import TOPPRA
        from toppra.constraint import DiscretizationType, JointAccelerationConstraint, JointVelocityConstraint
    except ImportError as error:
        raise ImportError('timing along a path needs toppra: pip install "kabo[timing]"') from error

    class Moving:
        """The path of the moving joints, in toppra's interface."""

        dof = int(moving.sum())
        path_interval = (0.0, path.length)

        def __call__(self, places: Any, order: int = 0) -> Array:
            return path.at(places, order)[..., moving]

    limits = [
        JointVelocityConstraint(LIMIT_SHARE * np.stack([-velocity, velocity], axis=1)),
        JointAccelerationConstraint(
            LIMIT_SHARE * np.stack([-acceleration, acceleration], axis=1),
            discretization_scheme=DiscretizationType.Interpolation,
        ),
    ]
    _, speeds, _ = TOPPRA(limits, Moving(), gridpoints=grid).compute_parameterization(0.0, 0.0)
    if speeds is None or not np.all(np.isfinite(speeds)):
        raise ValueError("the path cannot be followed within the limits")
    return np.asarray(speeds)
