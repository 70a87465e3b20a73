"""Judges where the segments of a node follow each other: what must rest there, and what must go on without a jump."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from kabo.plan import Segment
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.trajectories.curves import Curve
from kabo.verify.motion.trajectories.deviations import ROUNDING
from kabo.verify.motion.trajectories.judge import Followed
from kabo.verify.motion.trajectories.robot_limits import KINDS, unit_of
from kabo.verify.report import Finding


def check_borders(
    node: str, segments: Sequence[Segment], curves: Sequence[Followed], arms: Mapping[str, Arm]
) -> Iterator[Finding]:
    """The findings about segments that follow each other: what does not rest or is not continuous.

    A robot must rest where its motion begins and ends, at gaps in time, between motions of its arm and its hand, and
    where a segment attaches or detaches something; elsewhere position, velocity and acceleration go on without a jump.
    """
    order = sorted(range(len(segments)), key=lambda i: segments[i].times[0])
    for robot in dict.fromkeys(segments[i].robot for i in order):
        own = [i for i in order if segments[i].robot == robot]
        for before, after in zip([None, *own], [*own, None], strict=True):
            yield from _check_border(node, before, after, segments, curves, arms[robot])


def _check_border(node, before, after, segments, curves, arm) -> Iterator[Finding]:  # type: ignore[no-untyped-def]
    ends = [(i, at_end) for i, at_end in ((before, True), (after, False)) if i is not None and curves[i].given]
    reason = _reason_to_rest(before, after, segments)
    if reason is not None:
        for i, at_end in ends:
            time = float(curves[i].curve.times[-1 if at_end else 0])
            yield from check_rest(node, i, segments[i], curves[i].curve, arm, time, reason)
    elif len(ends) == 2:
        first, second = curves[before].curve, curves[after].curve
        time = float(second.times[0])
        for kind in range(3):
            jumps = np.abs(first.at(first.times[-1:], kind) - second.at(second.times[:1], kind))[0]
            j = int(jumps.argmax())
            if jumps[j] > ROUNDING:
                what = f"the {('position', *KINDS)[kind]} of {arm.robot.name}.{segments[after].joints[j]} jumps"
                size = f"by {jumps[j]:.3g} {unit_of(arm, arm.robot.joint_names.index(segments[after].joints[j]), kind)}"
                yield Finding(node, f"segment {after}: {what} {size} where it begins", time, (), float(jumps[j]))


def _reason_to_rest(before: int | None, after: int | None, segments: Sequence[Segment]) -> str | None:
    """Why a robot must rest between two of its segments; None if it need not."""
    if before is None:
        return "where its motion begins"
    if after is None:
        return "where its motion ends"
    first, second = segments[before], segments[after]
    if second.times[0] - first.times[-1] > ROUNDING:
        return "where its motion pauses"
    if first.joints != second.joints:
        return "between a motion of its arm and one of its hand"
    return "where something is attached or detached" if first.attach or first.detach else None


def check_rest(
    node: str, number: int, segment: Segment, curve: Curve, arm: Arm, time: float, reason: str
) -> Iterator[Finding]:
    """A finding unless the velocity and the acceleration of a segment's joints are 0 at a time [s]."""
    for order in (1, 2):
        found = np.abs(curve.at(np.array([time]), order)[0])
        j = int(found.argmax())
        if found[j] > ROUNDING:
            unit = unit_of(arm, arm.robot.joint_names.index(segment.joints[j]), order)
            what = f"{segment.robot}.{segment.joints[j]} has {'an' if order == 2 else 'a'} {KINDS[order - 1]}"
            text = f"segment {number}: {what} of {found[j]:.3g} {unit} {reason}, where it must rest"
            yield Finding(node, text, time, (), float(found[j]))
            return
