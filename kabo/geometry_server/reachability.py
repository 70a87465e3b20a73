"""Proofs that something is out of reach, without sampling and independent of other objects.

A point on a chain is never farther from the chain's first moving joint than the sum of the lengths between the
joints. A constraint that demands a greater distance can never be fulfilled.
"""

from collections.abc import Iterable

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.candidates import base_position
from kabo.geometry_server.frames import Frame, Roles
from kabo.kinematics import FrameFeature
from kabo.language.scene_description import Constraint, GraspFamily
from kabo.scene import PRISMATIC, Body, Drive, Region, Robot

ROUNDING_ALLOWANCE = 1e-6  # [m]: rounding of the sums below is far smaller


def reach(robot: Robot, point: FrameFeature) -> float:
    """An upper bound of the distance [m] of a point on the robot from its first moving joint.

    For a robot whose base drives: from the vertical axis about which the base turns, at the height of that joint.
    """
    tree, joint = robot.tree, point.joint
    total = float(np.linalg.norm(point.origin))
    while joint > 0:
        if robot.drive is not None and joint == robot.drive.joint:
            return total + ROUNDING_ALLOWANCE
        moves = tree.ratio[joint] != 0.0
        if moves and tree.kind[joint] == PRISMATIC:
            source, ratio, shift = tree.source[joint], tree.ratio[joint], tree.shift[joint]
            ends = (ratio * tree.lower[source] + shift, ratio * tree.upper[source] + shift)
            total += max(abs(ends[0]), abs(ends[1]))
        if moves and not _moves_before(robot, joint):
            return total + ROUNDING_ALLOWANCE
        total += float(np.linalg.norm(tree.placement[joint, 9:]))
        joint = int(tree.parent[joint])
    return total + ROUNDING_ALLOWANCE


def _moves_before(robot: Robot, joint: int) -> bool:
    parent = int(robot.tree.parent[joint])
    while parent > 0:
        if robot.tree.ratio[parent] != 0.0:
            return True
        parent = int(robot.tree.parent[parent])
    return False


def grasp_missing(robot: Robot, constraints: Iterable[Constraint], roles: Roles) -> float:
    """A lower bound [m] of how far the nearest grasp lies beyond the robot's reach; 0 or less proves nothing.

    It follows from `coincident` constraints of a point of the tool with a feature of the standing object.
    """
    worst = -np.inf
    for constraint in constraints:
        names = (constraint.first, constraint.second)
        tool = next((n for n in names if n.owner == "tool"), None)
        other = next((n for n in names if n.owner in ("this", "world")), None)
        if constraint.kind == "coincident" and tool is not None and other is not None:
            point = roles["tool"].feature(tool.feature or "")
            if point.kind == "point":
                target = roles[other.owner].feature(other.feature or "")
                worst = max(worst, base_distance(robot, target) - reach(robot, point))
    return float(worst)


def base_distance(robot: Robot, feature: FrameFeature) -> float:
    """A lower bound of the distance [m] of a feature from the point of which `reach` speaks, wherever the base may be."""
    drive = robot.drive
    if drive is None:
        return _distance(base_position(robot), feature)
    if feature.kind != "point":
        return 0.0
    target = np.asarray(feature.origin)
    return float(np.hypot(drive.missing(target[None])[0], target[2] - drive.world_T_floor[2, 3]))


def _distance(point: Array, feature: FrameFeature) -> float:
    offset = point - np.asarray(feature.origin)
    if feature.direction is None or feature.kind == "point":
        return float(np.linalg.norm(offset))
    along = float(offset @ np.asarray(feature.direction))
    if feature.kind == "plane":
        return abs(along)
    return float(np.sqrt(max(float(offset @ offset) - along * along, 0.0)))


def wherever(robot: Robot) -> str:
    """The end of a sentence about what is out of reach: that this holds for all places of a base that drives."""
    return "" if robot.drive is None else f", wherever on {robot.drive.floor} its base stands"


def region_missing(robot: Robot, body: Body, region: Region, tool: Frame) -> float:
    """A lower bound [m] of how far a region lies beyond the robot's reach with the body in its hand, for any grasp.

    Zero or less proves nothing. Some point of the body must lie in the region, and every point of the body lies
    within its diameter of the grasp, which is a point of the body or on the axis of a family that bounds its
    height.
    """
    offset = max((_grasp_offset(body, family) for family in body.grasps.values()), default=np.inf)
    drive = robot.drive
    inside = _region_distance(base_position(robot), region) if drive is None else _floor_distance(drive, region)
    points = [tool.moved(f) for f in tool.features.values() if f.kind == "point"]
    if not points or not np.isfinite(offset):
        return -np.inf
    return float(inside - max(reach(robot, p) for p in points) - offset)


def _region_distance(point: Array, region: Region) -> float:
    local = region.world_T_region[:3, :3].T @ (point - region.world_T_region[:3, 3])
    return float(np.max(region.normals @ local - region.offsets))


def _floor_distance(drive: Drive, region: Region) -> float:
    """A lower bound of the distance [m] of a region from the place of a base's axis, wherever the base may be."""
    signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
    corners = (signs * region.size) @ region.world_T_region[:3, :3].T + region.world_T_region[:3, 3]
    local = (corners - drive.world_T_floor[:3, 3]) @ drive.world_T_floor[:3, :2]
    return float((local @ drive.normals.T - drive.offsets).min(axis=0).max() + drive.inset)


def _grasp_offset(body: Body, family: GraspFamily) -> float:
    """An upper bound [m] of the distance of any point of the body from the tool point in a grasp of the family."""
    line = None
    for constraint in family.constraints:
        names = (constraint.first, constraint.second)
        this = next((n for n in names if n.owner == "this"), None)
        tool = next((n for n in names if n.owner == "tool"), None)
        if this is None or tool is None or this.feature is None:
            continue
        feature = body.features[this.feature]
        if constraint.kind == "coincident" and feature.kind == "point":
            return _farthest(body.mesh.vertices, np.asarray(feature.origin))
        if constraint.kind == "coincident" and feature.kind == "line":
            line = feature
    ends = _height_range(body, family)
    if line is None or ends is None or line.direction is None:
        return np.inf
    plane, low, high = ends
    through, along = np.asarray(line.origin), np.asarray(line.direction)
    normal, foot = np.asarray(plane[1]), np.asarray(plane[0])
    rise = float(normal @ along)
    if abs(rise) < 1e-6:
        return np.inf
    tips = [through + along * ((h - normal @ (through - foot)) / rise) for h in (low, high)]
    return max(_farthest(body.mesh.vertices, tip) for tip in tips)


def _farthest(points: Array, point: Array) -> float:
    """The greatest distance [m] of any of the points (V, 3) from a point."""
    x, y, z = (points[:, k] - point[k] for k in range(3))  # sums over rows of three take several times longer
    return float(np.sqrt((x * x + y * y + z * z).max()))


def _height_range(body: Body, family: GraspFamily) -> tuple[tuple[Array, Array], float, float] | None:
    for constraint in family.constraints:
        if constraint.kind == "height" and constraint.second.owner == "this":
            plane = body.features[constraint.second.feature or ""]
            if constraint.lower is not None and constraint.upper is not None and plane.direction is not None:
                return (np.asarray(plane.origin), np.asarray(plane.direction)), constraint.lower, constraint.upper
    return None
