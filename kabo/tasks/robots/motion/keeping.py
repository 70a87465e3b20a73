"""Refusals about motion constraints: nothing is held that one could be kept for, or a path breaks it."""

from collections.abc import Mapping, Sequence
from typing import Any

from kabo.arrays import Array
from kabo.geometry_server import Keep
from kabo.tasks.core import Failure
from kabo.tasks.robots.motion.constraints import keep_of
from kabo.tasks.robots.motion.refusals import refusal
from kabo.tasks.robots.scenes import TaskScene


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
