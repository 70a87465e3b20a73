"""The motion constraint that a stage's property `keep` names, as rows of the robot's tree."""

from collections.abc import Mapping, Sequence
from typing import Any

from kabo.geometry_server import Keep, keep_constraint
from kabo.tasks.robots.scenes import TaskScene


def keep_of(scene: TaskScene, robot: str, given: Any) -> Keep | None:
    """The constraint that a motion keeps: by name, for what the robot holds, or for one object of it; or None.

    Args:
        scene: in which the robot holds what the constraint is about.
        robot: the robot that moves.
        given: a name of the scene's motion constraints, {object, constraint}; None or "": nothing is kept.

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
