"""Judges the trajectory of one segment: its form, limits, continuity, and how far it leaves its path."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite

import numpy as np

from kabo.arrays import Array
from kabo.plan import Segment
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.trajectories.curves import Curve, curve_of, values
from kabo.verify.motion.trajectories.deviations import ROUNDING, Deviations, from_path
from kabo.verify.motion.trajectories.extremes import greatest, outside
from kabo.verify.motion.trajectories.figures import TrajectoryFigures
from kabo.verify.motion.trajectories.robot_limits import KINDS, joint_limits, unit_of
from kabo.verify.report import Finding
from kabo.verify.trajectory_report import GreatestDeviation, LimitUse

MAX_COEFFICIENTS = 6  # of a polynomial of degree 5
LONGEST = 1e30  # [s] beyond which a piece counts as so long: powers of it are still numbers
FARTHEST = 1e6  # [rad or m] that one power may lead in its piece; no motion, and beyond it numbers overflow


@dataclass(frozen=True, eq=False)
class Followed:
    """How a segment is followed: its curve, and its deviations (m - 1, n) from the pieces of its path."""

    curve: Curve
    deviations: Array
    given: bool  # whether the plan has a trajectory for it


def followed(segment: Segment) -> Followed:
    """The curve and deviations of a segment whose form is right; without trajectory its path, exactly."""
    curve, rows = curve_of(segment), np.asarray(segment.waypoints, np.float64)
    if segment.trajectory is None:
        return Followed(curve, np.zeros((len(rows) - 1, rows.shape[1])), False)
    return Followed(curve, _found(segment, curve, rows).bounds, True)


def _found(segment: Segment, curve: Curve, rows: Array) -> Deviations:
    assert segment.trajectory is not None
    found = from_path(curve, rows, np.asarray(segment.times, np.float64), segment.trajectory.deviation)
    still = np.ptp(rows, axis=0) == 0.0
    # The path of a joint that stands still is rounded in the plan.
    return found._replace(bounds=np.where(still & (found.bounds <= ROUNDING), 0.0, found.bounds))


def check_form(node: str, number: int, segment: Segment) -> Iterator[Finding]:
    """A finding if a segment's trajectory is no sequence of polynomials over its time, for its joints and path."""
    given = segment.trajectory
    if given is None:
        return
    wrong = _malformed(segment)
    if wrong is not None:
        yield Finding(node, f"segment {number}: {wrong}", segment.times[0])


def _malformed(segment: Segment) -> str | None:
    given = segment.trajectory
    assert given is not None
    if given.joints != segment.joints or given.waypoints != segment.waypoints:
        return "its trajectory is for other joints or another path"
    times = np.asarray(given.times, np.float64)
    if len(times) < 2 or len(times) != len(given.coefficients) + 1:
        return f"its trajectory has {len(given.coefficients)} pieces and {len(times)} times"
    if not np.isfinite(times).all() or (np.diff(times) <= 0.0).any():
        return "the times of its trajectory do not increase"
    if max(abs(times[0] - segment.times[0]), abs(times[-1] - segment.times[-1])) > ROUNDING:
        span = f"{times[0]:g} to {times[-1]:g} s"
        return f"its trajectory lasts from {span}, it lasts from {segment.times[0]:g} to {segment.times[-1]:g} s"
    if not (np.isfinite(given.deviation) and given.deviation >= 0.0):
        return f"its trajectory states a deviation of {given.deviation}"
    for k, piece in enumerate(given.coefficients):
        if len(piece) != len(segment.joints):
            return f"piece {k} of its trajectory has {len(piece)} polynomials for {len(segment.joints)} joints"
        if not all(1 <= len(own) <= MAX_COEFFICIENTS and all(map(isfinite, own)) for own in piece):
            return f"piece {k} of its trajectory has no 1 to {MAX_COEFFICIENTS} finite coefficients for each joint"
        lasts = min(float(times[k + 1] - times[k]), LONGEST)
        if any(abs(c) * lasts**power > FARTHEST for own in piece for power, c in enumerate(own)):
            return f"piece {k} of its trajectory leads farther than {FARTHEST:g} rad or m"
    return None


@dataclass(frozen=True)
class SegmentJudge:
    """The check of one segment that has a trajectory, whose form is right."""

    node: str
    number: int
    segment: Segment
    arm: Arm
    figures: TrajectoryFigures

    def check(self, how: Followed) -> Iterator[Finding]:
        """The findings about the segment's ends, deviation, limits, and continuity between its pieces."""
        self.figures.followed += how.given
        self.figures.without += not how.given
        if not how.given:
            return
        yield from self._check_ends(how.curve)
        yield from self._check_deviation(how)
        yield from self._check_positions(how.curve)
        yield from self._check_limits(how.curve)
        yield from self._check_continuity(how.curve)

    # -------------------------------------------------------------------------------------------- beside the path
    def _check_ends(self, curve: Curve) -> Iterator[Finding]:
        rows = np.asarray(self.segment.waypoints)[[0, -1]]
        off = np.abs(curve.at(curve.times[[0, -1]]) - rows)
        k, j = _worst(off)
        if off[k, j] > ROUNDING * (1.0 + 1e-6):
            where = ("begins", "ends")[k]
            text = f"the trajectory of {self._joint(j)} {where} {off[k, j]:.3g} {self._unit(j)} from its path"
            yield self._finding(text, float(curve.times[-k]), float(off[k, j]))

    def _check_deviation(self, how: Followed) -> Iterator[Finding]:
        assert self.segment.trajectory is not None
        piece, j = _worst(how.deviations)
        found, stated = float(how.deviations[piece, j]), self.segment.trajectory.deviation
        time = self.segment.times[piece]
        self.figures.deviate(GreatestDeviation(found, self._joint(j), self.node, time))
        if found > stated * (1.0 + ROUNDING) + ROUNDING:
            text = f"the trajectory of {self._joint(j)} leaves its path by up to {found:.6g} {self._unit(j)}"
            yield self._finding(f"{text}, its stated deviation is {stated:.6g}", time, found - stated)

    # -------------------------------------------------------------------------------------------------- limits
    def _check_positions(self, curve: Curve) -> Iterator[Finding]:
        limits, index = joint_limits(self.arm.robot), self._index
        low, high = limits.lower[index], limits.upper[index]
        worst = outside(curve, low, high)
        if worst is not None:
            unit, j = self._unit(worst.joint), worst.joint
            text = (
                f"{self._joint(j)} reaches {worst.value:.9g} {unit}, its limits are {low[j]:.9g} and {high[j]:.9g}"
            )
            yield self._finding(f"{text} {unit}", worst.time, worst.share - 1.0)

    def _check_limits(self, curve: Curve) -> Iterator[Finding]:
        for k, (kind, all_limits) in enumerate(zip(KINDS, joint_limits(self.arm.robot).derivatives, strict=True)):
            limits = all_limits[self._index]
            worst = greatest(curve, k + 1, limits, self.figures.share(kind))
            limit, name = float(limits[worst.joint]), self._joint(worst.joint)
            if np.isfinite(limit):
                self.figures.use(LimitUse(kind, worst.share, worst.value, limit, name, self.node, worst.time))
            if worst.too_much:
                unit = self._unit(worst.joint, k + 1)
                article = "an" if kind == "acceleration" else "a"
                text = (
                    f"{name} reaches {article} {kind} of {worst.value:.6g} {unit}, its limit is {limit:.6g} {unit}"
                )
                yield self._finding(text, worst.time, worst.value - limit)

    # ---------------------------------------------------------------------------------------------- continuity
    def _check_continuity(self, curve: Curve) -> Iterator[Finding]:
        for order in range(3):
            ends = _ends(curve, order)
            jumps = np.abs(ends[1][:-1] - ends[0][1:])
            if jumps.size and jumps.max() > ROUNDING:
                k, j = _worst(jumps)
                text = f"the {('position', *KINDS)[order]} of {self._joint(j)} jumps"
                how = f"by {jumps[k, j]:.3g} {self._unit(j, order)} between two pieces"
                yield self._finding(f"{text} {how}", float(curve.times[k + 1]), float(jumps[k, j]))

    # ---------------------------------------------------------------------------------------------------- words
    @property
    def _index(self) -> list[int]:
        return [self.arm.robot.joint_names.index(joint) for joint in self.segment.joints]

    def _joint(self, j: int) -> str:
        return f"{self.segment.robot}.{self.segment.joints[j]}"

    def _unit(self, j: int, order: int = 0) -> str:
        return unit_of(self.arm, self._index[j], order)

    def _finding(self, text: str, time: float, depth: float) -> Finding:
        return Finding(self.node, f"segment {self.number}: {text}", time, (), depth)


def _worst(found: Array) -> tuple[int, int]:
    """The row and the column of the greatest entry."""
    row, column = divmod(int(found.argmax()), found.shape[1])
    return row, column


def _ends(curve: Curve, order: int) -> tuple[Array, Array]:
    """The values (K, n) of each piece at its beginning and at its end."""
    lengths = np.diff(curve.times)
    return values(curve.powers, np.zeros(len(lengths)), order), values(curve.powers, lengths, order)
