"""What plans say of states, in a scene: joints by name, objects by parent and pose."""

from collections.abc import Collection, Iterable
from dataclasses import replace

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.plan import StateChange
from kabo.scene.scene import Scene
from kabo.scene.state import Attachment, Component, GeometricState


def with_change(scene: Scene, state: GeometricState, change: StateChange) -> GeometricState:
    """A state with what a plan says that is changed."""
    changes: dict[str, Component] = {}
    for name, joints in change.robots.items():
        robot, q = scene.robots[name], state.robots[name]
        changes[name] = tuple(joints.get(joint, value) for joint, value in zip(robot.joint_names, q, strict=True))
    for name, pose in change.objects.items():
        changes[name] = Attachment(pose.parent, pose.position, pose.quaternion)
    return state.replace(changes)


def beginning_at(scene: Scene, start: StateChange) -> Scene:
    """The scene with everything where a state has it at first.

    Raises:
        InputError: the state has a robot, joint or object that the scene does not have, or hangs one on nothing.
    """
    faults = [
        *_unknown(start.robots, scene.robots, "robot"),
        *_unknown(start.objects, scene.movable, "movable object"),
    ]
    for name in start.robots.keys() & scene.robots.keys():
        faults += _unknown(start.robots[name], scene.robots[name].joint_names, f"joint of {name}")
    links = [f"{robot.name}.{link}" for robot in scene.robots.values() for link in robot.links]
    parents = ["world", *scene.bodies, *links]
    faults += _unknown([pose.parent for pose in start.objects.values()], parents, "body or link")
    if faults:
        raise InputError(faults)
    return replace(scene, start=with_change(scene, scene.start, start), met=True)


def _unknown(names: Iterable[str], known: Collection[str], kind: str) -> list[Diagnostic]:
    return [
        Diagnostic("state", 1, 1, f"the scene has no {kind} {name}", did_you_mean(name, known))
        for name in dict.fromkeys(names)
        if name not in known
    ]
