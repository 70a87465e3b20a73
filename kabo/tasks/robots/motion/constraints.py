"""The motion constraint that a stage's property `keep` names, in rows for the robot's kinematic tree."""

from collections.abc import Mapping, Sequence
from typing import Any

from kabo.geometry_server import Keep, keep_constraint
from kabo.tasks.robots.scenes import TaskScene


def keep_of(scene: TaskScene, robot: str, given: Any) -> Keep | None:
    """The constraint that a motion must keep, for whatever the robot holds or for one held object; None if there is none.

    Args:
        scene: the scene, in which the robot holds the object of the constraint.
        robot: the robot that moves.
        given: the name of a motion constraint of the scene, or {object, constraint}; None or "": no constraint.

    Raises:
        ValueError: the scene has no motion constraint of that name.
    """
    held: Sequence[str] | None = None
    if isinstance(given, Mapping):
        held, given = [str(given["object"])], given.get("constraint")
    if not given:
        return None
    if given not in scene.context.scene.motion_constraints:
        names = ", ".join(scene.context.scene.motion_constraints) or "none"
        raise ValueError(f"the scene has no motion constraint {given!r}; it has {names}")
    return keep_constraint(scene.context, scene.robot(robot), scene.situation, given, held)
