"""How long a motion must last at least: the time along a path, from rest to rest, within limits up to jerk.

The bounds are computed by IPOPT (CasADi), not by what makes motions in kabo; they are some 0.1 % too long at most.
A path is a row of way points; its corners cost nothing here, so a motion along the path that keeps its corners, or
rounds them by little, cannot be shorter. The speed along the path is continuous, and so is its acceleration.
"""

from functools import cache
from typing import Any

import casadi
import numpy as np
from motion_scene import Array
from scipy.optimize import brentq

STARTS = (
    (96, 1.0),
    (96, 0.4),
    (72, 1.0),
    (60, 0.4),
    (48, 1.0),
)  # cells, and share of speed: until IPOPT converges
FINE = 400  # cells of the bound without jerk
ROUNDS = 2  # of cells made anew, so that they take about the same time


def double_s(length: float, velocity: float, acceleration: float, jerk: float) -> float:
    """The least time of a straight way from rest to rest, in closed form but for one root."""
    if length <= 0.0:
        return 0.0

    def ramp(v: float) -> float:  # time from rest to v, or back
        return v / acceleration + acceleration / jerk if v * jerk >= acceleration**2 else 2 * np.sqrt(v / jerk)

    if velocity * ramp(velocity) <= length:
        return float(2 * ramp(velocity) + (length - velocity * ramp(velocity)) / velocity)
    reached = brentq(lambda v: v * ramp(v) - length, 1e-15, velocity, xtol=1e-15)
    return float(2 * ramp(reached))


def without_jerk(steps: Array, velocity: Array, acceleration: Array) -> float:
    """The least time over cells with their own limits if jerk were free: one pass forth, one back [TOPP]."""
    ends = np.concatenate([[0.0], np.minimum(velocity[:-1], velocity[1:]) ** 2, [0.0]])
    for i in range(len(steps)):
        ends[i + 1] = min(ends[i + 1], ends[i] + 2 * acceleration[i] * steps[i])
    for i in reversed(range(len(steps))):
        ends[i] = min(ends[i], ends[i + 1] + 2 * acceleration[i] * steps[i])
    speeds, total = np.sqrt(ends), 0.0
    for a, b, h, v, most in zip(speeds, speeds[1:], steps, velocity, acceleration, strict=False):
        peak = min(v, np.sqrt(most * h + (a * a + b * b) / 2))  # faster within a cell than at its ends
        flat = max(0.0, h - (2 * peak * peak - a * a - b * b) / (2 * most)) / peak if peak > 0.0 else 0.0
        total += (2 * peak - a - b) / most + flat
    return float(total)


@cache
def _solver(cells: int) -> Any:
    """Least Σ τ where s, ṡ, s̈ go on from cell to cell under a constant jerk each."""
    t, v, a, j = (
        casadi.SX.sym(name, size) for name, size in zip("tvaj", (cells, cells + 1, cells + 1, cells), strict=True)
    )
    h = casadi.SX.sym("h", cells)
    equal = [
        v[:-1] * t + a[:-1] * t**2 / 2 + j * t**3 / 6 - h,
        v[:-1] + a[:-1] * t + j * t**2 / 2 - v[1:],
        a[:-1] + j * t - a[1:],
    ]
    problem = {"x": casadi.vertcat(t, v, a, j), "p": h, "f": casadi.sum1(t), "g": casadi.vertcat(*equal)}
    options = {
        "ipopt.print_level": 0,
        "print_time": 0,
        "ipopt.sb": "yes",
        "ipopt.max_iter": 500,
        "ipopt.tol": 1e-8,
    }
    return casadi.nlpsol("least_time", "ipopt", problem, options)


def pieces_of(path: Array, limits: dict[str, Array]) -> tuple[Array, Array]:
    """The lengths (p,) of straight pieces, and the greatest speed, acceleration and jerk (p, 3) along each."""
    step = np.diff(path, axis=0)
    length = np.linalg.norm(step, axis=1)
    step, length = step[length > 1e-12], length[length > 1e-12]
    share = np.abs(step) / length[:, None]
    with np.errstate(divide="ignore"):
        return length, np.stack(
            [(limits[kind] / share).min(axis=1) for kind in ("velocity", "acceleration", "jerk")], 1
        )


def least(path: Array, limits: dict[str, Array]) -> tuple[float, float]:
    """The least time along a path from rest to rest [s]: with jerk, and without.

    A straight path has a closed form. Where IPOPT does not converge the first figure is `nan`.
    """
    lengths, bounds = pieces_of(path, limits)
    if not len(lengths):
        return 0.0, 0.0
    if (np.ptp(bounds, axis=0) < 1e-6 * bounds.max(axis=0)).all():
        whole = float(lengths.sum())
        return double_s(whole, *map(float, bounds[0])), without_jerk(np.array([whole]), *bounds[:1, :2].T)
    corners = np.concatenate([[0.0], np.cumsum(lengths)])
    fine = np.unique(np.concatenate([corners, np.linspace(0, corners[-1], FINE)]))
    free = without_jerk(np.diff(fine), *_on(fine, corners, bounds)[:, :2].T)
    scale, unit = free, corners[-1]  # in these units the way, and the time without jerk, are 1
    corners, bounds = corners / unit, bounds * np.array([scale, scale**2, scale**3]) / unit
    for cells, haste in STARTS:
        found = _refined(corners, bounds, cells, haste)
        if np.isfinite(found):
            break
    return found * scale, free


def _refined(corners: Array, bounds: Array, cells: int, haste: float) -> float:
    """The least time, from a smooth first guess of a share of the speed; then with cells of about the same time."""
    tau = np.linspace(0, 1, cells + 1)
    speeds = haste * 48 * (tau * (1 - tau)) ** 2
    best, nodes, speeds = _with_jerk(
        *_grid(tau**3 * (10 - 15 * tau + 6 * tau**2), speeds, corners), corners, bounds
    )
    for _ in range(ROUNDS):
        if not np.isfinite(best):
            break
        times = np.concatenate([[0.0], np.cumsum(2 * np.diff(nodes) / (speeds[1:] + speeds[:-1]))])
        even = np.interp(np.linspace(0, times[-1], cells + 1), times, nodes)
        even[1], even[-2] = even[1] / 2, 1 - (1 - even[-2]) / 2
        found, nodes, speeds = _with_jerk(*_grid(even, np.interp(even, nodes, speeds), corners), corners, bounds)
        if not np.isfinite(found):
            break
        best = min(best, found)
    return best


def _grid(nodes: Array, speeds: Array, corners: Array) -> tuple[Array, Array]:
    """Nodes and all corners, those left out that lie near others; and a speed at each."""
    inner = nodes[1:-1]
    inner = inner[np.abs(inner[:, None] - corners).min(axis=1) > 0.2 / len(nodes) ** 2]
    found = np.unique(np.concatenate([corners, inner]))
    return found, np.interp(found, nodes, speeds)


def _on(nodes: Array, corners: Array, bounds: Array) -> Array:
    """The bounds (c, 3) of the cells between nodes."""
    middle = (nodes[1:] + nodes[:-1]) / 2
    return bounds[np.clip(np.searchsorted(corners, middle) - 1, 0, len(bounds) - 1)]


def _with_jerk(nodes: Array, speeds: Array, corners: Array, bounds: Array) -> tuple[float, Array, Array]:
    """The least time, the nodes, and the speeds at them; everything scaled so that way and time are about 1."""
    h, (v, a, j) = np.diff(nodes), _on(nodes, corners, bounds).T
    n, zero = len(h), np.zeros(1)
    inner_v, inner_a = np.minimum(v[:-1], v[1:]), np.minimum(a[:-1], a[1:])
    high = np.concatenate([np.full(n, 10.0), zero, inner_v, zero, zero, inner_a, zero, j])
    low = np.concatenate([np.full(n, 1e-7), zero, np.full(n - 1, 1e-7), zero, zero, -inner_a, zero, -j])
    speed = speeds.copy()
    speed[0] = speed[-1] = 0.0
    speed[1:-1] = np.clip(speed[1:-1], 1e-4, 0.95 * inner_v)
    start = np.concatenate([2 * h / (speed[1:] + speed[:-1]), speed, np.zeros(n + 1), np.zeros(n)])
    solver = _solver(n)
    found = solver(x0=start, lbx=low, ubx=high, lbg=0.0, ubg=0.0, p=h)
    time = float(found["f"]) if solver.stats()["success"] else float("nan")
    return time, nodes, np.array(found["x"]).ravel()[n : 2 * n + 1]


def line(path: Array, limits: dict[str, Array]) -> float:
    """The least time of the straight way from the beginning of a path to its end [s]."""
    return least(path[[0, -1]], limits)[0]
