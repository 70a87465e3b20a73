"""Motion constraints that stages keep: what `keep` may say, as rows of the robot's tree."""

from collections.abc import Mapping, Sequence
from typing import Any

from kabo.geometry_server import Keep, keep_constraint
from kabo.tasks.core import Failure
from kabo.tasks.robots.declaring import refusal
from kabo.tasks.robots.scenes import Array, TaskScene


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


def kept(scene: TaskScene, robot: str, given: Any) -> Keep | Failure | None:
    """As `keep_of`; a failure where something is to be kept and there is nothing in the hand that it is about."""
    found, name = keep_of(scene, robot, given), given.get("constraint") if isinstance(given, Mapping) else given
    if found is not None or not name:
        return found
    carried = scene.situation.carried(robot)
    if isinstance(given, Mapping) and given["object"] not in carried:
        text = f"{robot} does not hold {given['object']}"
    else:
        text = f"it has no features for {' or '.join(carried)}" if carried else f"{robot} holds nothing"
    return refusal("constraint", f"nothing can keep {name}: {text}", reads=frozenset(carried))


def not_kept(keep: Keep, path: Sequence[Array]) -> Failure | None:
    """Where a path breaks a constraint, and by how much at its ends; None if it is proven to keep it."""
    if keep.holds_along(path):
        return None
    for q, where in ((path[0], "where it begins"), (path[-1], "where it ends")):
        broken = keep.broken(q)
        if broken is not None:
            return refusal("constraint", f"{keep.name} does not hold {where}: {broken}")
    return refusal("constraint", f"{keep.name} would not be kept on the way")
