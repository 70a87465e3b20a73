"""What the moving things of a plan sweep, segment by segment: polyhedra that contain all of it, with few corners.

Between two way points, the bounding swept volume of a thing is hulls of its parts, each grown by a proven bound
[K 4.5, Eq. 4.19-4.22]. Of these hulls the extent in fourteen directions is kept: the polyhedron of the fourteen planes
contains them. It says where a thing can have been; it sticks out farther than what planning uses.
"""

from itertools import product
from typing import Any

import numpy as np
from scipy.spatial import HalfspaceIntersection

from kabo.arrays import Array
from kabo.geometry import Motion, MovingGroup, SweptVolume, swept_volume
from kabo.geometry_server import SceneSurroundings
from kabo.plan import Plan
from kabo.planner.certify.component_values import ComponentValues
from kabo.planner.certify.motion_situation import MotionSituation
from kabo.planner.certify.motion_stretches import MotionStretch, stretches
from kabo.scene.transforms import flat
from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.plan.moving_things import MovingThing, moving_joints, moving_things
from kabo.viewer.content.plan.off_path import farthest_off

TOLERANCE = 0.1  # [m] by which the hulls may stick out of what the parts sweep
GRID = 2.0**-10  # [m] corners are multiples of it, and planes are moved out by as much
_AXES = np.vstack([np.eye(3), [(1.0, y, z) for y, z in product((-1.0, 1.0), repeat=2)]])
DIRECTIONS = np.vstack([_AXES, -_AXES]) / np.linalg.norm(np.vstack([_AXES, _AXES]), axis=1)[:, None]  # (14, 3)


def sweeps_of(
    name: str, plan: Plan, values: ComponentValues, surroundings: SceneSurroundings, arrays: Arrays
) -> list[dict[str, Any]]:
    """What moves in each stretch of a node's motion: `from` and `to` [s], and convex polyhedra by their `corners`.

    Each of the `sizes` counts the corners of a polyhedron. Corners are whole numbers: times `step`, from `origin` on,
    they are metres.

    Raises:
        ValueError: something that moves may be in several places.
    """
    motion, scene = plan.nodes[name].motion, surroundings.scene
    situation = MotionSituation.at(name, values, scene, [segment.robot for segment in motion])
    found = []
    for stretch in stretches(motion, dict(scene.robots), situation.q):
        solids = []
        for thing in moving_things(scene, situation, stretch):
            solids += _swept(thing, stretch, surroundings)
        found.append(_view(solids, stretch, arrays))
        for i in stretch.ending:
            situation.end(motion[i])
    return found


def _swept(thing: MovingThing, stretch: MotionStretch, surroundings: SceneSurroundings) -> list[Array]:
    """The corners of a polyhedron around what a thing sweeps, for each piece of the path on which it moves."""
    robot, waypoints = surroundings.scene.robots[thing.robot], stretch.waypoints[thing.robot]
    mesh = surroundings.mesh(thing.name)
    if mesh is None or not moving_joints(robot, thing.joint, waypoints):
        return []
    arrays = mesh.vertices, mesh.faces
    enclosure, elements = surroundings.enclosure(thing.name), surroundings.elements(thing.name)
    group = MovingGroup(thing.joint, flat(thing.joint_T), enclosure, arrays, elements)
    radius = float(np.linalg.norm(mesh.vertices @ thing.joint_T[:3, :3].T + thing.joint_T[:3, 3], axis=1).max())
    found = []
    for k, ends in enumerate(zip(waypoints, waypoints[1:], strict=False)):
        if moving_joints(robot, thing.joint, np.array(ends)):
            off = farthest_off(robot.tree, thing.joint, radius, stretch.deviations[thing.robot][k])
            found.append(_around(swept_volume(Motion(robot.tree, (group,), np.array(ends)), TOLERANCE), off))
    return found


def _around(volume: SweptVolume, off: float) -> Array:
    """The corners (V, 3) of the polyhedron of fourteen planes around a volume, as multiples of GRID.

    The planes are moved out by `off` [m], how far the trajectory may be from the path.
    """
    farthest = [(hull.points @ DIRECTIONS.T).max(axis=0) + hull.growth for hull in volume.hulls]
    reach = np.max(farthest, axis=0) + GRID + off
    points = np.concatenate([hull.points for hull in volume.hulls])
    inside = (points.min(axis=0) + points.max(axis=0)) / 2.0
    halfspaces = np.column_stack([DIRECTIONS, -reach])
    if (halfspaces[:, :3] @ inside + halfspaces[:, 3]).max() > -1e-6:
        inside = points.mean(axis=0)  # within the hull of the points, which is within the planes
    corners = HalfspaceIntersection(halfspaces, inside).intersections
    return np.unique(np.round(corners / GRID), axis=0)


def _view(solids: list[Array], stretch: MotionStretch, arrays: Arrays) -> dict[str, Any]:
    corners = np.concatenate([np.zeros((0, 3)), *solids])
    lowest = corners.min(axis=0) if solids else np.zeros(3)
    numbers = corners - lowest
    return {
        "from": float(stretch.times[0]),
        "to": float(stretch.times[-1]),
        "step": GRID,
        "origin": [float(x) for x in lowest * GRID],
        "sizes": [len(solid) for solid in solids],
        "corners": arrays.add(numbers.astype(np.uint16 if numbers.max(initial=0) < 2**16 else np.uint32)),
    }
