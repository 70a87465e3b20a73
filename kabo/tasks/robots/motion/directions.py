"""Straight strokes of a tool: along a feature, a vector, or as a family of grasps or placements says."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import WORLD, Candidate, Frame, Roles, carried_frame, standing_frame, tool_frame
from kabo.language.scene_description import FeatureName, Stroke
from kabo.tasks.robots.scenes import TaskScene


@dataclass(frozen=True)
class Direction:
    """A stroke along (`sign` 1) or against (-1) a line, by a length [m] within bounds.

    Roles of the line: `tool`, `world`, and `this`: the object. `part` and `tolerance` [m] are those of a mate: no point
    of that body may leave its straight way by more.
    """

    stroke: Stroke
    this: str | None = None
    sign: int = 1
    part: str | None = None
    tolerance: float | None = None

    def reversed(self) -> "Direction":
        """The stroke in the other direction."""
        return replace(self, sign=-self.sign)

    def bounded(self, least: float | None, greatest: float | None) -> "Direction":
        """With other bounds of its length, where they are given."""
        stroke = self.stroke
        high = stroke.maximum if greatest is None else greatest
        low = min(stroke.minimum, high) if least is None else least
        return replace(self, stroke=replace(stroke, minimum=low, maximum=high))

    def vector(self, scene: TaskScene, robot: str, at: Candidate) -> Array:
        """The unit vector (3,) in the world, where the robot is at a candidate.

        Raises:
            ValueError: nobody has the feature.
        """
        along = self.stroke.along
        frame = roles(scene, robot, self.this).get(along.owner)
        feature = None if frame is None else frame.features.get(along.feature or "")
        if frame is None or feature is None or feature.direction is None:
            raise ValueError(f"a stroke goes along {along}, which has no direction here")
        unit = at.pose(frame)[:3, :3] @ np.asarray(feature.direction)
        return np.asarray(self.sign * self.stroke.sign * unit)


def roles(scene: TaskScene, robot: str, this: str | None) -> Roles:
    """The frames that features of strokes and constraints belong to: the tool, the world, and the object `this`."""
    chosen = scene.robot(robot)
    found: dict[str, Frame] = {"world": WORLD}
    if chosen.tool is not None:
        found["tool"] = tool_frame(chosen)
    if this is not None:
        found["this"] = frame_of(scene, robot, this)
    return found


def frame_of(scene: TaskScene, robot: str, name: str) -> Frame:
    """The frame of a body as the robot's tree has it: on a joint if the robot holds it, else in the world."""
    body = scene.context.scene.bodies[name]
    if scene.holder(name) == robot:
        return carried_frame(scene.robot(robot), body, scene.situation.held(name))
    return standing_frame(body, scene.pose(name))


def direction_of(value: Any, this: str | None) -> Direction | None:
    """A direction as a property gives it: a `Direction`, or {along or against: feature, distance}; None: nowhere.

    Raises:
        ValueError: it is none of these.
    """
    if value is None or isinstance(value, Direction):
        return value
    if isinstance(value, Stroke):
        return Direction(value, this)
    if isinstance(value, Mapping) and ("along" in value) != ("against" in value):
        owner, dot, feature = str(value.get("along", value.get("against"))).partition(".")
        low, high = _range(value.get("distance", (0.0, 0.0)))
        return Direction(Stroke(FeatureName(owner, feature), 1 if "along" in value else -1, low, high), this)
    raise ValueError(f"a direction is {{along or against: feature, distance: …}}, not {value!r}")


def _range(given: Any) -> tuple[float, float]:
    if isinstance(given, Sequence) and not isinstance(given, str):
        low, high = given
        return float(low), float(high)
    return float(given), float(given)
