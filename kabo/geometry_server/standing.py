"""What stands on what: the supports of an object, by its own placement families; and what lies inside a region."""

import numpy as np
import numpy.typing as npt

from kabo.geometry import contains
from kabo.geometry_server.frames import WORLD, fits, rows, standing_frame
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.surroundings import Surroundings
from kabo.kinematics import satisfied
from kabo.language.scene_description import Constraint
from kabo.scene import Body, KinematicTree, Region

Array = npt.NDArray[np.float64]

EXACTLY = 1e-4  # m, rad: how exactly a thing stands on its support


def _unmoved() -> KinematicTree:
    one, nothing = np.zeros(1, dtype=np.int64), np.empty(0)
    world = np.array([[1.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]])
    return KinematicTree(one, one, one, np.zeros(1), np.zeros(1), world, nothing, nothing, nothing)


NOTHING_MOVES = _unmoved()  # the tree of constraints between things that stand


def supports(surroundings: Surroundings, situation: Situation, name: str) -> tuple[str, ...]:
    """The bodies on which an object stands, by any of its placement families, in order of the scene."""
    body = surroundings.scene.bodies[name]
    (pose,) = surroundings.poses(situation, name)
    return tuple(
        other.name
        for other in surroundings.scene.bodies.values()
        if other is not body
        and any(
            _stands(surroundings, body, pose, other, under, family.constraints)
            for under in surroundings.poses(situation, other.name)
            for family in body.placements.values()
        )
    )


def _stands(
    surroundings: Surroundings,
    body: Body,
    pose: Array,
    under: Body,
    under_pose: Array,
    constraints: tuple[Constraint, ...],
) -> bool:
    roles = {"this": standing_frame(body, pose), "support": standing_frame(under, under_pose), "world": WORLD}
    about = [c for c in constraints if c.kind != "inside" and "support" in (c.first.owner, c.second.owner)]
    if not about or not fits(about, roles) or not _boxes_meet(surroundings, body, pose, under, under_pose):
        return False
    return satisfied(rows(about, roles), np.empty(0), NOTHING_MOVES, EXACTLY)


def _boxes_meet(surroundings: Surroundings, body: Body, pose: Array, under: Body, under_pose: Array) -> bool:
    low, high = _box(body, pose)
    key = "box", under.name, under_pose.tobytes()
    other_low, other_high = surroundings.remembered(key, lambda: _box(under, under_pose))
    return bool(np.all(low <= other_high + 1e-3) and np.all(other_low <= high + 1e-3))


def _box(body: Body, pose: Array) -> tuple[Array, Array]:
    points = body.mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
    return points.min(axis=0), points.max(axis=0)


def lies_inside(surroundings: Surroundings, name: str, pose: Array, region: Region) -> bool:
    """Whether a body at world_T_body (4, 4) is proven to lie inside a region: its convex parts do [K Def. 1]."""
    region_T_body = np.linalg.inv(region.world_T_region) @ pose
    points = np.concatenate(surroundings.enclosure(name).parts) @ region_T_body[:3, :3].T + region_T_body[:3, 3]
    return bool(contains((region.normals, region.offsets), points, surroundings.budget.numeric))
