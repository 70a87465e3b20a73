"""The predicates of [K Def. 1] on the original meshes, through python-fcl; bounded predicates are compared with these.

They are exact for bodies that do not move. Motions are sampled so densely that no point moves farther than a given
step between samples; nothing is proven between samples.
"""

import fcl
import numpy as np

from kabo.arrays import Array
from kabo.geometry.collision.exact_view import Surface, surface_of, surrounds
from kabo.geometry.collision.kernels.tracks import motion as motion_bounds
from kabo.geometry.collision.kernels.tracks import turning
from kabo.geometry.collision.motions import Motion, Segment
from kabo.geometry.collision.view_arrays import chain_of, way_of
from kabo.geometry.parts import FixedGroup, Mesh


def exact_collides(first: FixedGroup, second: FixedGroup) -> bool:
    """Whether the solids of two bodies share a point [K Def. 1.1].

    Raises:
        ValueError: a body without a mesh.
    """
    ours, theirs = _surface(first.mesh), _surface(second.mesh)
    bodies = [_object(ours, first.world_T_group), _object(theirs, second.world_T_group)]
    if fcl.collide(*bodies, fcl.CollisionRequest(), fcl.CollisionResult()) > 0:
        return True
    return _nested(first, ours, second, theirs) or _nested(second, theirs, first, ours)


def exact_includes(container: FixedGroup, body: FixedGroup) -> bool:
    """Whether all of a body lies inside a container, both given by their meshes [K Def. 1.4].

    Raises:
        ValueError: a body without a mesh.
    """
    outer, inner = _surface(container.mesh), _surface(body.mesh)
    bodies = [_object(outer, container.world_T_group), _object(inner, body.world_T_group)]
    if fcl.collide(*bodies, fcl.CollisionRequest(), fcl.CollisionResult()) > 0:
        return False
    local = _local(_world(inner.corners, body.world_T_group), container.world_T_group)
    if not outer.solid.insides(local).all():
        return False
    return not _nested(body, inner, container, outer)  # a hollow of the container, or all of it, in the body


def exact_distance(first: FixedGroup, second: FixedGroup) -> float:
    """The distance of the solids of two bodies [m]; 0 where they share a point.

    Raises:
        ValueError: a body without a mesh.
    """
    if exact_collides(first, second):
        return 0.0
    bodies = [_object(_surface(body.mesh), body.world_T_group) for body in (first, second)]
    return float(fcl.distance(*bodies, fcl.DistanceRequest(), fcl.DistanceResult()))


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
    managers = []
    for samples in (ours, theirs):
        manager = fcl.DynamicAABBTreeCollisionManager()
        manager.registerObjects([_object(_surface(body.mesh), body.world_T_group) for body in samples])
        manager.setup()
        managers.append(manager)
    met = fcl.CollisionData()
    managers[0].collide(managers[1], met, fcl.defaultCollisionCallback)
    if met.result.is_collision:
        return True
    return any(
        _nested(a, _surface(a.mesh), b, _surface(b.mesh)) or _nested(b, _surface(b.mesh), a, _surface(a.mesh))
        for a in ours
        for b in theirs
    )


def _samples(motion: Motion, step: float) -> list[FixedGroup]:
    """The bodies of a motion at every sample."""
    found = []
    for segment in motion.segments:
        count = max(1, int(np.ceil(_longest_path(motion, segment) / step)))
        for i in range(count + 1):
            at = segment[0] + i / count * (segment[1] - segment[0])
            for body, swept in zip(motion.bodies, motion.swept(at, at, 1), strict=True):
                pose = _product(swept.poses[0], np.asarray(body.joint_T_group, np.float64))
                found.append(FixedGroup(pose, body.enclosure, body.mesh))
    return found


def _longest_path(motion: Motion, segment: Segment) -> float:
    """An upper bound of how far any point of the bodies travels on a segment [m]."""
    chain = chain_of(motion.tree)
    way = way_of(chain, np.zeros((1, len(motion.tree.parent), 12)))
    way.segment[:] = *segment, segment[0]
    turning(way, chain)
    radii = [np.linalg.norm(_world(_mesh(b.mesh)[0], b.joint_T_group), axis=1).max() for b in motion.bodies]
    paths = [
        motion_bounds(way, chain, body.joint, 0, radius)[2]
        for body, radius in zip(motion.bodies, radii, strict=True)
    ]
    return float(max(paths, default=0.0))


def _mesh(mesh: Mesh | None) -> Mesh:
    if mesh is None:
        raise ValueError("an exact predicate needs the mesh of every body")
    return mesh


def _surface(mesh: Mesh | None) -> Surface:
    return surface_of(_mesh(mesh))


def _object(surface: Surface, pose: Array) -> fcl.CollisionObject:
    return fcl.CollisionObject(surface.model, fcl.Transform(pose[:9].reshape(3, 3), pose[9:]))


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
