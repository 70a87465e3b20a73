"""Paths with their times: all that a segment of a plan says of its motion."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from kabo.motion import Timed, Trajectory
from kabo.plan import Segment
from kabo.scene import Configuration

TIME_DECIMALS = 6  # decimals of times [s]


@dataclass(frozen=True)
class TimedPath:
    """A trajectory, and the times at which it passes the way points of its path [s]."""

    times: tuple[float, ...]
    trajectory: Trajectory

    @property
    def waypoints(self) -> tuple[Configuration, ...]:
        """The way points of the path, over the joints of the trajectory."""
        return self.trajectory.waypoints

    @property
    def seconds(self) -> float:
        """The duration [s]."""
        return self.times[-1] - self.times[0]

    def beginning(self, begin: float) -> "TimedPath":
        """The same motion, beginning at another time [s]."""
        by = round(begin - self.times[0], TIME_DECIMALS)
        if by == 0.0:
            return self
        return TimedPath(tuple(round(t + by, TIME_DECIMALS) for t in self.times), self.trajectory.shifted(by))

    def reversed(self) -> "TimedPath":
        """The motion back, in the same span of time."""
        ends = self.times[0] + self.times[-1]
        return TimedPath(
            tuple(round(ends - t, TIME_DECIMALS) for t in self.times[::-1]), self.trajectory.reversed()
        )

    def of(self, segment: Segment) -> Segment:
        """The segment with this motion; its joints are those of the trajectory."""
        return replace(segment, waypoints=self.waypoints, times=self.times, trajectory=self.trajectory)


def cut(made: Timed, joints: tuple[str, ...], corners: Sequence[int]) -> list[TimedPath]:
    """A motion cut at some of its corners; the times of all parts are counted from its beginning."""
    places = [0, *(made.corners[number] for number in corners), len(made.waypoints) - 1]
    parts = made.parts(joints, corners)
    ends = zip(places, places[1:], strict=False)
    return [TimedPath(made.passed(*pair), part) for pair, part in zip(ends, parts, strict=True)]
