"""Flat worlds for path planning: discs and boxes that a point must not touch, judged exactly and densely."""

from dataclasses import dataclass, field

import numpy as np

from kabo.ways import FreeSpace


@dataclass
class Discs:
    """Numbered discs in the plane; counts what it is asked."""

    centres: np.ndarray  # (D, 2)
    radii: np.ndarray  # (D,)
    segments: int = field(default=0)
    configurations: int = field(default=0)

    def free_segment(self, q0, q1):
        self.segments += 1
        d = q1 - q0
        square = d @ d
        share = np.clip(((self.centres - q0) @ d) / square, 0, 1) if square > 0 else np.zeros(len(self.centres))
        away = np.linalg.norm(q0 + share[:, None] * d - self.centres, axis=1)
        return first(away <= self.radii)

    def free_configurations(self, Q):
        self.configurations += len(Q)
        away = np.linalg.norm(Q[:, None] - self.centres, axis=2)
        return np.array([first(row <= self.radii) for row in away], np.int64)

    def space(self, looks=True, **more):
        """The discs as a search takes them."""
        configurations = self.free_configurations if looks else None
        return FreeSpace(configurations, self.free_segment, len(self.radii), **more)

    def clearance(self, path):
        """The least distance of densely sampled points of a path from any disc."""
        points = np.concatenate([np.linspace(a, b, 200) for a, b in zip(path, path[1:], strict=False)])
        return (np.linalg.norm(points[:, None] - self.centres, axis=2) - self.radii).min(initial=np.inf)


def first(hits):
    """The number of the first that is hit, or -1."""
    found = np.flatnonzero(hits)
    return int(found[0]) if len(found) else -1


def length(path):
    """The length of a path."""
    return np.linalg.norm(np.diff(path, axis=0), axis=1).sum()


def wall(gap=None, count=101, radius=0.04):
    """Discs from (0, -2) to (0, 2), with a gap of the given width about y = 1.2."""
    y = np.linspace(-2.1, 2.1, count)
    if gap is not None:
        y = y[np.abs(y - 1.2) > gap / 2]
    return Discs(np.stack([np.zeros_like(y), y], axis=1), np.full(len(y), radius))


LOWER, UPPER = np.array([-2.0, -2.0]), np.array([2.0, 2.0])
LEFT, RIGHT = np.array([-1.5, -1.0]), np.array([1.5, -1.0])
