"""Bounding swept volumes: convex polyhedra that contain the volume swept by moving bodies [K 4.5, Proposition 3].

Between two poses of a part, the hull of both, grown by the deviation D of its points from their chords, contains
the swept volume [K Eq. 4.19-4.22]; D is summed up joint by joint with the actual distance of each joint from the
part (`kernels.tracks.motion`), prismatic joints included. The excess is bounded, too: a point of such a hull lies
within D + |R0 - R1| d / 4 of the true swept volume, where R are the rotations of both poses and d is the part's
diameter. The intervals of a part are halved until the excess is small enough, so slow or small parts get few
polyhedra, long bars many.

A hull is grown by an icosahedron around the ball of radius D, whose twelve corners are at most 1.2585 D away.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array, Integers
from kabo.geometry.collision.kernels.bundles import Swept
from kabo.geometry.collision.kernels.volumes import DEVIATION, QUARTER, TURN, hull_spread
from kabo.geometry.collision.motions import Motion, Segment
from kabo.geometry.collision.part_trees import finest
from kabo.geometry.parts import points_around
from kabo.geometry.triangles.hulls import hull_mesh
from kabo.meshes import Rounding

_GOLDEN = 0.5 * (1.0 + np.sqrt(5.0))
_CORNERS = np.array([c for a in (-1, 1) for b in (-_GOLDEN, _GOLDEN) for c in ((0, a, b), (a, b, 0), (b, 0, a))])
_INRADIUS = _GOLDEN**2 / np.sqrt(3.0)  # of the icosahedron with edges of length 2
ICOSAHEDRON = _CORNERS / _INRADIUS * (1.0 + 1e-9)  # (12, 3) corners; it contains the ball of radius 1
CORNER_RADIUS = float(np.linalg.norm(ICOSAHEDRON[0])) * (1.0 + 1e-9)  # 1.2585: of the icosahedron
BALL_EXCESS, DISC_EXCESS = 0.02, 0.002  # of a radius, by which points around a ball or a disc lie outside
POSE_ROUNDING = 1e-9  # [m] added to the growth of every polyhedron
MAX_HALVINGS = 16  # of a segment; the result states the excess that is left


@dataclass(frozen=True, eq=False)
class Hull:
    """The hull of one part of a body over one interval of its motion."""

    points: Array  # (P, 3) the part's vertices at both poses, in the world
    growth: float  # D: the points' hull grown by so much contains what the part sweeps [m]
    deviation: float  # how far the polyhedron sticks out of the swept volume at most [m]


@dataclass(frozen=True, eq=False)
class SweptVolume:
    """Convex polyhedra whose union contains the volume swept by bodies along a motion.

    `hulls` are stored before growing, as in [K 4.5]; `parts` are the grown polyhedra.
    """

    hulls: tuple[Hull, ...]

    @property
    def deviation(self) -> float:
        """A proven bound of how far any point of the polyhedra is from the volume swept by the bodies [m]."""
        return max((hull.deviation for hull in self.hulls), default=0.0)

    @cached_property
    def parts(self) -> tuple[Array, ...]:
        """The corners (V, 3) of every polyhedron [m], in the world."""
        return tuple(hull_mesh(_grown(hull))[0] for hull in self.hulls)

    def mesh(self) -> tuple[Array, Integers]:
        """All polyhedra as one mesh: vertices (V, 3) [m], triangles (F, 3) facing outwards.

        Every polyhedron is a closed component; overlapping components cross.
        """
        vertices: list[Array] = []
        faces: list[Integers] = []
        count = 0
        for hull in self.hulls:
            corners, triangles = hull_mesh(_grown(hull))
            vertices.append(corners)
            faces.append(triangles + count)
            count += len(corners)
        if not vertices:
            return np.empty((0, 3)), np.empty((0, 3), np.int64)
        return np.concatenate(vertices), np.concatenate(faces)


def swept_volume(motion: Motion, tolerance: float) -> SweptVolume:
    """The bounding swept volume of bodies along a motion.

    Args:
        motion: links, tools and attached objects on their joints, and the waypoints.
        tolerance: how far the polyhedra may stick out of the volume swept by the bodies' parts [m], not counting the
            deviation of the parts from the bodies.

    Raises:
        ValueError: the tolerance is less than a micrometre, or arrays are not usable.
    """
    if not tolerance >= 1e-6:
        raise ValueError(f"the tolerance of a swept volume is at least a micrometre, not {tolerance:g} m")
    bodies = tuple(replace(body, enclosure=finest(body.enclosure, tolerance)) for body in motion.bodies)
    motion = replace(motion, bodies=bodies)
    hulls = [
        hull
        for segment in motion.segments
        for body, own in zip(motion.bodies, _swept(motion, segment, tolerance), strict=True)
        for part in range(len(own.extents))
        for hull in _hulls(own, part, tolerance, body.enclosure.deviation)
    ]
    return SweptVolume(tuple(hulls))


def _swept(motion: Motion, segment: Segment, tolerance: float) -> list[Swept]:
    """Every body on a segment, at as many nodes as its worst part needs."""
    bounds = np.concatenate([np.zeros((1, 3)), *(own.bounds for own in motion.swept(*segment, 1))])
    level = 0
    while level < MAX_HALVINGS and _sticking(bounds[:, DEVIATION], bounds[:, TURN], level).max() > tolerance:
        level += 1
    return motion.swept(*segment, 1 << level)


def _sticking(deviation: Array, turn: Array, level: int) -> Array:
    """Upper bounds of how far the polyhedra of a level's intervals stick out."""
    return (1.0 + CORNER_RADIUS) * (deviation * 0.25**level + POSE_ROUNDING) + turn * 0.5**level


def _hulls(own: Swept, part: int, tolerance: float, deviation: float) -> Iterator[Hull]:
    """The hulls of a part, whose intervals are halved until their polyhedra stick out by at most the tolerance."""
    whole = len(own.poses) - 1
    stack = [(0, whole)]
    while stack:
        node, width = stack.pop()
        share, ends = width / whole, own.poses[[node, node + width]]
        growth = float(own.bounds[part, DEVIATION]) * share * share
        spread = hull_spread(ends, 0, 1, own.bounds[part, TURN] * share, own.bounds[part, QUARTER])
        sticking = (1.0 + CORNER_RADIUS) * (growth + POSE_ROUNDING) + float(spread)
        if sticking <= tolerance or width == 1:
            radius, disc, *axis = own.hulls.rounds[part].tolist()
            corners = own.hulls.blocks[part, :, : own.hulls.sizes[part]].T
            around = Rounding(radius, disc, (axis[0], axis[1], axis[2]))
            sticking += BALL_EXCESS * radius + DISC_EXCESS * disc
            local = points_around(np.ascontiguousarray(corners), around).T
            points = np.concatenate([(end[:9].reshape(3, 3) @ local).T + end[9:] for end in ends])
            yield Hull(points, growth, sticking + deviation)
        else:
            stack += [(node + width // 2, width // 2), (node, width // 2)]


def _grown(hull: Hull) -> Array:
    """Points whose hull contains the hull's points and the ball of its growth about each."""
    points = np.unique(hull.points, axis=0)
    with suppress(QhullError):  # flat, a needle, or one point: then all of them count
        points = points[ConvexHull(points).vertices]
    return np.asarray((points[:, None] + (hull.growth + POSE_ROUNDING) * ICOSAHEDRON[None]).reshape(-1, 3))
