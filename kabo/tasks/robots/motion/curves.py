"""Strokes as curves: a straight way of the tool is a smooth curve of the joints, of which way points are samples."""

from collections.abc import Sequence

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import LINE_DEVIATION, LINE_TILT, candidate, line, tool_frame
from kabo.motion import natural_slopes, smooth_knots
from kabo.tasks.robots.motion.parts import JOINT_DECIMALS, MotionPart
from kabo.tasks.robots.motion.tool_lines import tool_line

LEAST_KNOTS, MOST_KNOTS = 6, 16  # pieces of a curve
FINER = 0.1  # share of a line's deviation and tilt within which finer samples stay
SAME_END = 5e-3  # rad or m by which a line that is followed anew may end elsewhere
LEAST_LENGTH = 1e-3  # [rad, L2] of a curve


def curves_of(parts: Sequence[MotionPart]) -> frozenset[int]:
    """The numbers of the parts that are straight strokes of the tool, and curves of the joints."""
    return frozenset(number for number, part in enumerate(parts) if _is_curve(part))


def _is_curve(part: MotionPart) -> bool:
    if part.stretch.group != "arm" or part.stretch.exact or len(part.rows) < 3:
        return False
    key = "curve", part.stretch.robot, part.joints, part.stretch.path.tobytes()
    found: tuple[bool] = part.scene.context.surroundings.remembered(key, lambda: (_is_smooth(part),))
    return found[0]


def _is_smooth(part: MotionPart) -> bool:
    path = np.array(part.rows)
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    return (
        float(lengths.sum()) > LEAST_LENGTH
        and tool_line(part, backward=False) is not None
        and _within_limits(part)
    )


def _within_limits(part: MotionPart) -> bool:
    """Whether the curve keeps the limits of joints: way points on a limit leave it no room. Control points are its hull."""
    knots = np.concatenate([np.array(part.rows)[:1], knots_of(part)])
    slopes = natural_slopes(knots)
    thirds = np.linalg.norm(np.diff(knots, axis=0), axis=1)[:, None] / 3.0
    hull = np.concatenate([knots, knots[:-1] + thirds * slopes[:-1], knots[1:] - thirds * slopes[1:]])
    tree = part.scene.robot(part.stretch.robot).tree
    return bool((hull >= tree.lower[part.columns]).all() and (hull <= tree.upper[part.columns]).all())


def knots_of(part: MotionPart, samples: Array | None = None) -> Array:
    """The knots (k, n) of the curve that a part is, after its beginning; `samples` (m, n) are its way points by default."""
    if samples is not None:
        return _knots(samples)
    key = "knots", part.stretch.robot, part.joints, part.stretch.path.tobytes()
    found: Array = part.scene.context.surroundings.remembered(key, lambda: _knots(np.array(part.rows)))
    return found


def _knots(path: Array) -> Array:
    count = min(max(2 * (len(path) - 1), LEAST_KNOTS), MOST_KNOTS)
    return np.round(smooth_knots(path, count)[1:], JOINT_DECIMALS) + 0.0


def finer_samples(part: MotionPart) -> Array | None:
    """More samples (m, n) of the curve that a part is than its way points; None if they are enough, or none are found.

    Few way points bend a spline away from the line of the tool. The ends are the part's own. Nothing is assumed of what
    lies between: the motion along it is proven afterwards.
    """
    path, whole = np.array(part.rows), part.stretch.path
    if len(path) > MOST_KNOTS:
        return None
    for order in (slice(None), slice(None, None, -1)):  # an approach was made from its end
        finer = _followed(part, whole[order])
        if finer is not None and len(finer) > len(path):
            return np.concatenate([path[:1], finer[order][1:-1, part.columns], path[-1:]])
    return None


def _followed(part: MotionPart, whole: Array) -> Array | None:
    """Fine samples (m, n) of the tool's line from the first configuration to the last; None if it ends elsewhere."""
    robot = part.scene.robot(part.stretch.robot)
    tool = tool_frame(robot)
    first, last = (candidate(robot, q).pose(tool)[:3, 3] for q in whole[[0, -1]])
    followed = line(robot, whole[0], tool, last - first, LINE_DEVIATION * FINER, LINE_TILT * FINER)
    if followed is None:
        return None
    finer = np.array(followed)
    missing = whole[-1] - finer[-1]
    if np.abs(missing).max() > SAME_END:
        return None
    # A redundant arm drifts a little: the difference is spread over the samples.
    return np.asarray(finer + np.linspace(0.0, 1.0, len(finer))[:, None] * missing)


def slopes_of(corners: Array, owners: Sequence[int], curves: frozenset[int]) -> Array:
    """The slopes (m - 1, 2, n) of a path with corners (m, n) where each piece begins and ends: splines on curves.

    `owners` are the numbers of the parts to which pieces belong.
    """
    steps = np.diff(corners, axis=0)
    units = steps / np.linalg.norm(steps, axis=1)[:, None]
    found = np.stack([units, units], axis=1)
    for number in curves:
        own = np.flatnonzero(np.asarray(owners) == number)
        if len(own) > 1:
            slopes = natural_slopes(corners[own[0] : own[-1] + 2])
            found[own, 0], found[own, 1] = slopes[:-1], slopes[1:]
    return found
