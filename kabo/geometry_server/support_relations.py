"""Support relations: the bodies on which an object stands, by its placement families; and inclusion in regions."""

from functools import partial

import numpy as np

from kabo import geometry  # its names load when they are used: python-fcl only where meshes decide
from kabo.arrays import Array
from kabo.geometry import FixedGroup
from kabo.geometry_server.foresight.things import box_at
from kabo.geometry_server.foresight.widths import corners
from kabo.geometry_server.frames import WORLD, fits, has, rows, standing_frame
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.kinematics import satisfied
from kabo.language.scene_description import Constraint
from kabo.meshes import Rounding
from kabo.scene import Body, Element, KinematicTree, Region
from kabo.scene.transforms import flat

STANDING_TOLERANCE = 1e-4  # [m, rad] within which a placement's constraints hold
RESTING_GAP, RESTING_DEPTH = 5e-4, 1e-4  # [m] above and in what it rests on, as bodies are measured in a run


def _unmoved() -> KinematicTree:
    one, nothing = np.zeros(1, dtype=np.int64), np.empty(0)
    world = np.array([[1.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]])
    return KinematicTree(one, one, one, np.zeros(1), np.zeros(1), world, nothing, nothing, nothing)


WORLD_TREE = _unmoved()  # for constraints between standing things


def supports(surroundings: SceneSurroundings, situation: Situation, name: str) -> tuple[str, ...]:
    """The bodies on which an object stands, in the scene's order: by one of its placement families.

    Where a run has left it, as the scene begins in the state of a run, it also stands on what it rests on.
    """
    # Stages of a task ask one after the other about the same situation, and so does the timing of its motion.
    found: tuple[str, ...] = surroundings.remembered(
        ("supports", name, situation.key), lambda: _supports(surroundings, situation, name)
    )
    return found


def _supports(surroundings: SceneSurroundings, situation: Situation, name: str) -> tuple[str, ...]:
    body = surroundings.scene.bodies[name]
    (pose,) = surroundings.poses(situation, name)
    by_family = tuple(
        other.name
        for other in surroundings.scene.bodies.values()
        if other is not body
        and any(
            _stands(surroundings, body, pose, other, under, family.constraints)
            for under in surroundings.poses(situation, other.name)
            for family in body.placements.values()
        )
    )
    left = surroundings.scene.met and situation.objects[name] == (surroundings.scene.start.objects[name],)
    return by_family or (rests_on(surroundings, situation, name) if left else ())


def rests_on(surroundings: SceneSurroundings, situation: Situation, name: str) -> tuple[str, ...]:
    """The bodies on which one rests by their meshes: a little lower it would overlap them, a little higher it would not."""
    body = surroundings.scene.bodies[name]
    (pose,) = surroundings.poses(situation, name)

    def meets(other: FixedGroup, height: float) -> bool:
        lifted = pose.copy()
        lifted[2, 3] += height
        return geometry.surfaces_touch(_standing(surroundings, body.name, lifted), other)

    return tuple(
        other.name
        for other in surroundings.scene.bodies.values()
        if other.name not in situation.group(body.name) and not surroundings.never_collide(body.name, other.name)
        for under in surroundings.poses(situation, other.name)
        if _boxes_meet(surroundings, body, pose, other, under)
        for standing in [_standing(surroundings, other.name, under)]
        if meets(standing, -RESTING_GAP) and not meets(standing, RESTING_DEPTH)
    )


def why_unsupported(surroundings: SceneSurroundings, situation: Situation, name: str) -> str | None:
    """The reason why no placement family shows that an object stands on a body it touches; None if it touches no body."""
    body = surroundings.scene.bodies[name]
    (pose,) = surroundings.poses(situation, name)
    own = _standing(surroundings, name, pose)
    touched = [
        (other, under)
        for other in surroundings.scene.bodies.values()
        if other.name not in situation.group(name) and not surroundings.never_collide(name, other.name)
        for under in surroundings.poses(situation, other.name)
        if surroundings.touch(own, _standing(surroundings, other.name, under))
    ]
    if not touched:
        return None
    reasons = (_unfit(body, pose, other, under) for other, under in touched)
    return f"{name} touches {touched[0][0].name}, but no placement family of it says that it stands there: {next(reasons)}"


def _unfit(body: Body, pose: Array, under: Body, under_pose: Array) -> str:
    """For each placement family of a body, why it does not hold on another body."""
    roles = {"this": standing_frame(body, pose), "support": standing_frame(under, under_pose), "world": WORLD}
    told = []
    for family in body.placements.values():
        about = [
            c for c in family.constraints if c.kind != "inside" and "support" in (c.first.owner, c.second.owner)
        ]
        named = [feature for c in about for feature in (c.first, c.second)]
        lacking = [f for f in named if f.owner in roles and not has(roles, f)]
        if not about:
            told.append(f"{family.name} names no feature of its support")
        elif lacking:
            owner = {"this": body.name, "support": under.name}.get(lacking[0].owner, lacking[0].owner)
            told.append(f"{family.name} names {lacking[0]}, which {owner} lacks")
        else:
            told.append(f"{family.name} does not hold where it is")
    return "; ".join(told) or "it has none"


def _standing(surroundings: SceneSurroundings, name: str, pose: Array) -> FixedGroup:
    mesh = surroundings.scene.bodies[name].mesh
    return FixedGroup(flat(pose), surroundings.enclosure(name), (mesh.vertices, mesh.faces))


def _stands(
    surroundings: SceneSurroundings,
    body: Body,
    pose: Array,
    under: Body,
    under_pose: Array,
    constraints: tuple[Constraint, ...],
) -> bool:
    if not _boxes_meet(surroundings, body, pose, under, under_pose):
        return False
    roles = {"this": standing_frame(body, pose), "support": standing_frame(under, under_pose), "world": WORLD}
    about = [c for c in constraints if c.kind != "inside" and "support" in (c.first.owner, c.second.owner)]
    if not about or not fits(about, roles):
        return False
    return satisfied(rows(about, roles), np.empty(0), WORLD_TREE, STANDING_TOLERANCE)


def _boxes_meet(surroundings: SceneSurroundings, body: Body, pose: Array, under: Body, under_pose: Array) -> bool:
    low, high = _box(surroundings, body, pose)
    other_low, other_high = _box(surroundings, under, under_pose)
    return bool((low <= other_high + 1e-3).all() and (other_low <= high + 1e-3).all())


def _box(surroundings: SceneSurroundings, body: Body, pose: Array) -> tuple[Array, Array]:
    key = "box", body.name, pose.tobytes()
    found: tuple[Array, Array] = surroundings.lasting(key, lambda: box_at(body.mesh, pose))
    return found


def lies_inside(surroundings: SceneSurroundings, name: str, pose: Array, region: Region) -> bool:
    """Whether a body at a pose (4, 4) in the world is proven to lie inside a region [K Def. 1].

    A region is convex, so the body's own corners and roundings decide: no enclosing part is needed, and epsilon has no
    share in the answer.
    """
    return outside(surroundings, name, pose, region) <= -surroundings.budget.numeric


def outside(surroundings: SceneSurroundings, name: str, pose: Array, region: Region) -> float:
    """The distance by which a body at a pose (4, 4) reaches out of a region [m]; negative if it lies inside."""
    region_T_world = surroundings.lasting(
        ("region_T_world", region.name), lambda: np.linalg.inv(region.world_T_region)
    )
    region_T_body = region_T_world @ pose
    normals = region.normals @ region_T_body[:3, :3]
    offsets = region.offsets - region.normals @ region_T_body[:3, 3]
    farthest = -np.inf
    for number, element in enumerate(surroundings.scene.bodies[name].elements):
        points = surroundings.lasting(("corners", name, number), partial(_corners_of, surroundings, element))
        rounding = element.rounding or Rounding()
        along = np.ascontiguousarray((points @ normals.T).T)  # each row is read at once
        heights = along.max(axis=1) + rounding.reach(normals)
        farthest = max(farthest, float((heights - offsets).max()))
    return farthest


def _corners_of(surroundings: SceneSurroundings, element: Element) -> Array:
    """The corners (V, 3) of an element's hull, without its rounding; found once for each mesh."""
    if element.corners is not None:
        return element.corners
    vertices = element.mesh.vertices
    found: Array = surroundings.lasting(("hull", vertices.tobytes()), lambda: corners(vertices))
    return found
