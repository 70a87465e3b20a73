"""Proofs that something is out of reach, without sampling and independent of other objects.

A point on a chain is never farther from the chain's first moving joint than the sum of the lengths between the
joints. A constraint that demands a greater distance can never be fulfilled.
"""

from collections.abc import Iterable

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.configurations import joints_at
from kabo.geometry_server.frames import Frame, Roles
from kabo.kinematics import FrameFeature
from kabo.language.scene_description import Constraint, GraspFamily
from kabo.scene import PRISMATIC, Body, Drive, KinematicTree, Region, Robot

ROUNDING_ALLOWANCE = 1e-6  # [m]: rounding of the sums below is far smaller


def least_distance(robot: Robot, point: FrameFeature, feature: FrameFeature) -> float:
    """A lower bound [m] of the distance of a point on a robot from a feature of the world, whatever its joints do.

    Zero or less proves nothing.
    """
    joint, length = _chain(robot, point)
    drive = robot.drive
    if drive is None or joint != drive.joint:
        return _distance(_start(robot, joint), feature) - length
    if feature.kind != "point":
        return -length
    target = np.asarray(feature.origin)
    away = np.hypot(drive.missing(target[None])[0], target[2] - drive.world_T_floor[2, 3])
    return float(away) - length


def _chain(robot: Robot, point: FrameFeature) -> tuple[int, float]:
    """The first moving joint on the way from the base to a point, and the point's greatest distance [m] from it.

    A base that drives counts as its last joint, and distances are from the vertical axis about which it turns, at the
    height of that joint. If no joint moves the point, the joint is the one to which it is fixed.
    """
    tree, joint = robot.tree, point.joint
    total = float(np.linalg.norm(point.origin)) + ROUNDING_ALLOWANCE
    first = joint, total
    while joint > 0:
        if robot.drive is not None and joint == robot.drive.joint:
            return joint, total
        if tree.kind[joint] == PRISMATIC:
            total += _stroke(tree, joint)
        if tree.ratio[joint] != 0.0:
            first = joint, total
        total += float(np.linalg.norm(tree.placement[joint, 9:]))
        joint = int(tree.parent[joint])
    return first


def _stroke(tree: KinematicTree, joint: int) -> float:
    """How far [m] a sliding joint moves at most from where it is at zero, or has been locked there."""
    source, ratio, shift = tree.source[joint], tree.ratio[joint], tree.shift[joint]
    if ratio == 0.0:
        return float(abs(shift))
    return float(max(abs(ratio * end[source] + shift) for end in (tree.lower, tree.upper)))


def _start(robot: Robot, joint: int) -> Array:
    """The place (3,) in the world of a joint that none before it moves, before its own motion."""
    tree = robot.tree
    before = joints_at(tree, np.clip(0.0, tree.lower, tree.upper))
    if joint == 0 or tree.ratio[joint] == 0.0:
        return np.array(before[joint, 9:])
    parent, placement = before[tree.parent[joint]], tree.placement[joint]
    return np.array(parent[:9].reshape(3, 3) @ placement[9:] + parent[9:])


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
                worst = max(worst, least_distance(robot, point, target))
    return float(worst)


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
    points = [tool.moved(f) for f in tool.features.values() if f.kind == "point"]
    if not points or not np.isfinite(offset):
        return -np.inf
    drive, chains = robot.drive, [_chain(robot, point) for point in points]
    joint = chains[0][0]  # of all points: they are fixed to one link
    if drive is not None and joint == drive.joint:
        inside = _floor_distance(drive, region)
    else:
        inside = _region_distance(_start(robot, joint), region)
    return float(inside - max(length for _, length in chains) - offset)


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
