"""Hands that cannot let go of what they hold at the start: opened, their fingers would lie in it, wherever the arm is.

An object that was shifted in a hand is held so. Fingers may touch it while they open, and not when the arm moves away.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from kabo import geometry  # its names load when they are used
from kabo.geometry_server.foresight.things import Thing
from kabo.scene import Scene, link_poses


@dataclass(frozen=True)
class Clutch:
    """A finger (`robot.link`) that lies in a held object when the hand is open, with the thing that it is then."""

    finger: str
    opened: Thing


def clutch(scene: Scene, robot: str, name: str, things: Sequence[Thing]) -> Clutch | None:
    """The first finger of a hand that meets the object which the hand holds at the start, when it is open; or None.

    Args:
        scene: the scene, with its start. robot, name: the robot and what it holds.
        things: all that stands at the start, as `things_at_start` has it.
    """
    own = scene.robots[robot]
    held = next((thing for thing in things if thing.name == name), None)
    if own.gripper is None or held is None:
        return None
    values = dict(zip(own.joint_names, scene.start.robots[robot], strict=True)) | dict(own.gripper.open)
    poses = link_poses(own, tuple(values[joint] for joint in own.joint_names))
    for finger in own.gripper.touch_links:
        mesh = own.links[finger.partition(".")[2]].mesh
        if mesh is None or scene.never_collide(finger, name):
            continue
        opened = Thing.at(finger, mesh, poses[finger.partition(".")[2]])
        if geometry.exact_collides(opened.group(), held.group()):
            return Clutch(finger, opened)
    return None
