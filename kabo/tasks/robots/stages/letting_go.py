"""Checks whether a gripper has room to open and to retreat from an object that it puts down.

There may be room for the object but not for the gripper. Checked when a placement is chosen, before any path to it is
searched for, this costs a few collision checks; found out only when the gripper opens, it would waste all work before.
"""

import numpy as np

from kabo.geometry_server import Refusal, candidate
from kabo.tasks.robots.motion.configurations import OPEN, goal_of
from kabo.tasks.robots.motion.directions import Direction
from kabo.tasks.robots.motion.groups import hung
from kabo.tasks.robots.motion.paths import grip, straight
from kabo.tasks.robots.motion.questions import along
from kabo.tasks.robots.scenes import TaskScene
from kabo.tasks.robots.stages.grasps import held_properties


def letting_go(scene: TaskScene, name: str, robot: str) -> Refusal | None:
    """The refusal if a gripper cannot open and retreat from an object put down at its present pose; or None.

    The gripper retreats along the approach of the grasp family, by its full length or the least length permitted.
    """
    held = scene.holder(name)
    if held != robot:
        return Refusal("constraint", f"{robot} does not hold {name}", reads=frozenset({name}), proof=True)
    opened = goal_of(scene, robot, OPEN)
    if not np.array_equal(opened, scene.configuration(robot)):
        moved = grip(scene, robot, opened)
        if isinstance(moved, Refusal):
            return moved
    retreat: Direction | None = held_properties(scene, scene.robot(robot), name).get("retreat")
    after = hung(scene.at(robot, opened), name, "world", np.eye(4))
    if retreat is not None:
        return _retreating(after, robot, retreat)
    hit = after.hit(robot)
    return None if hit is None else Refusal.collision(hit, question=along(after, robot, opened))


def _retreating(scene: TaskScene, robot: str, retreat: Direction) -> Refusal | None:
    """What keeps the hand from drawing back, all the way or as little as may be; None: nothing."""
    at, stroke = candidate(scene.robot(robot), scene.configuration(robot)), retreat.stroke
    unit = retreat.vector(scene, robot, at)
    moved = straight(scene, robot, stroke.maximum * unit)
    if isinstance(moved, Refusal) and stroke.minimum != stroke.maximum:
        moved = straight(scene, robot, stroke.minimum * unit)
    return moved if isinstance(moved, Refusal) else None
