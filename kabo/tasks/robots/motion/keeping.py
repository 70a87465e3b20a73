"""Refusals about motion constraints: the robot holds nothing that one applies to, or a path violates one."""

from collections.abc import Mapping, Sequence
from typing import Any

from kabo.arrays import Array
from kabo.geometry_server import Keep, Refusal
from kabo.tasks.robots.motion.constraints import keep_of
from kabo.tasks.robots.scenes import TaskScene


def kept(scene: TaskScene, robot: str, given: Any) -> Keep | Refusal | None:
    """The constraint that a motion must keep, or None; a refusal if the robot holds nothing that it applies to."""
    found, name = keep_of(scene, robot, given), given.get("constraint") if isinstance(given, Mapping) else given
    if found is not None or not name:
        return found
    carried = scene.situation.carried(robot)
    if isinstance(given, Mapping) and given["object"] not in carried:
        text = f"{robot} does not hold {given['object']}"
    else:
        text = f"it has no features for {' or '.join(carried)}" if carried else f"{robot} holds nothing"
    return Refusal("constraint", f"nothing can keep {name}: {text}", reads=frozenset(carried))


def not_kept(keep: Keep, path: Sequence[Array]) -> Refusal | None:
    """The failure of a path to keep a constraint, with the violation at its ends; None if the path is proven to keep it."""
    if keep.holds_along(path):
        return None
    for q, where in ((path[0], "where it begins"), (path[-1], "where it ends")):
        broken = keep.broken(q)
        if broken is not None:
            return Refusal("constraint", f"{keep.name} does not hold {where}: {broken}")
    return Refusal("constraint", f"{keep.name} would not be kept on the way")
