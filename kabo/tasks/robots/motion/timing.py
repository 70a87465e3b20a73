"""Times of motion: the trajectory of an arm or a gripper from rest to rest along a path, or where nothing moves."""

from collections.abc import Sequence
from functools import lru_cache

from kabo.motion import MotionLimits, Trajectory, timed_path
from kabo.scene import Configuration, Robot, motion_limits
from kabo.tasks.robots.timed_paths import TIME_DECIMALS, TimedPath, cut

LEAST_SECONDS = 1e-6  # of a segment in which nothing moves: times of way points increase
MAX_KEPT = 4096  # paths whose times are kept: solutions of a task share most of their motion


def rested(robot: Robot, joints: tuple[str, ...], rows: Sequence[Configuration]) -> TimedPath:
    """The fastest motion of some joints along way points (m, n) that rests at each of them, from 0.

    Raises:
        ValueError: a joint that moves has no limit of velocity above 0.
    """
    limits = motion_limits(robot, joints)
    return _rested(joints, tuple(rows), *(tuple(row.tolist()) for row in limits.rows))


@lru_cache(MAX_KEPT)
def _rested(
    joints: tuple[str, ...],
    rows: tuple[Configuration, ...],
    velocity: Configuration,
    acceleration: Configuration,
    jerk: Configuration,
) -> TimedPath:
    (made,) = cut(timed_path(rows, MotionLimits.of(velocity, acceleration, jerk)), joints, ())
    return made


def standing(joints: tuple[str, ...], row: Configuration, seconds: float) -> TimedPath:
    """Joints that keep their values for some time [s], from 0."""
    times = 0.0, max(round(seconds, TIME_DECIMALS), LEAST_SECONDS)
    still = tuple((value,) for value in row)
    return TimedPath(times, Trajectory(joints, (row, row), times, (still,)))
