"""Convex cells of a solid, each with segments whose convex hull contains the solid inside the cell.

A cell is represented by the boundary faces of its part of the solid, each face by its border segments. Cutting by
a plane clips every segment, closes every face that crosses the plane with new segments on the plane, and adds
those segments again as a new face, the cut. The hull of a cell's points contains all of the solid inside the cell,
since extreme points of a cut region lie on its border, and all borders are kept. So the hulls of all cells cover
the solid by construction. Rounding moves points by a few 1e-16 of their size, much less than the margin of
`kabo.geometry.bounding.containment`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers


@dataclass(frozen=True)
class Cell:
    """The part of a solid inside a convex cell: border segments (S, 2, 3) [m], and the face index (S,) of each."""

    segments: Array
    faces: Integers

    @property
    def points(self) -> Array:
        """The distinct end points of all segments (P, 3)."""
        return np.unique(self.segments.reshape(-1, 3), axis=0)


def whole(vertices: Array, faces: Integers) -> Cell:
    """The whole mesh as one cell."""
    corners = vertices[faces]
    segments = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    return Cell(segments, np.repeat(np.arange(len(faces)), 3))


def cut(cell: Cell, normal: Array, offset: float) -> tuple[Cell, Cell]:
    """The cells below and above the plane normal·x = offset; one of them may be empty."""
    segments = _in_one_direction(cell.segments)
    # Elementwise, not by a matrix product: equal points must get equal signs, whatever their place in the array.
    height = segments[..., 0] * normal[0] + segments[..., 1] * normal[1] + segments[..., 2] * normal[2] - offset
    above = height >= 0.0
    crossing = above[:, 0] != above[:, 1]
    if not crossing.any():
        return _select(cell, ~above[:, 0]), _select(cell, above[:, 0])
    low, high = segments[crossing, 0], segments[crossing, 1]
    t = height[crossing, 0] / (height[crossing, 0] - height[crossing, 1])
    points = low + t[:, None] * (high - low)
    border, owner = _borders(points, cell.faces[crossing])
    halves = []
    for side in (False, True):
        clipped = segments[crossing].copy()
        outside = above[crossing] != side
        clipped[outside] = points
        inner = (above == side).all(axis=1)
        new_face = np.full(len(border), cell.faces.max() + 1)
        halves.append(
            Cell(
                np.concatenate([segments[inner], clipped, border, border]),
                np.concatenate([cell.faces[inner], cell.faces[crossing], owner, new_face]),
            )
        )
    return halves[0], halves[1]


def inside_planes(cell: Cell, planes: Array) -> Cell:
    """What of a cell lies behind all planes (H, 4), n·x <= d."""
    for plane in planes:
        if not len(cell.segments):
            break
        cell = cut(cell, plane[:3], float(plane[3]))[0]
    return cell


def _in_one_direction(segments: Array) -> Array:
    """The segments with their ends in lexicographic order, so that shared edges are cut at equal points."""
    first, second = segments[:, 0], segments[:, 1]
    swap = np.zeros(len(segments), bool)
    equal = np.ones(len(segments), bool)
    for axis in range(3):
        swap |= equal & (first[:, axis] > second[:, axis])
        equal &= first[:, axis] == second[:, axis]
    result: Array = segments.copy()
    result[swap] = segments[swap, ::-1]
    return result


def _select(cell: Cell, chosen: NDArray[np.bool_]) -> Cell:
    return Cell(cell.segments[chosen], cell.faces[chosen])


def _borders(points: Array, owners: Integers) -> tuple[Array, Integers]:
    """The segments in which faces cross the plane: crossing points in order along the line, taken in pairs.

    A closed border has an even number of crossings. If rounding made it odd, one segment from the first to the
    last point replaces all: its hull is at least as large.
    """
    # The line of a face in the plane has any direction; the widest spread of its points orders them along it.
    order = np.argsort(owners, kind="stable")
    points, owners = points[order], owners[order]
    starts = np.flatnonzero(np.r_[True, owners[1:] != owners[:-1]])
    counts = np.diff(np.r_[starts, len(owners)])
    simple = np.flatnonzero(counts == 2)
    first = [points[starts[simple]]]
    second = [points[starts[simple] + 1]]
    owner = [owners[starts[simple]]]
    for group in np.flatnonzero(counts > 2):
        mine = points[starts[group] : starts[group] + counts[group]]
        spread = mine.max(axis=0) - mine.min(axis=0)
        line = mine[np.argsort(mine[:, int(np.argmax(spread))], kind="stable")]
        if len(line) % 2:
            line = line[[0, -1]]
        first.append(line[0::2])
        second.append(line[1::2])
        owner.append(np.full(len(line) // 2, owners[starts[group]]))
    return np.stack([np.concatenate(first), np.concatenate(second)], axis=1), np.concatenate(owner)
