"""The bounded predicates of [K Def. 1]: answers that err on one side only, and by less than epsilon [K Table 4.1].

Bodies are convex parts that enclose the true shape. "Free" needs a *proven* distance of the parts, everything else
counts as a collision; "included" needs a *proven* inclusion of the parts in a solid within the container. `Budget`
says how epsilon is spent; with deviations e_a, e_b of both bodies' parts (e_b <= `geometry`, too, of the inner
mesh of a container):

- free is said if the parts are proven farther apart than `clearance`; hit if they come closer than
  epsilon - e_a - e_b, hence never where the bodies are epsilon apart;
- included is said if the parts are proven `numeric` deep in the inner mesh, hence wherever the body is
  e_a + e_b + 2 `numeric` < epsilon deep in the container.

Two motions are compared at all times of both [K Def. 1.3]; for bodies that move in step there is `CollisionView`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.budget import Budget
from kabo.geometry.collision.kernels.bundles import Hulls, Limits, Search, Surface, Swept
from kabo.geometry.collision.kernels.containment import first_outside
from kabo.geometry.collision.kernels.distance import unions_distance, unions_near
from kabo.geometry.collision.kernels.volumes import FINER, MEET, volumes_meet
from kabo.geometry.collision.motions import Motion, Segment, placed, standing, standing_parts
from kabo.geometry.collision.part_trees import Cover, deviation_within, divided_larger, require_fine
from kabo.geometry.collision.view_arrays import offset_for, pool_of, search_for
from kabo.geometry.parts import FixedGroup, MovingGroup, with_columns
from kabo.geometry.triangles.solids import Solid
from kabo.meshes import Mesh as TriangleMesh

MAX_INTERVALS = 64  # of a segment: where more are needed it is halved
MAX_SEGMENT_HALVINGS = 14  # down to 2^20 intervals in all


@dataclass(frozen=True, eq=False)
class InnerSolid:
    """A solid inside a container: an inner bounding mesh, or the container's own mesh (deviation 0).

    It contains every point of the container deeper than `deviation`. Neither solid needs to be convex.
    """

    world_T_container: Array  # (12,)
    vertices: Array  # (V, 3) [m]
    faces: Integers  # (F, 3), closed
    deviation: float

    def __post_init__(self) -> None:
        """Makes the box tree.

        Raises:
            ValueError: the deviation is negative, or the pose is not 12 finite numbers.
        """
        if not self.deviation >= 0.0:
            raise ValueError(f"an inner mesh deviates by {self.deviation:g} m, which is no distance")
        pose = np.asarray(self.world_T_container, np.float64)
        if pose.shape != (12,) or not np.isfinite(pose).all():
            raise ValueError("the pose of a container is not 12 finite numbers")
        object.__setattr__(self, "solid", Solid(np.asarray(self.vertices, np.float64), np.asarray(self.faces)))

    solid: Solid = field(init=False)

    @classmethod
    def within(cls, world_T_container: Array, vertices: Array, faces: Integers, tolerance: float) -> "InnerSolid":
        """The solid of an inner bounding mesh that lies inside a closed mesh, at most `tolerance` [m] from it.

        Raises:
            MeshError: the mesh is not closed, or cannot be used for another reason.
        """
        # Loaded here since only containers of many triangles need its kernels (0.1 s).
        from kabo.geometry.bounding.bounding_mesh import bounding_mesh

        inner = bounding_mesh(TriangleMesh(vertices, faces, None), tolerance, "inner")
        return cls(world_T_container, inner.vertices, inner.faces, inner.hausdorff_upper_bound)


@dataclass(frozen=True)
class Bounds:
    """A proven lower and a proven upper bound of a number."""

    lower: float  # [m]
    upper: float  # [m]


def collides(first: FixedGroup, second: FixedGroup, budget: Budget) -> bool:
    """Whether two bodies may collide: True if they share a point, False if they are epsilon or more apart [K Def. 1.1].

    Raises:
        ValueError: parts, poses or deviations are not usable, or exceed the budget.
    """
    require_fine(first.enclosure, budget.geometry)
    require_fine(second.enclosure, budget.geometry)
    covers: list[Cover] | None = [Cover.of(first.enclosure), Cover.of(second.enclosure)]
    while covers is not None:
        pair = _paired(*_covered((first, second), covers))
        a, b = unions_near(pair.hulls, pair.boxes, pair.first, budget.margin, search_for(pair.offset))
        if a < 0:
            return False
        covers = divided_larger(covers, (a, b - pair.first), budget.geometry)
    return True


def _covered(bodies: Sequence[FixedGroup], covers: Sequence[Cover]) -> list[FixedGroup]:
    """The bodies with the parts of their covers."""
    return [
        body if cover.enclosure is body.enclosure else replace(body, enclosure=cover.enclosure)
        for body, cover in zip(bodies, covers, strict=True)
    ]


def sweep_collides(motion: Motion, other: Motion | FixedGroup, budget: Budget) -> bool:
    """Whether a motion's swept volume may meet a body, or another motion's swept volume [K Def. 1.2, 1.3].

    True where the swept volumes share a point, whatever the times; False where they are epsilon apart.

    Raises:
        ValueError: as `collides`.
    """
    sides = motion, standing(other) if isinstance(other, FixedGroup) else other
    for body in (*sides[0].bodies, *sides[1].bodies):
        require_fine(body.enclosure, budget.geometry)
    covers = [[Cover.of(body.enclosure) for body in side.bodies] for side in sides]
    spent = sum(
        max((deviation_within(body.enclosure, budget.geometry) for body in side.bodies), default=0.0)
        for side in sides
    )
    slack = budget.epsilon - budget.clearance - budget.numeric - spent
    limits = Limits(slack, slack + budget.clearance, budget.margin)
    while True:
        ours, theirs = (_covered_motion(*both) for both in zip(sides, covers, strict=True))
        met = _first_meeting(ours, theirs, limits)
        if met is None:
            return False
        i, k, places = met
        finer = divided_larger((covers[0][i], covers[1][k]), places, budget.geometry)
        if finer is None:
            return True
        covers[0][i], covers[1][k] = finer


def _covered_motion(motion: Motion, covers: Sequence[Cover]) -> Motion:
    """A motion with the parts of covers."""
    bodies = tuple(
        body if cover.enclosure is body.enclosure else replace(body, enclosure=cover.enclosure)
        for body, cover in zip(motion.bodies, covers, strict=True)
    )
    return (
        motion
        if all(a is b for a, b in zip(bodies, motion.bodies, strict=True))
        else replace(motion, bodies=bodies)
    )


class _Asked(NamedTuple):
    """What is asked of two swept volumes, and the scratch arrays for it."""

    limits: Limits
    pool: Hulls
    boxes: Array
    stack: Integers
    search: Search


_Meeting = tuple[int, int, tuple[int, int]]  # numbers of a body of either motion, and of a part of each


def _first_meeting(motion: Motion, other: Motion, limits: Limits) -> _Meeting | None:
    """Bodies of two motions, and their parts, whose swept volumes may meet; None if all are apart."""
    search = search_for(offset_for(max(motion.reach, other.reach)))
    asked = _Asked(limits, pool_of(4), np.empty((6, 6)), np.zeros((64, 4), np.int64), search)
    for mine in motion.segments:
        for theirs in other.segments:
            met = _meet(motion, mine, other, theirs, asked, MAX_SEGMENT_HALVINGS)
            if met is not None:
                return met
    return None


def _meet(
    motion: Motion, mine: Segment, other: Motion, theirs: Segment, asked: _Asked, halvings: int
) -> _Meeting | None:
    """The bodies and parts that may meet on a segment of each motion; halves segments where more nodes are needed."""
    ours, others, finer = _swept(motion, mine), _swept(other, theirs), None
    for i, a in enumerate(ours):
        for k, b in enumerate(others):
            answer, *parts = volumes_meet(a, b, *asked)
            if answer == MEET:
                return i, k, (parts[0], parts[1])
            finer = (i, k, (parts[0], parts[1])) if answer == FINER else finer
    if finer is None or halvings == 0:
        return finer
    for half in _halves(mine):
        for part in _halves(theirs):
            met = _meet(motion, half, other, part, asked, halvings - 1)
            if met is not None:
                return met
    return None


def _moves(segment: Segment) -> bool:
    return bool((segment[0] != segment[1]).any())


def _swept(motion: Motion, segment: Segment) -> list[Swept]:
    return motion.swept(*segment, MAX_INTERVALS if _moves(segment) else 1)


def _halves(segment: Segment) -> list[Segment]:
    """Both halves of a segment, or itself if it has no length."""
    middle = segment[0] + 0.5 * (segment[1] - segment[0])
    return [(segment[0], middle), (middle, segment[1])] if _moves(segment) else [segment]


def includes(container: InnerSolid, body: FixedGroup, budget: Budget) -> bool:
    """Whether a body is proven to lie inside a container [K Def. 1.4].

    False where any point of the body is outside; True where all of it is epsilon deep.

    Raises:
        ValueError: as `collides`.
    """
    if not container.deviation <= budget.geometry:
        raise ValueError(
            f"an inner mesh deviates by {container.deviation:g} m, the budget allows {budget.geometry:g} m"
        )
    require_fine(body.enclosure, budget.geometry)
    inside_T_body = _relative(container.world_T_container, body.world_T_group)
    solid, covers = container.solid, [Cover.of(body.enclosure)]
    while True:
        own = placed(MovingGroup(0, inside_T_body, covers[0].enclosure))
        greatest = max(own.far, float(np.linalg.norm(solid.vertices, axis=1).max()))
        surface, search = Surface(*solid.tree, np.zeros(64, np.int64)), search_for(offset_for(greatest))
        found = first_outside(own.hulls, _boxes(own.extents), budget.numeric, surface, pool_of(2), search)
        finer = divided_larger(covers, (int(found),), budget.geometry) if found >= 0 else None
        if finer is None:
            return int(found) < 0
        covers = finer


def distance(first: FixedGroup, second: FixedGroup, within: float = np.inf) -> Bounds:
    """Proven bounds of the distance of two bodies [m]; the lower one is 0 where the parts are not proven apart.

    The lower bound is the lower bound for the enclosing parts; those that are nearest deviate by at most `within` [m]
    if they have children. The upper bound adds both deviations, since every point of a part lies within the
    deviation of its body.

    Raises:
        ValueError: parts or poses are not usable.
    """
    covers = [Cover.of(first.enclosure), Cover.of(second.enclosure)]
    while True:
        bodies = _covered((first, second), covers)
        pair = _paired(*bodies)
        lower, upper, a, b = unions_distance(pair.hulls, pair.boxes, pair.first, search_for(pair.offset))
        finer = divided_larger(covers, (a, b - pair.first), within)
        if finer is None:
            deviations = sum(body.enclosure.deviation for body in bodies)
            return Bounds(float(lower), float(upper) + deviations)
        covers = finer


class _Pair(NamedTuple):
    """The parts of two bodies in the world, one after the other, as arrays for distance kernels."""

    hulls: Hulls
    boxes: Array  # (B, 6) lower, upper
    first: int  # how many are the first body's
    offset: float  # for exact comparisons, by the greatest coordinate


def _paired(first: FixedGroup, second: FixedGroup) -> _Pair:
    ours, theirs = standing_parts(first), standing_parts(second)
    columns = max(ours.hulls.blocks.shape[2], theirs.hulls.blocks.shape[2])
    return _Pair(
        Hulls(
            np.concatenate([with_columns(own.hulls.blocks, columns) for own in (ours, theirs)]),
            np.concatenate([ours.hulls.sizes, theirs.hulls.sizes]),
            np.concatenate([ours.hulls.rounds, theirs.hulls.rounds]),
        ),
        np.concatenate([_boxes(ours.extents), _boxes(theirs.extents)]),
        len(ours.radii),
        offset_for(max(ours.far, theirs.far)),
    )


def _relative(first: Array, second: Array) -> Array:
    """first_T_second of two poses (12,) in the same frame."""
    R, moved = first[:9].reshape(3, 3), second[9:] - first[9:]
    return np.concatenate([(R.T @ second[:9].reshape(3, 3)).ravel(), R.T @ moved])


def _boxes(extents: Array) -> Array:
    """Boxes (B, 6), lower and upper, from centres and half extents."""
    return np.concatenate([extents[:, :3] - extents[:, 3:6], extents[:, :3] + extents[:, 3:6]], axis=1)
