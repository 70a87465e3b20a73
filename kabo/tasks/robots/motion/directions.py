"""Straight strokes of a tool: along a feature or a vector, or as a family of grasps or placements prescribes."""

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
    """A straight stroke along a line (`sign` 1) or against it (`sign` -1), with a length [m] within bounds.

    The line's owner is one of the roles `tool`, `world` and `this` (the object). Of a mate's insertion, no point of the
    body `part` may leave its straight path by more than `tolerance` [m].
    """

    stroke: Stroke
    this: str | None = None
    sign: int = 1
    part: str | None = None
    tolerance: float | None = None

    def reversed(self) -> "Direction":
        """The stroke in the opposite direction."""
        return replace(self, sign=-self.sign)

    def bounded(self, least: float | None, greatest: float | None) -> "Direction":
        """The same stroke with other bounds of its length; None keeps a bound."""
        stroke = self.stroke
        high = stroke.maximum if greatest is None else greatest
        low = min(stroke.minimum, high) if least is None else least
        return replace(self, stroke=replace(stroke, minimum=low, maximum=high))

    def vector(self, scene: TaskScene, robot: str, at: Candidate) -> Array:
        """The unit vector (3,) of the stroke in the world when the robot is at the candidate configuration.

        Raises:
            ValueError: the thing in the line's role lacks the feature.
        """
        along = self.stroke.along
        frame = roles(scene, robot, self.this).get(along.owner)
        feature = None if frame is None else frame.features.get(along.feature or "")
        if frame is None or feature is None or feature.direction is None:
            raise ValueError(f"a stroke goes along {along}, which has no direction here")
        unit = at.pose(frame)[:3, :3] @ np.asarray(feature.direction)
        return np.asarray(self.sign * self.stroke.sign * unit)


def roles(scene: TaskScene, robot: str, this: str | None) -> Roles:
    """The frames by role that features of strokes and constraints belong to: `tool`, `world`, and the object `this`."""
    chosen = scene.robot(robot)
    found: dict[str, Frame] = {"world": WORLD}
    if chosen.tool is not None:
        found["tool"] = tool_frame(chosen)
    if this is not None:
        found["this"] = frame_of(scene, robot, this)
    return found


def frame_of(scene: TaskScene, robot: str, name: str) -> Frame:
    """The frame of a body in the robot's kinematic tree: on a joint if the robot holds it, else fixed in the world."""
    body = scene.context.scene.bodies[name]
    if scene.holder(name) == robot:
        return carried_frame(scene.robot(robot), body, scene.situation.held(name))
    return standing_frame(body, scene.pose(name))


def direction_of(value: Any, this: str | None) -> Direction | None:
    """The direction that a property describes: a `Direction`, or {along or against: feature, distance}; None: no stroke.

    Raises:
        ValueError: the value is neither of these, and not None.
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
