"""The predicates of [K Def. 1] on the original meshes and round shapes; bounded predicates are compared with these.

They are exact for bodies that do not move. Motions are sampled so densely that no point moves farther than a given
step between samples; nothing is proven between samples.
"""

from dataclasses import replace

import numpy as np

from kabo.arrays import Array
from kabo.geometry.collision.exact_surfaces import Surface, distance, holds, placed, surface_of, surrounds, touch
from kabo.geometry.collision.exact_view import BOX_SLACK
from kabo.geometry.collision.kernels.tracks import motion as motion_bounds
from kabo.geometry.collision.kernels.tracks import turning
from kabo.geometry.collision.motions import Motion, Segment
from kabo.geometry.collision.view_arrays import chain_of, way_of
from kabo.geometry.parts import FixedGroup


def exact_collides(first: FixedGroup, second: FixedGroup) -> bool:
    """Whether the solids of two bodies share a point [K Def. 1.1].

    Raises:
        ValueError: a body without a mesh.
    """
    ours, theirs = surface_of(first), surface_of(second)
    return (
        surfaces_touch(first, second)
        or _nested(first, ours, second, theirs)
        or _nested(second, theirs, first, ours)
    )


def surfaces_touch(first: FixedGroup, second: FixedGroup) -> bool:
    """Whether the surfaces of two bodies share a point; False if one body is inside the other.

    Raises:
        ValueError: a body without a mesh.
    """
    ours, theirs = surface_of(first), surface_of(second)
    return bool(touch(ours, placed(ours, first.world_T_group), theirs, placed(theirs, second.world_T_group)))


def exact_includes(container: FixedGroup, body: FixedGroup) -> bool:
    """Whether all of a body lies inside a container, both given by their meshes, also of round elements [K Def. 1.4].

    Raises:
        ValueError: a body without a mesh.
    """
    container, body = replace(container, elements=()), replace(body, elements=())
    outer, inner = surface_of(container), surface_of(body)
    if touch(outer, placed(outer, container.world_T_group), inner, placed(inner, body.world_T_group)):
        return False
    if not holds(outer, _local(_world(inner.corners, body.world_T_group), container.world_T_group)).all():
        return False
    return not _nested(body, inner, container, outer)  # a hollow of the container, or all of it, in the body


def exact_distance(first: FixedGroup, second: FixedGroup) -> float:
    """The distance of the solids of two bodies [m]; 0 where they share a point.

    Raises:
        ValueError: a body without a mesh.
    """
    if exact_collides(first, second):
        return 0.0
    ours, theirs = surface_of(first), surface_of(second)
    return distance(ours, placed(ours, first.world_T_group), theirs, placed(theirs, second.world_T_group))


def exact_sweep_collides(motion: Motion, other: Motion | FixedGroup, step: float) -> bool:
    """Whether any sample of a motion collides with a body, or with any sample of another motion [K Def. 1.2, 1.3].

    Args:
        motion: a motion of bodies that all have a mesh.
        other: another motion of bodies with meshes, or a fixed body.
        step: the greatest distance that any point moves from one sample to the next [m].

    Raises:
        ValueError: a body without a mesh.
    """
    ours = _samples(motion, step)
    theirs = [other] if isinstance(other, FixedGroup) else _samples(other, step)
    boxes = [np.array([_box(body) for body in samples]).reshape(-1, 2, 3) for samples in (ours, theirs)]
    for body, (low, high) in zip(ours, boxes[0], strict=True):
        near = ((boxes[1][:, 0] <= high) & (low <= boxes[1][:, 1])).all(axis=1)
        if any(exact_collides(body, theirs[k]) for k in np.flatnonzero(near).tolist()):
            return True
    return False


def _box(body: FixedGroup) -> Array:
    """The box (2, 3) around a body in the world, a little larger against rounding."""
    points = _world(surface_of(body).vertices, body.world_T_group)
    return np.array([points.min(axis=0) - BOX_SLACK, points.max(axis=0) + BOX_SLACK])


def _samples(motion: Motion, step: float) -> list[FixedGroup]:
    """The bodies of a motion at every sample."""
    found = []
    for segment in motion.segments:
        count = max(1, int(np.ceil(_longest_path(motion, segment) / step)))
        for i in range(count + 1):
            at = segment[0] + i / count * (segment[1] - segment[0])
            for body, swept in zip(motion.bodies, motion.swept(at, at, 1), strict=True):
                pose = _product(swept.poses[0], np.asarray(body.joint_T_group, np.float64))
                found.append(FixedGroup(pose, body.enclosure, body.mesh, body.elements))
    return found


def _longest_path(motion: Motion, segment: Segment) -> float:
    """An upper bound of how far any point of the bodies travels on a segment [m]."""
    chain = chain_of(motion.tree)
    way = way_of(chain, np.zeros((1, len(motion.tree.parent), 12)))
    way.segment[:] = *segment, segment[0]
    turning(way, chain)
    radii = [np.linalg.norm(_world(surface_of(b).vertices, b.joint_T_group), axis=1).max() for b in motion.bodies]
    paths = [
        motion_bounds(way, chain, body.joint, 0, radius)[2]
        for body, radius in zip(motion.bodies, radii, strict=True)
    ]
    return float(max(paths, default=0.0))


def _nested(outer: FixedGroup, surface: Surface, inner: FixedGroup, other: Surface) -> bool:
    """Whether the outer solid contains a component of the inner one."""
    return surrounds(surface, _local(_world(other.corners, inner.world_T_group), outer.world_T_group))


def _world(points: Array, pose: Array) -> Array:
    return np.asarray(points @ pose[:9].reshape(3, 3).T + pose[9:])


def _local(points: Array, pose: Array) -> Array:
    return np.asarray((points - pose[9:]) @ pose[:9].reshape(3, 3))


def _product(first: Array, second: Array) -> Array:
    R = first[:9].reshape(3, 3)
    return np.concatenate([(R @ second[:9].reshape(3, 3)).ravel(), R @ second[9:] + first[9:]])
