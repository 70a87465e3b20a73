"""Whether a hand has room to let go: opened, and drawn back, beside what stands around what it puts down.

A place for an object is not one for the hand. Asked where the object is put, before any way there is looked for, it
costs a few checks; asked when the hand opens, everything before was in vain.
"""

from typing import Any

import numpy as np

from kabo.geometry_server import Candidate, Refused, candidate, line, tool_frame
from kabo.tasks.core import Failure
from kabo.tasks.robots.motion.configurations import OPEN, goal_of
from kabo.tasks.robots.motion.directions import Direction
from kabo.tasks.robots.motion.groups import hung
from kabo.tasks.robots.motion.paths import grip
from kabo.tasks.robots.motion.questions import along
from kabo.tasks.robots.motion.refusals import refusal
from kabo.tasks.robots.scenes import TaskScene
from kabo.tasks.robots.stages.grasps import held_properties


def letting_go(scene: TaskScene, name: str, robot: str) -> Failure | None:
    """What keeps a robot's hand from opening and leaving an object that stands where it is held; None: nothing.

    The way back is the one that the grasp's family came on, all of it, or as little as may be.
    """
    held = scene.holder(name)
    if held != robot:
        return refusal("constraint", f"{robot} does not hold {name}", reads=frozenset({name}), proof=True)
    opened = goal_of(scene, robot, OPEN)
    if not np.array_equal(opened, scene.configuration(robot)):
        moved = grip(scene, robot, opened)
        if isinstance(moved, Failure):
            return moved
    retreat: Direction | None = held_properties(scene, scene.robot(robot), name).get("retreat")
    after = hung(scene.at(robot, opened), name, "world", np.eye(4))
    if retreat is not None:
        return _retreating(after, robot, retreat)
    hit = after.hit(robot)
    return None if hit is None else refusal("collision", hit=hit, question=along(after, robot, opened))


def _retreating(scene: TaskScene, robot: str, retreat: Direction) -> Failure | None:
    at: Candidate = candidate(scene.robot(robot), scene.configuration(robot))
    unit, found = retreat.vector(scene, robot, at), Refused()
    for distance in dict.fromkeys((retreat.stroke.maximum, retreat.stroke.minimum)):
        moved: Any = line(scene.workspace(robot), at.q, tool_frame(scene.robot(robot)), distance * unit)
        if not isinstance(moved, Refused):
            return None
        found = moved
    if not found.pairs:
        return refusal("constraint", "off the straight line")
    return refusal("collision", pairs=found.pairs, question=along(scene, robot, *found.waypoints))
