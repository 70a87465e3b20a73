"""What a robot holds while it moves: how hard it may be accelerated, or why its gripper cannot hold it at all.

A gripper that has a force holds mass · |acceleration - gravity| <= friction · force. The mass is that of the body in the
hand and of all that is attached to it; the acceleration is that of the origin of the body in the hand.
"""

from collections.abc import Callable, Iterator

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Refusal, Situation, joints_at
from kabo.motion import Held
from kabo.scene import Attachment, Robot, Scene
from kabo.scene.transforms import transform
from kabo.tasks.robots.scenes import TaskScene


def held_by(scene: TaskScene, robot: str) -> Held | None:
    """What limits the acceleration of a robot's arm, from the values of its planned joints; None if nothing does.

    A body that may be held at several poses counts at each of them.
    """
    chosen = scene.robot(robot)
    if chosen.gripper is None or chosen.gripper.force is None:
        return None
    hand = scene.configuration(robot)[chosen.planned :]
    found = [
        Held(_places(chosen, hand, at), bound)
        for name, bound in bounds_of_held(scene.context.scene, scene.situation, chosen)
        for at in scene.situation.objects[name]
        if at.parent.startswith(f"{robot}.")
    ]
    if not found:
        return None
    tightest, *others = sorted(found, key=lambda each: each.acceleration)
    return Held(tightest.places, tightest.acceleration, others=tuple(others))


def too_heavy(scene: Scene, situation: Situation, robot: str, name: str | None = None) -> Refusal | None:
    """The refusal if a gripper cannot hold, even at rest, what it holds in a situation; None if it can.

    Args:
        scene: robots and bodies.
        situation: what is attached to what.
        robot: whose gripper.
        name: an object that counts as held with all that is attached to it; None: what is held in the situation.
    """
    chosen = scene.robots[robot]
    gripper = chosen.gripper
    if gripper is None or gripper.force is None:
        return None
    roots = _roots(situation, robot) if name is None else (name,)
    for root in roots:
        mass = _mass(scene, situation, root)
        if not gripper.holds(mass):
            text = f"{robot} cannot hold {root}, even at rest: {gripper.too_weak_for(mass)}"
            return Refusal("constraint", text, frozenset(situation.group(root)), proof=True)
    return None


def bounds_of_held(scene: Scene, situation: Situation, robot: Robot) -> Iterator[tuple[str, float]]:
    """The bodies that a robot's hand holds, each with the greatest norm of its acceleration minus gravity [m/s²].

    Bodies that nothing limits are left out.
    """
    if robot.gripper is None:
        return
    for name in _roots(situation, robot.name):
        bound = robot.gripper.greatest_acceleration(_mass(scene, situation, name))
        if bound is not None:
            yield name, bound


def _roots(situation: Situation, robot: str) -> tuple[str, ...]:
    """The objects that a robot's links may hold themselves."""
    objects = situation.objects
    return tuple(name for name in objects if any(a.parent.startswith(f"{robot}.") for a in objects[name]))


def _mass(scene: Scene, situation: Situation, name: str) -> float | None:
    """The mass [kg] of a body and all that is attached to it; None if no mass is known."""
    mass = sum(scene.bodies[each].mass or 0.0 for each in situation.group(name))
    return mass or None


def _places(robot: Robot, hand: Array, at: Attachment) -> Callable[[Array], Array]:
    """The positions (k, 3) in the world of what is held, from values (k, n) of the planned joints."""
    link = robot.links[at.parent.partition(".")[2]]
    place = (link.joint_T_link @ transform(at.position, at.quaternion))[:3, 3]

    def places(rows: Array) -> Array:
        poses = [joints_at(robot.tree, np.concatenate([row, hand]))[link.joint] for row in rows]
        flat = np.array(poses).reshape(len(rows), 12)
        return np.asarray(flat[:, 9:] + flat[:, :9].reshape(-1, 3, 3) @ place)

    return places
