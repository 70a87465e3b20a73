"""Two motions with unknown relative timing, as one path that visits every pair of their pieces.

A claim about a whole piece of this path is about the hull of all poses of each body in the piece, so it holds for
any moment of the first motion together with any moment of the second.
"""

import numpy as np

from kabo.arrays import Array
from kabo.verify.motion.overlaps import Meeting
from kabo.verify.motion.stretches import MotionStretch
from kabo.verify.motion.sweep import Path

MAX_WAYPOINTS = 50_000  # of such a path; longer ones are not checked


def stretch_of(meeting: Meeting, cut: int) -> MotionStretch | None:
    """A stretch that pairs each piece of the first path with each piece of the second; None if it is too long.

    Each piece of both paths is cut into `cut` equal parts. For each part of the first path the second path is
    passed once, alternately forward and backward, while the first goes back and forth along its part.
    """
    first, second = meeting.first.path, meeting.second.path
    counts = [cut * (len(path.configurations) - 1) for path in (first, second)]
    if (counts[0] + 1) * (counts[1] + 1) > MAX_WAYPOINTS:
        return None
    mine, theirs = _cut(first.configurations, cut), _cut(second.configurations, cut)
    order = list(range(counts[1] + 1))
    pairs: list[tuple[int, int]] = []
    for part in range(counts[0]):
        pairs += [(part + i % 2, k) for i, k in enumerate(order)]
        pairs += [(part + 1, order[-1])] if counts[1] % 2 == 0 else []
        order.reverse()
    rows = np.array(pairs).reshape(-1, 2)
    kept = np.concatenate([[True], (rows[1:] != rows[:-1]).any(axis=1)])
    whole = np.hstack([mine[rows[kept, 0]], theirs[rows[kept, 1]]])
    arms = (*first.arms.values(), *second.arms.values())
    path = Path(arms, whole, np.arange(len(whole), dtype=np.float64), _deviations(meeting, rows[kept], cut))
    things = [*meeting.first.things, *meeting.second.things]
    divide, before = len(meeting.first.things), meeting.first.segments
    return MotionStretch(meeting.node, meeting.second.segments, path, things, (), before=before, divide=divide)


def _deviations(meeting: Meeting, rows: Array, cut: int) -> Array:
    """The deviations of both motions on each step between two rows (M, 2) of numbers of their cut pieces."""
    found = []
    for path, own in zip((meeting.first.path, meeting.second.path), rows.T, strict=True):
        pieces = np.minimum(own[:-1], own[1:]) // cut
        here = path.deviations[np.minimum(pieces, len(path.deviations) - 1)]
        found.append(np.where((own[1:] == own[:-1])[:, None], 0.0, here))
    return np.hstack(found)


def _cut(configurations: Array, parts: int) -> Array:
    """The way points (M, n) with each piece cut into `parts` equal pieces."""
    places = np.arange((len(configurations) - 1) * parts + 1) / parts
    pieces = np.minimum(places.astype(np.int64), len(configurations) - 2)
    first, last = configurations[pieces], configurations[pieces + 1]
    return np.asarray(first + (places - pieces)[:, None] * (last - first))
