"""Test whether two triangles of one mesh cross, that is, meet outside the vertices that they share.

"Apart" is proven: by an axis whose gap exceeds its own rounding bound, or, where no axis is clear, by exact signs
(kabo.geometry.triangles.kernels.orientation). So is "cross", except that triangles without area cross unless an
axis separates them. Vertices are shared by index, not by place: two triangles that merely touch do meet.

A pair is (6, 3) f8: one triangle in rows 0 to 2, the other in rows 3 to 5; shared vertices come first in both, in the
same order. In `scratch`, (SCRATCH,) f8, three numbers make a vector: 0 to 5 are the points seen from the first one.
"""

import numpy as np

from kabo.compilation import lean_kernel, window
from kabo.geometry.triangles.kernels.orientation import SCRATCH_SIZE, likely_orientation, orientation

_EDGES, _NORMALS, _OFFSET, _AXIS, _OTHER = 6, 12, 14, 15, 16  # vectors in scratch: 6, 2, 1, 1, 1 of them
# The axes of disjoint triangles: v, w and where v x w goes (v itself if v is w). First normals, and normals of edges in
# the planes; then, for two triangles without area, what parts two lines.
_AXES = np.array(
    [(12, 12, 15), (13, 13, 15)]
    + [(12 + i // 3, 6 + i, 15) for i in range(6)]
    + [row for e in (6, 7, 8) for f in (9, 10, 11) for row in ((e, f, 15), (15, e, 16), (15, f, 16))]
    + [row for e in range(6, 12) for row in ((e, e, 15), (e, 14, 15), (15, e, 16))]
    + [(14, 14, 15)]
)
_AXES_WITH_AREA = 8  # the first so many axes need triangles with an area
_SIZE_PLACE = 60  # in scratch: the largest coordinate
_SEEN_PLACE = SCRATCH_SIZE - 12  # in scratch: four points, behind all that `orientation` writes
_GAP_ROUNDING = 2.0**-49  # of a gap, relative: 16 u, while differences, three products and their sums cost 10 u
_UNDERFLOW = 1e-290  # a bound of underflow


@lean_kernel  # (6, 3) f8, i8, i8, i8, i8, (SCRATCH,) f8 -> i8
def _turn(pair, axis, a, b, c, scratch):
    """The exact sign of the turn of a, b, c seen along a coordinate axis, 0 if they are on a line.

    That is the side of these corners, at height 0, on which a point at height 1 lies.
    """
    x, y = (axis + 1) % 3, (axis + 2) % 3
    seen = window(scratch, _SEEN_PLACE, (4, 3))
    seen[0, 0], seen[0, 1], seen[0, 2] = pair[a, x], pair[a, y], 0.0
    seen[1, 0], seen[1, 1], seen[1, 2] = pair[b, x], pair[b, y], 0.0
    seen[2, 0], seen[2, 1], seen[2, 2] = pair[c, x], pair[c, y], 0.0
    seen[3, 0], seen[3, 1], seen[3, 2] = pair[a, x], pair[a, y], 1.0
    return orientation(seen, 0, 1, 2, 3, scratch)


@lean_kernel  # (6, 3) f8, i8, (SCRATCH,) f8 -> i8
def _clear_axis(pair, t, scratch):
    """A coordinate axis along which the triangle from row t on has an area, or -1."""
    for axis in range(3):
        if _turn(pair, axis, t, t + 1, t + 2, scratch) != 0:
            return axis
    return -1


@lean_kernel  # (6, 3) f8, i8, i8, i8, (SCRATCH,) f8 -> bool
def _segment_meets(pair, p, q, t, scratch):
    """Whether the closed segment p, q meets the closed triangle from row t on, exactly; False if that has no area."""
    first, second = orientation(pair, t, t + 1, t + 2, p, scratch), orientation(pair, t, t + 1, t + 2, q, scratch)
    if first * second > 0:
        return False
    axis, turn = -1, 1
    if first == 0 and second == 0:  # all in one plane
        axis = _clear_axis(pair, t, scratch)
        if axis < 0:
            return False
        turn = _turn(pair, axis, t, t + 1, t + 2, scratch)
    left, right = 0, 0
    for i in range(3):
        a, b = t + i, t + (i + 1) % 3
        if axis < 0:
            s = orientation(pair, p, q, a, b, scratch)  # the line p, q passes edge a, b
        else:
            s = _turn(pair, axis, p, q, a, scratch)  # corner a beside the line p, q
            outside = _turn(pair, axis, a, b, p, scratch) == -turn
            if outside and _turn(pair, axis, a, b, q, scratch) == -turn:
                return False
        left += s > 0
        right += s < 0
    return (left < 3 and right < 3) if axis >= 0 else (left == 0 or right == 0)


@lean_kernel  # (6, 3) f8 -> bool
def _boxes_apart(pair):
    for k in range(3):
        if max(pair[0, k], pair[1, k], pair[2, k]) < min(pair[3, k], pair[4, k], pair[5, k]):
            return True
        if max(pair[3, k], pair[4, k], pair[5, k]) < min(pair[0, k], pair[1, k], pair[2, k]):
            return True
    return False


@lean_kernel  # (6, 3) f8 -> writes (SCRATCH,) f8
def _vectors(pair, scratch):
    """Writes the points seen from the first one, the edges, the normals, the offset of the triangles, and the size."""
    size = 0.0
    for i in range(18):
        scratch[i] = pair[i // 3, i % 3] - pair[0, i % 3]
        size = max(size, abs(scratch[i]))
    for i in range(6):
        following = i + 1 if i % 3 < 2 else i - 2
        for k in range(3):
            scratch[3 * (_EDGES + i) + k] = scratch[3 * following + k] - scratch[3 * i + k]
    for k in range(3):
        for t in range(2):
            e, f, u, v = 18 + 9 * t, 21 + 9 * t, (k + 1) % 3, (k + 2) % 3
            scratch[36 + 3 * t + k] = scratch[e + u] * scratch[f + v] - scratch[e + v] * scratch[f + u]
        scratch[3 * _OFFSET + k] = scratch[9 + k] + scratch[12 + k] - scratch[3 + k]
    scratch[_SIZE_PLACE] = size


@lean_kernel  # (SCRATCH,) f8, i8, i8, i8, i8 -> bool
def _apart(scratch, v, w, target, shared):
    """Whether both triangles are proven apart along v x w (along v if v is w), which is written to `target`.

    With a shared vertex, which is the origin, the others must lie beyond it on opposite sides.
    """
    x, y, z = scratch[3 * v], scratch[3 * v + 1], scratch[3 * v + 2]
    if v != w:
        a, b, c = scratch[3 * w], scratch[3 * w + 1], scratch[3 * w + 2]
        x, y, z = y * c - z * b, z * a - x * c, x * b - y * a
    scratch[3 * target], scratch[3 * target + 1], scratch[3 * target + 2] = x, y, z
    low, high, other_low, other_high = np.inf, -np.inf, np.inf, -np.inf
    for i in range(shared, 3):
        value = x * scratch[3 * i] + y * scratch[3 * i + 1] + z * scratch[3 * i + 2]
        other = x * scratch[3 * i + 9] + y * scratch[3 * i + 10] + z * scratch[3 * i + 11]
        low, high, other_low, other_high = (
            min(low, value),
            max(high, value),
            min(other_low, other),
            max(other_high, other),
        )
    needed = _GAP_ROUNDING * (abs(x) + abs(y) + abs(z)) * scratch[_SIZE_PLACE] + _UNDERFLOW
    if shared == 0:
        return other_low - high > needed or low - other_high > needed
    return (other_low > needed and high < -needed) or (low > needed and other_high < -needed)


@lean_kernel  # (6, 3) f8, (SCRATCH,) f8 -> bool
def _disjoint_cross(pair, scratch):
    """As `triangles_cross` for no shared vertex."""
    flat = 0
    for i in range(_AXES.shape[0]):
        if i == _AXES_WITH_AREA:  # few pairs get here
            for corner in range(6):
                following = corner + 1 if corner % 3 < 2 else corner - 2
                if _segment_meets(pair, corner, following, 3 - 3 * (corner // 3), scratch):
                    return True
                flat += corner % 3 == 0 and _clear_axis(pair, corner, scratch) < 0
            if flat < 2:
                return False
            _vectors(pair, scratch)
        if _apart(scratch, _AXES[i, 0], _AXES[i, 1], _AXES[i, 2], 0):
            return False
    return True


@lean_kernel  # (6, 3) f8, (SCRATCH,) f8 -> bool
def _vertex_cross(pair, scratch):
    """As `triangles_cross` for one shared vertex: they meet elsewhere where an edge opposite to it meets the other."""
    # In one plane a line between two neighbouring sides parts the triangles.
    for i in range(8):
        a, b = 3 * (1 + i % 2), 3 * (4 + (i // 2) % 2)
        length = scratch[a] * scratch[a] + scratch[a + 1] * scratch[a + 1] + scratch[a + 2] * scratch[a + 2]
        other = scratch[b] * scratch[b] + scratch[b + 1] * scratch[b + 1] + scratch[b + 2] * scratch[b + 2]
        share = np.sqrt(length / other)
        for k in range(3):
            scratch[3 * _AXIS + k] = scratch[a + k] + share * scratch[b + k]
        if _apart(scratch, _NORMALS + i // 4, _AXIS, _OTHER, 1):
            return False
    for t in range(0, 6, 3):
        if _clear_axis(pair, t, scratch) < 0 or _segment_meets(pair, t + 1, t + 2, 3 - t, scratch):
            return True
    return False


@lean_kernel  # (6, 3) f8, (SCRATCH,) f8 -> bool
def _edge_cross(pair, scratch):
    """As `triangles_cross` for a shared edge: they meet elsewhere if one is folded flat onto the other."""
    if orientation(pair, 0, 1, 2, 5, scratch) != 0:
        return False
    turn, flat = 0, True
    for axis in range(3):
        first, second = _turn(pair, axis, 0, 1, 2, scratch), _turn(pair, axis, 0, 1, 5, scratch)
        turn = first * second if turn == 0 else turn
        flat = flat and first == 0 and second == 0
    # A triangle on the line of the edge meets one with an area in the edge alone.
    return turn > 0 or flat


@lean_kernel  # (6, 3) f8 [m], i8, (SCRATCH,) f8 -> bool
def triangles_cross(pair, shared, scratch):
    """Whether two triangles meet elsewhere than in their `shared` (0 to 3) common vertices and the edge between them."""
    if shared > 2:
        return True
    if shared > 0:
        # The usual case: one lies on one side of the other's plane, but for what they share.
        for t in range(0, 6, 3):
            side = likely_orientation(pair, t, t + 1, t + 2, 3 - t + shared)
            if side != 0 and (shared == 2 or side == likely_orientation(pair, t, t + 1, t + 2, 5 - t)):
                return False
    if shared == 0 and _boxes_apart(pair):
        return False
    _vectors(pair, scratch)
    if shared == 0:
        return _disjoint_cross(pair, scratch)
    if shared == 1:
        return _vertex_cross(pair, scratch)
    # They open by more than a right angle; rounding takes at most 150 u of these sizes.
    spread, sizes = 0.0, 1.0
    for k in range(3):
        spread += scratch[36 + k] * scratch[39 + k]
    for i in range(4):
        e = 18 + 3 * i + (3 if i > 1 else 0)  # both edges of either triangle that make its normal
        sizes *= max(abs(scratch[e]), abs(scratch[e + 1]), abs(scratch[e + 2]))
    return spread >= -(2.0**-45) * sizes - _UNDERFLOW and _edge_cross(pair, scratch)


@lean_kernel  # (V, 3) f8 [m], i8 x 6, (6, 3) f8, (SCRATCH,) f8 -> bool
def faces_cross(vertices, i, j, k, m, n, o, pair, scratch):
    """The result of `triangles_cross` for faces i, j, k and m, n, o; overwrites `pair`."""
    scratch[0], scratch[1], scratch[2], scratch[3], scratch[4], scratch[5] = i, j, k, m, n, o
    shared = 0
    for a in range(3):
        for b in range(shared, 3):
            if scratch[a] == scratch[3 + b]:
                scratch[a], scratch[shared] = scratch[shared], scratch[a]
                scratch[3 + b], scratch[3 + shared] = scratch[3 + shared], scratch[3 + b]
                shared += 1
                break
    for row in range(6):
        vertex = int(scratch[row])
        pair[row, 0], pair[row, 1], pair[row, 2] = vertices[vertex, 0], vertices[vertex, 1], vertices[vertex, 2]
    return triangles_cross(pair, shared, scratch)
