"""Convex cells of a solid, each with segments whose convex hull contains the solid inside the cell.

A cell is represented by the boundary faces of its part of the solid, each face by its border segments, which run
around it in one direction. Cutting by a plane clips every segment, closes every face that crosses the plane with new
segments on the plane, and adds those segments, reversed, as a new face, the cut. Directions matter where components
overlap: between the crossings of two borders that both run upwards, a cut face lies in both. The hull of a cell's
points contains all of the solid inside the cell, since extreme points of a cut region lie on its border, and all
borders are kept. So the hulls of all cells cover the solid by construction. Rounding moves points by a few 1e-16 of
their size, much less than the margin of `kabo.geometry.bounding.containment`.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers

FIRST_CUT = 1 << 32  # the least face index of a cut


@dataclass(frozen=True)
class Cell:
    """The part of a solid inside a convex cell: border segments (S, 2, 3) [m], and the face index (S,) of each."""

    segments: Array
    faces: Integers

    @cached_property
    def points(self) -> Array:
        """The distinct end points of all segments (P, 3), in lexicographic order."""
        ends = self.segments.reshape(-1, 3)
        ends = ends[np.lexsort(ends.T[::-1])]  # several times as fast as numpy.unique of rows
        distinct = np.r_[True, (ends[1:] != ends[:-1]).any(axis=1)][: len(ends)]  # of none, none
        return np.asarray(ends[distinct])


def whole(vertices: Array, faces: Integers) -> Cell:
    """The whole mesh as one cell."""
    corners = vertices[faces]
    segments = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    return Cell(segments, np.repeat(np.arange(len(faces)), 3))


def of_faces(vertices: Array, faces: Integers, own: Integers) -> Cell:
    """Some faces of a mesh, given by their indices (F,), as one cell."""
    cell = whole(vertices, faces[own])
    return Cell(cell.segments, own[cell.faces])


def cut(cell: Cell, normal: Array, offset: float) -> tuple[Cell, Cell]:
    """The cells below and above the plane normal·x = offset; one of them may be empty."""
    segments = cell.segments
    # Elementwise, not by a matrix product: equal points must get equal signs, whatever their place in the array.
    height = segments[..., 0] * normal[0] + segments[..., 1] * normal[1] + segments[..., 2] * normal[2] - offset
    above = height >= 0.0
    crossing = above[:, 0] != above[:, 1]
    if not crossing.any():
        return _select(cell, ~above[:, 0]), _select(cell, above[:, 0])
    upward = above[crossing, 1]
    # From one end of the two, so that an edge of two faces is cut at equal points for both.
    swapped = _descends(segments[crossing])
    ends = np.where(swapped[:, None, None], segments[crossing][:, ::-1], segments[crossing])
    heights = np.where(swapped[:, None], height[crossing][:, ::-1], height[crossing])
    t = heights[:, 0] / (heights[:, 0] - heights[:, 1])
    points = ends[:, 0] + t[:, None] * (ends[:, 1] - ends[:, 0])
    border, owner = _borders(points, cell.faces[crossing], upward)
    halves = []
    for side in (False, True):
        clipped = segments[crossing].copy()
        outside = above[crossing] != side
        clipped[outside] = points
        inner = (above == side).all(axis=1)
        new_face = np.full(len(border), max(int(cell.faces.max()) + 1, FIRST_CUT))
        along = border[:, ::-1] if side else border
        halves.append(
            Cell(
                np.concatenate([segments[inner], clipped, along, along[:, ::-1]]),
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


def _descends(segments: Array) -> NDArray[np.bool_]:
    """Which segments (S, 2, 3) end before they begin, in lexicographic order."""
    first, second = segments[:, 0], segments[:, 1]
    swap = np.zeros(len(segments), bool)
    equal = np.ones(len(segments), bool)
    for axis in range(3):
        swap |= equal & (first[:, axis] > second[:, axis])
        equal &= first[:, axis] == second[:, axis]
    return swap


def _select(cell: Cell, chosen: NDArray[np.bool_]) -> Cell:
    return Cell(cell.segments[chosen], cell.faces[chosen])


def _borders(points: Array, owners: Integers, upward: NDArray[np.bool_]) -> tuple[Array, Integers]:
    """The segments in which faces cross the plane, and their faces: from where a border runs up to where one runs down.

    In order along the line, the first upward crossing is joined with the first downward one, and so on: every piece of
    the line that the border winds around, however often, lies on a segment. If rounding made the numbers of both
    unequal, one segment from the first to the last point replaces all: its hull is at least as large.
    """
    # The line of a face in the plane has any direction; the widest spread of its points orders them along it.
    order = np.argsort(2 * owners + ~upward, kind="stable")
    points, owners, upward = points[order], owners[order], upward[order]
    starts = np.flatnonzero(np.r_[True, owners[1:] != owners[:-1]])
    counts = np.diff(np.r_[starts, len(owners)])
    ups = np.add.reduceat(upward.astype(np.int64), starts)
    simple = np.flatnonzero((counts == 2) & (ups == 1))
    first = [points[starts[simple]]]
    second = [points[starts[simple] + 1]]
    owner = [owners[starts[simple]]]
    for group in np.flatnonzero((counts != 2) | (ups != 1)):
        mine, rising = points[starts[group] : starts[group] + counts[group]], int(ups[group])
        along = mine[:, int(np.argmax(np.ptp(mine, axis=0)))]
        if 2 * rising == len(mine):
            up = np.argsort(along[:rising], kind="stable")
            down = rising + np.argsort(along[rising:], kind="stable")
        else:
            up, down = np.array([np.argmin(along)]), np.array([np.argmax(along)])
        first.append(mine[up])
        second.append(mine[down])
        owner.append(np.full(len(up), owners[starts[group]]))
    return np.stack([np.concatenate(first), np.concatenate(second)], axis=1), np.concatenate(owner)
