"""Which robots can grasp bodies that stand in an area: sampled inverse kinematics of a scene's grasp families."""

from collections.abc import Iterable

import numpy as np

from kabo.kinematics import FrameFeature, rows_of, sample, stacked
from kabo.language.scene_description import Feature, GraspFamily
from kabo.scene import Robot
from kabo.streams import stream_key

Box = tuple[float, float, float, float]  # x from, to, y from, to [m] in the world


def grasps_in(
    robot: Robot, family: GraspFamily, features: dict[str, Feature], area: Box, foot: float, tries: int
) -> int:
    """How many of `tries` random configurations can be projected onto a grasp of a body that stands in the area.

    The grasp constrains nothing about where in the area the body stands: the tool centre is kept above the area,
    and every constraint on the body's axis or base is taken with the vertical, or with the plane of its foot.
    """
    tool = robot.links[robot.tool.frame]
    tcp = _carried(robot.tool.features["tcp"], tool.joint, tool.joint_T_link)
    rows = [
        rows_of("height", tcp, _plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), area[0], area[1]),
        rows_of("height", tcp, _plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)), area[2], area[3]),
    ]
    for constraint in family.constraints:
        first = _carried(robot.tool.features[constraint.first.feature], tool.joint, tool.joint_T_link)
        second = features[constraint.second.feature]
        if constraint.kind == "coincident":
            if second.kind == "point":  # a line is the vertical through the area, wherever that is
                level = foot + second.origin[2]
                rows.append(rows_of("height", tcp, _plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), level, level))
            continue
        standing = FrameFeature(0, second.kind, (0.0, 0.0, foot + second.origin[2]), second.direction)
        rows.append(rows_of(constraint.kind, first, standing, constraint.lower, constraint.upper))
    active = np.arange(robot.tree.size) < robot.planned
    key = stream_key("reach", robot.name)
    _, ok = sample(robot.tree, stacked(rows), key, 0, tries, robot.tree.lower, robot.tree.upper, active)
    return int(ok.sum())


def spot(x: float, y: float) -> Box:
    """An area of one point."""
    return (x, x, y, y)


def around(spots: Iterable[tuple[float, float]]) -> Box:
    """The smallest area with all these points."""
    xs, ys = zip(*spots, strict=True)
    return (min(xs), max(xs), min(ys), max(ys))


def _plane(origin: tuple[float, float, float], normal: tuple[float, float, float]) -> FrameFeature:
    return FrameFeature(0, "plane", origin, normal)


def _carried(feature: Feature, joint: int, joint_T_link: np.ndarray) -> FrameFeature:
    rotation, shift = joint_T_link[:3, :3], joint_T_link[:3, 3]
    direction = None if feature.direction is None else tuple(rotation @ np.asarray(feature.direction))
    return FrameFeature(joint, feature.kind, tuple(rotation @ np.asarray(feature.origin) + shift), direction)
