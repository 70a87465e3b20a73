"""Motion constraints that stages keep: what `keep` may say, as rows of the robot's tree."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from kabo.arrays import Array
from kabo.geometry_server import Keep, Situation, keep_constraint
from kabo.tasks.core import Container, Failure, Stage
from kabo.tasks.robots.declaring import RobotStage, refusal
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


def keep_faults(stage: RobotStage, start: Situation | None) -> Iterator[str]:
    """Why a stage's `keep` means nothing, as far as that is known before planning: it keeps something in an empty hand."""
    given, robot = stage.known("keep"), stage.known("robot")
    if not given or start is None or robot not in start.robots or start.carried(robot):
        return
    top: Stage = stage
    while top.parent is not None:
        top = top.parent
    if isinstance(top, Container) and not any(_may_take(each) for each in top.walk()):
        name = given.get("constraint") if isinstance(given, Mapping) else given
        yield f"nothing can keep {name}: {robot} holds nothing, and nothing is taken in this task"


def _may_take(stage: Stage) -> bool:
    """Whether an object may be in a hand after a stage, which was not before."""
    moving = isinstance(stage, RobotStage) and ("object" in stage.MOVES or stage.properties.has("scene"))
    return moving or not (isinstance(stage, (RobotStage, Container)) or type(stage).__module__.startswith("kabo."))


def not_kept(keep: Keep, path: Sequence[Array]) -> Failure | None:
    """Where a path breaks a constraint, and by how much at its ends; None if it is proven to keep it."""
    if keep.holds_along(path):
        return None
    for q, where in ((path[0], "where it begins"), (path[-1], "where it ends")):
        broken = keep.broken(q)
        if broken is not None:
            return refusal("constraint", f"{keep.name} does not hold {where}: {broken}")
    return refusal("constraint", f"{keep.name} would not be kept on the way")
