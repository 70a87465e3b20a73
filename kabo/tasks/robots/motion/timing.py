"""Times of motion: a node's or a solution's parts in groups that are passed without a stop, each with its trajectory.

Arms stop where something is attached, released or waited for; grippers move from rest to rest. What has its times
already keeps them.
"""

from collections.abc import Callable, Iterable, Sequence

from kabo.motion import MotionLimits, Trajectory, timed_path
from kabo.plan import Segment
from kabo.scene import Configuration, motion_limits
from kabo.tasks.robots.motion.insertions import inserts
from kabo.tasks.robots.motion.parts import MotionPart
from kabo.tasks.robots.motion.smoothing import AT_GOALS, deviation_of, smoothed
from kabo.tasks.robots.timed_paths import TIME_DECIMALS, TimedPath, cut

LEAST_SECONDS = 1e-6  # of a segment in which nothing moves: times of way points increase
JOINED = 1e-6  # rad or m: a part begins where the one before it ended


def groups_of(parts: Iterable[MotionPart], *, across: bool = True) -> list[list[MotionPart]]:
    """The parts, in groups between which the motion must stop; each part alone if not `across`."""
    groups: list[list[MotionPart]] = []
    for part in parts:
        if across and groups and _follows(groups[-1][-1], part):
            groups[-1].append(part)
        else:
            groups.append([part])
    return groups


def passing(part: MotionPart) -> bool:
    """Whether a part may follow another, or be followed, without a stop."""
    each = part.stretch
    settled = each.attach or each.detach or each.seconds or each.exact or each.timed is not None
    return each.group == "arm" and not settled and part.moves and not inserts(part)


def _follows(first: MotionPart, second: MotionPart) -> bool:
    if first.stretch.robot != second.stretch.robot or not (passing(first) and passing(second)):
        return False
    ends = zip(first.stretch.end, second.stretch.start, strict=True)
    return max(abs(a - b) for a, b in ends) <= JOINED


def timed_group(group: Sequence[MotionPart], limits: MotionLimits | None = None) -> tuple[TimedPath, ...]:
    """The motions of a group's parts, one after the other, from time 0 on.

    Args:
        group: parts that follow each other without a stop.
        limits: of the joints that move; None for those of the robot.

    Raises:
        ValueError: a joint that moves has no limits above 0.
    """
    first = group[0]
    if first.stretch.timed is not None:
        return (first.stretch.timed.beginning(0.0),)
    if first.stretch.seconds or len(first.rows) == 1:
        return (standing(first.joints, first.rows[0], first.stretch.seconds),)
    robot = first.scene.robot(first.stretch.robot)
    own = motion_limits(robot, first.joints) if limits is None else limits
    if not first.moves:
        return tuple(cut(timed_path(first.rows, own), first.joints, ()))
    return smoothed(group, own, deviation_of(group), first.held, AT_GOALS).parts


TimesOf = Callable[[Sequence[MotionPart]], tuple[TimedPath, ...]]  # as `timed_group`


def timed_segments(given: Sequence[tuple[MotionPart, Segment]], times_of: TimesOf = timed_group) -> list[Segment]:
    """Segments with trajectories, in the given order, each for its part; `times_of` makes those of each group.

    A part begins when all before it have ended, or as its stretch says (`since`).
    """
    made: list[Segment] = []
    groups, ended, begin = groups_of(part for part, _ in given), 0.0, 0.0
    for group in groups:
        since = group[0].stretch.since
        begin = ended if since is None else begin + since
        for timed in times_of(group):
            made.append(timed.beginning(begin + timed.times[0]).of(given[len(made)][1]))
        ended = max(ended, made[-1].times[-1])
    return made


def standing(joints: tuple[str, ...], row: Configuration, seconds: float) -> TimedPath:
    """Joints that keep their values for some time [s], from 0."""
    times = 0.0, max(round(seconds, TIME_DECIMALS), LEAST_SECONDS)
    still = tuple((value,) for value in row)
    return TimedPath(times, Trajectory(joints, (row, row), times, (still,)))
