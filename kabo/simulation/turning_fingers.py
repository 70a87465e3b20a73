"""Fingers that turn: what a motor must give so that they press with a force, at the places where they touch.

A finger that slides presses with what drives it. One that turns, or that linkages move, presses by virtual work: with
the force times the speed at which the place of contact closes, for a motor that turns at one radian a second.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.scene import REVOLUTE, Robot

FINGERS = 2  # that share the force of a hand, at least: one jaw presses against what stands
USUAL_ARM = 0.05  # [m] of a finger without a shape


@dataclass(frozen=True)
class Finger:
    """A link of a hand: its body in the model, and the middle of its shape (3,) in that body's frame [m]."""

    body: int
    middle: Array


@dataclass(frozen=True)
class TurningFingers:
    """The fingers of a hand of which some turn.

    Attributes:
        fingers: that may touch.
        motions: of each motor, how its joint and those coupled to it move: (motors, nv), signed to close.
        arms: of each motor, how fast the middles of fingers move when the hand is open [m].
    """

    fingers: tuple[Finger, ...]
    motions: Array
    arms: Array


def turns(robot: Robot) -> bool:
    """Whether some joint of a robot's gripper, or one coupled to it, turns."""
    own = {robot.joint_names.index(joint) for joint in (robot.gripper.joints if robot.gripper else ())}
    tree = robot.tree
    return any(
        tree.ratio[j] != 0.0 and tree.source[j] in own and tree.kind[j] == REVOLUTE
        for j in range(1, len(tree.parent))
    )


def arm_of(robot: Robot, joint: int) -> float:
    """How far the middle of what a joint carries, and of all beyond, is from its axis when all joints are at 0 [m]."""
    tree, offsets, found = robot.tree, {joint: np.eye(4)}, []
    for other in range(joint + 1, len(tree.parent)):
        if int(tree.parent[other]) in offsets:
            step = np.eye(4)
            step[:3, :3], step[:3, 3] = tree.placement[other, :9].reshape(3, 3), tree.placement[other, 9:]
            offsets[other] = offsets[int(tree.parent[other])] @ step
    for link in robot.links.values():
        if link.joint in offsets and link.mesh is not None:
            place = offsets[link.joint] @ link.joint_T_link @ np.append(middle(link.mesh.vertices), 1.0)
            found.append(float(np.hypot(place[0], place[1])))
    return max(found, default=USUAL_ARM)


def middles_of_fingers(robot: Robot) -> list[tuple[str, Array]]:
    """The links that touch, as `robot.link`, each with the middle (3,) of its shape in its frame [m]."""
    links = () if robot.gripper is None else robot.gripper.touch_links
    meshes = ((link, robot.links[link.partition(".")[2]].mesh) for link in links)
    return [(link, middle(mesh.vertices)) for link, mesh in meshes if mesh is not None]


def middle(points: Array) -> Array:
    """The middle (3,) of the bounding box of points (N, 3)."""
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2.0)


def levers_in_contact(
    library: Any,
    model: Any,
    data: Any,
    hand: TurningFingers,
    touching: Mapping[int, Sequence[tuple[Array, Array]]],
) -> Array:
    """Of each motor the torque per newton of the sum of normal forces (motors,) [m], positive as it turns to close.

    Args:
        library: MuJoCo. model, data: its. hand: whose motors.
        touching: of each finger's body that touches what is held, places (3,) and normals (3,).
    """
    jacobian, sums = np.zeros((3, model.nv)), np.zeros(len(hand.motions))
    for body, contacts in touching.items():
        speeds = np.zeros(len(hand.motions))
        for place, normal in contacts:
            library.mj_jac(model, data, jacobian, None, place, body)
            speeds += np.abs(hand.motions @ (normal @ jacobian))
        sums += speeds / len(contacts)
    return np.asarray(sums / max(FINGERS, len(touching)))


def arms_when_open(library: Any, model: Any, data: Any, fingers: Sequence[Finger], motions: Array) -> Array:
    """Of each motor how fast the middles of the fingers that it moves move, on average [m]."""
    jacobian, speeds = np.zeros((3, model.nv)), []
    for finger in fingers:
        place = data.xpos[finger.body] + data.xmat[finger.body].reshape(3, 3) @ finger.middle
        library.mj_jac(model, data, jacobian, None, place, finger.body)
        speeds.append(np.linalg.norm(motions @ jacobian.T, axis=1))
    table = np.array(speeds).reshape(-1, len(motions))
    moved = np.maximum((table > 0.0).sum(axis=0), 1)
    found = table.sum(axis=0) / moved
    return np.where(found > 0.0, found, USUAL_ARM)
