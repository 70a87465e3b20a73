"""Frames and their features: names in constraints become points, lines and planes on the joints of one robot."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kabo.arrays import Array
from kabo.kinematics import FrameFeature, rows_of, stacked
from kabo.language.scene_description import Constraint, Feature, FeatureName
from kabo.scene import Attachment, Body, Robot
from kabo.scene.transforms import length, transform

WORLD_FEATURES = {
    "origin": Feature("point", (0.0, 0.0, 0.0)),
    "up": Feature("line", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "floor": Feature("plane", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
}


@dataclass(frozen=True)
class Frame:
    """A frame fixed to a joint of a robot's tree (0: the world), with the features defined in this frame."""

    joint: int
    joint_T_frame: Array  # (4, 4)
    features: Mapping[str, Feature]

    def feature(self, name: str) -> FrameFeature:
        """A feature of this frame by name, expressed in the joint's frame."""
        if name not in self._known:
            self._known[name] = self.moved(self.features[name])
        return self._known[name]

    @cached_property
    def _known(self) -> dict[str, FrameFeature]:
        return {}

    def moved(self, feature: Feature) -> FrameFeature:
        """A feature given in this frame, expressed in the joint's frame."""
        turn, shift = self.joint_T_frame[:3, :3], self.joint_T_frame[:3, 3]
        x, y, z = (turn @ np.asarray(feature.origin) + shift).tolist()
        if feature.direction is None:
            return FrameFeature(self.joint, feature.kind, (x, y, z))
        direction = turn @ np.asarray(feature.direction)
        dx, dy, dz = (direction / length(direction)).tolist()
        return FrameFeature(self.joint, feature.kind, (x, y, z), (dx, dy, dz))


Roles = Mapping[str, Frame]

WORLD = Frame(0, np.eye(4), WORLD_FEATURES)


def tool_frame(robot: Robot) -> Frame:
    """The frame of a robot's tool.

    Raises:
        ValueError: the robot has no tool.
    """
    if robot.tool is None:
        raise ValueError(f"robot {robot.name} has no tool")
    link = robot.links[robot.tool.frame]
    if "tool frame" not in robot.memory:
        robot.memory["tool frame"] = Frame(link.joint, link.joint_T_link, robot.tool.features)
    frame: Frame = robot.memory["tool frame"]
    return frame


def standing_frame(body: Body, world_T_body: Array) -> Frame:
    """The frame of a body that stands in the world."""
    return Frame(0, world_T_body, body.features)


def carried_frame(robot: Robot, body: Body, held: Attachment) -> Frame:
    """The frame of a body in the robot's hand."""
    link = robot.links[held.parent.partition(".")[2]]
    return Frame(link.joint, link.joint_T_link @ transform(held.position, held.quaternion), body.features)


def has(roles: Roles, name: FeatureName) -> bool:
    """Whether the feature that a constraint names exists in its role."""
    return name.owner in roles and (name.feature is None or name.feature in roles[name.owner].features)


def rows(constraints: Iterable[Constraint], roles: Roles) -> Array:
    """The rows (R, W) of all constraints; `inside` constraints have no rows, since they are checked after projection."""
    parts = []
    for constraint in constraints:
        if constraint.kind != "inside":
            first = roles[constraint.first.owner].feature(constraint.first.feature or "")
            second = roles[constraint.second.owner].feature(constraint.second.feature or "")
            parts.append(rows_of(constraint.kind, first, second, constraint.lower, constraint.upper))
    return stacked(parts)


def fits(constraints: Iterable[Constraint], roles: Roles) -> bool:
    """Whether every feature that the constraints name exists."""
    return all(has(roles, name) for c in constraints if c.kind != "inside" for name in (c.first, c.second))
