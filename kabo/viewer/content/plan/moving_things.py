"""The things that move in a stretch of a plan's motion: links of the moving robots, and what hangs from them."""

from collections.abc import Sequence
from typing import NamedTuple

from kabo.arrays import Array
from kabo.geometry_server import GeometryServer
from kabo.plan import Plan
from kabo.planner.certify.motion_situation import MotionSituation
from kabo.planner.certify.motion_stretches import MotionStretch
from kabo.scene import Robot, Scene


class MovingThing(NamedTuple):
    """A thing on a joint of a robot's tree, and its pose (4, 4) in that joint's frame."""

    name: str
    robot: str
    joint: int
    joint_T: Array


def server_of(plan: Plan, scene: Scene) -> GeometryServer:
    """A geometry server with the accuracy for which a plan was made."""
    epsilon = plan.options.get("epsilon")
    return GeometryServer(scene, float(epsilon) if isinstance(epsilon, int | float) else None)


def moving_things(scene: Scene, situation: MotionSituation, stretch: MotionStretch) -> Sequence[MovingThing]:
    """The links with a mesh of the robots that a stretch moves, and all that they carry."""
    found = [
        MovingThing(f"{name}.{link.name}", name, link.joint, link.joint_T_link)
        for name in scene.robots
        if name in stretch.waypoints
        for link in scene.robots[name].links.values()
        if link.mesh is not None
    ]
    for name in scene.movable:
        where = situation.mounted(name) if name in situation.hung else None
        if where is not None and where.robot in stretch.waypoints:
            found.append(MovingThing(name, where.robot, where.joint, where.joint_T))
    return found


def moving_joints(robot: Robot, joint: int, waypoints: Array) -> frozenset[int]:
    """The joints between the world and a joint of a robot that move along way points (W, n)."""
    tree, found = robot.tree, set()
    while joint > 0:
        values = waypoints[:, int(tree.source[joint])]
        if values.max() > values.min():
            found.add(joint)
        joint = int(tree.parent[joint])
    return frozenset(found)
