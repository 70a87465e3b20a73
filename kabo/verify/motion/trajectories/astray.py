"""Refuses segments that lead so far away that looking for collisions along them would never end."""

from collections.abc import Iterator, Sequence

import numpy as np

from kabo.plan import Segment
from kabo.verify.motion.trajectories.judge import Followed
from kabo.verify.report import Finding

LONGEST_WAY = 1e3  # [rad or m] between two values of a joint in a segment
FARTHEST_ASTRAY = 10.0  # [rad or m] that a joint may be from its path where collisions are looked for


def check_astray(node: str, segments: Sequence[Segment], how: Sequence[Followed]) -> Iterator[Finding]:
    """The findings about trajectories too far from their paths, and about paths too long, for any proof."""
    for i, (segment, own) in enumerate(zip(segments, how, strict=True)):
        far = float(own.deviations.max(initial=0.0))
        long = float(np.ptp(np.asarray(segment.waypoints), axis=0).max(initial=0.0))
        if not far <= FARTHEST_ASTRAY:
            text = f"segment {i}: its trajectory is up to {far:.3g} rad or m from its path, too far for any proof"
            yield Finding(node, text, segment.times[0])
        if not long <= LONGEST_WAY:
            text = f"segment {i}: a joint moves by {long:.3g} rad or m, too far for any proof"
            yield Finding(node, text, segment.times[0])
