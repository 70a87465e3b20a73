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

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.budget import Budget
from kabo.geometry.collision.kernels.containment import first_outside
from kabo.geometry.collision.kernels.distance import unions_apart, unions_distance
from kabo.geometry.collision.kernels.volumes import FINER, MEET, volumes_meet
from kabo.geometry.collision.motions import Motion, Segment, Swept, placed, standing, standing_parts
from kabo.geometry.collision.view_arrays import offset_for
from kabo.geometry.parts import COLUMNS, FixedGroup, MovingGroup, with_columns
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
    _require(budget, first.enclosure.deviation, second.enclosure.deviation)
    pair = _paired(first, second)
    return not unions_apart(
        *pair[:4], budget.margin, pair.offset, np.zeros(3), np.zeros((4, 3)), np.zeros(4, np.int64)
    )


def sweep_collides(motion: Motion, other: Motion | FixedGroup, budget: Budget) -> bool:
    """Whether a motion's swept volume may meet a body, or another motion's swept volume [K Def. 1.2, 1.3].

    True where the swept volumes share a point, whatever the times; False where they are epsilon apart.

    Raises:
        ValueError: as `collides`.
    """
    against = standing(other) if isinstance(other, FixedGroup) else other
    deviations = motion.deviation, against.deviation
    _require(budget, *deviations)
    slack = budget.epsilon - budget.clearance - budget.numeric - sum(deviations)
    scratch = (
        np.empty((4, 3, COLUMNS)),
        np.empty((6, 6)),
        np.zeros((64, 4), np.int64),
        np.zeros(3),
        np.zeros((4, 3)),
    )
    offset = offset_for(max(motion.reach, against.reach))
    question = (slack, slack + budget.clearance, budget.margin, offset, *scratch, np.zeros(4, np.int64))
    return any(
        _meet(motion, mine, against, theirs, question, MAX_SEGMENT_HALVINGS)
        for mine in motion.segments
        for theirs in against.segments
    )


def _meet(
    motion: Motion, mine: Segment, other: Motion, theirs: Segment, question: tuple[object, ...], halvings: int
) -> bool:
    """Whether two motions' swept volumes may meet, on a segment of each; halves segments where more nodes are needed."""
    ours, others = _swept(motion, mine), _swept(other, theirs)
    answers = {volumes_meet(*a, *b, *question) for a in ours for b in others}
    if MEET in answers or FINER not in answers:
        return MEET in answers
    return halvings == 0 or any(
        _meet(motion, half, other, part, question, halvings - 1)
        for half in _halves(mine)
        for part in _halves(theirs)
    )


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
    _require(budget, container.deviation, body.enclosure.deviation)
    inside_T_body = _relative(container.world_T_container, body.world_T_group)
    own = placed(MovingGroup(0, inside_T_body, body.enclosure))
    solid = container.solid
    greatest = max(float(own.radii.max(initial=0.0)), float(np.linalg.norm(solid.vertices, axis=1).max()))
    box = _boxes(own.extents)
    scratch = np.empty((2, 3, COLUMNS)), np.zeros(3), np.zeros((4, 3)), np.zeros(4, np.int64)
    tree, stack = solid.tree, np.zeros(64, np.int64)
    found = first_outside(own.blocks, own.sizes, box, budget.numeric, *tree, stack, offset_for(greatest), *scratch)
    return int(found) < 0


def distance(first: FixedGroup, second: FixedGroup) -> Bounds:
    """Proven bounds of the distance of two bodies [m]; the lower one is 0 where the parts are not proven apart.

    The lower bound is the lower bound for the enclosing parts. The upper bound adds both deviations, since every
    point of a part lies within the deviation of its body.

    Raises:
        ValueError: parts or poses are not usable.
    """
    pair = _paired(first, second)
    lower, upper = unions_distance(*pair, np.zeros(3), np.zeros((4, 3)))
    return Bounds(float(lower), float(upper) + first.enclosure.deviation + second.enclosure.deviation)


class _Pair(NamedTuple):
    """The parts of two bodies in the world, one after the other, as arrays for distance kernels."""

    blocks: Array  # (B, 3, K)
    sizes: Integers  # (B,)
    boxes: Array  # (B, 6) lower, upper
    first: int  # how many are the first body's
    offset: float  # for exact comparisons, by the greatest coordinate


def _paired(first: FixedGroup, second: FixedGroup) -> _Pair:
    ours, theirs = standing_parts(first), standing_parts(second)
    greatest = max(float(ours.radii.max(initial=0.0)), float(theirs.radii.max(initial=0.0)))
    columns = max(ours.blocks.shape[2], theirs.blocks.shape[2])
    return _Pair(
        np.concatenate([with_columns(ours.blocks, columns), with_columns(theirs.blocks, columns)]),
        np.concatenate([ours.sizes, theirs.sizes]),
        np.concatenate([_boxes(ours.extents), _boxes(theirs.extents)]),
        len(ours.sizes),
        offset_for(greatest),
    )


def _require(budget: Budget, *deviations: float) -> None:
    if not max(deviations) <= budget.geometry:
        raise ValueError(
            f"an enclosure deviates by {max(deviations):g} m, the budget allows {budget.geometry:g} m"
        )


def _relative(first: Array, second: Array) -> Array:
    """first_T_second of two poses (12,) in the same frame."""
    R, moved = first[:9].reshape(3, 3), second[9:] - first[9:]
    return np.concatenate([(R.T @ second[:9].reshape(3, 3)).ravel(), R.T @ moved])


def _boxes(extents: Array) -> Array:
    """Boxes (B, 6), lower and upper, from centres and half extents."""
    return np.concatenate([extents[:, :3] - extents[:, 3:], extents[:, :3] + extents[:, 3:]], axis=1)
