"""What plans say of states, in a scene: joints by name, objects by parent and pose."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from math import hypot, isfinite

import numpy as np

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.plan import StateChange
from kabo.scene.bounds import MAX_DISTANCE
from kabo.scene.scene import Scene, attachment, world_T
from kabo.scene.state import Attachment, Component, GeometricState
from kabo.scene.transforms import inverse

BEYOND = 1e-6  # [rad or m] by which joints may be beyond their limits, and a quaternion longer or shorter than 1


def with_hand_action(
    scene: Scene,
    state: GeometricState,
    robot: str,
    *,
    detach: Iterable[str] = (),
    attach: Iterable[tuple[str, str]] = (),
) -> GeometricState:
    """The state after a robot has let go of bodies and taken others; they stay where they are in the world.

    What another robot has taken from its hand meanwhile stays with that one.

    Args:
        scene: the scene.
        state: the state before.
        robot: the robot whose hand acts.
        detach: the bodies that it lets go of.
        attach: the bodies that it takes or joins to others, each with what it hangs on from then on.
    """
    held = ((name, "world") for name in detach if _hangs_on(state, name).partition(".")[0] == robot)
    for name, parent in (*held, *attach):
        pose = inverse(world_T(scene, state, parent)) @ world_T(scene, state, name)
        state = state.replace({name: attachment(parent, pose)})
    return state


def _hangs_on(state: GeometricState, name: str) -> str:
    """The world, or the link that a body hangs on, be it by other bodies."""
    while name in state.objects:
        name = state.objects[name].parent
    return name


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
        InputError: the state has what the scene does not have, lacks what the scene has, hangs an object on nothing or on
            itself, or has numbers that are no joint values or no pose.
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
    faults = faults or [
        *_missing(scene, start),
        *_bad_joints(scene, start),
        *_bad_poses(start),
        *_circles(scene, start),
    ]
    if not faults:
        state = with_change(scene, scene.start, start)
        faults = list(_too_far(scene, state))
    if faults:
        raise InputError(faults)
    return replace(scene, start=state, met=True)


def _missing(scene: Scene, start: StateChange) -> Iterator[Diagnostic]:
    """A diagnostic for each robot, joint and movable object of which a state does not say where it is."""
    things = [f"robot {name}" for name in scene.robots if name not in start.robots]
    for name in start.robots:
        joints = scene.robots[name].joint_names
        things += [f"{joint} of {name}" for joint in joints if joint not in start.robots[name]]
    things += [name for name in scene.movable if name not in start.objects]
    for thing in things:
        yield Diagnostic("state", 1, 1, f"the state does not say where {thing} is", None)


def _too_far(scene: Scene, state: GeometricState) -> Iterator[Diagnostic]:
    """A diagnostic for each movable object that lies farther away than geometry reaches."""
    for name in scene.movable:
        far = float(np.linalg.norm(world_T(scene, state, name)[:3, 3]))
        far += float(np.linalg.norm(scene.bodies[name].mesh.vertices, axis=1).max(initial=0.0))
        if not far <= MAX_DISTANCE:
            yield _far(name, far)


def _bad_joints(scene: Scene, start: StateChange) -> Iterator[Diagnostic]:
    for name, joints in start.robots.items():
        robot = scene.robots[name]
        for joint, value in joints.items():
            number = robot.joint_names.index(joint)
            low, high = float(robot.tree.lower[number]), float(robot.tree.upper[number])
            if not low - BEYOND <= value <= high + BEYOND:
                text = f"{joint} of {name} is at {value:g}, outside its limits {low:g} to {high:g}"
                yield Diagnostic("state", 1, 1, text, None)


def _bad_poses(start: StateChange) -> Iterator[Diagnostic]:
    for name, pose in start.objects.items():
        if not all(map(isfinite, (*pose.position, *pose.quaternion))):
            yield Diagnostic("state", 1, 1, f"the pose of {name} has a number that is not finite", None)
        elif abs(hypot(*pose.quaternion) - 1.0) > BEYOND:
            yield Diagnostic("state", 1, 1, f"the quaternion of {name} has not the length 1", "order: x, y, z, w")
        elif hypot(*pose.position) > MAX_DISTANCE:
            yield _far(name, hypot(*pose.position))


def _far(name: str, metres: float) -> Diagnostic:
    text = f"{name} reaches {metres:.4g} m from the world's origin; kabo plans within {MAX_DISTANCE:g} m"
    return Diagnostic("state", 1, 1, text, "lengths are metres")


def _circles(scene: Scene, start: StateChange) -> Iterator[Diagnostic]:
    parents = {name: own.parent for name, own in scene.start.objects.items()}
    parents |= {name: pose.parent for name, pose in start.objects.items()}
    for name in start.objects:
        above, met = parents[name], {name}
        while above in parents and above not in met:
            met.add(above)
            above = parents[above]
        if above == name:
            yield Diagnostic(
                "state", 1, 1, f"{name} hangs on itself", "a parent is world, a link or another object"
            )


def _unknown(names: Iterable[str], known: Collection[str], kind: str) -> list[Diagnostic]:
    return [
        Diagnostic("state", 1, 1, f"the scene has no {kind} {name}", did_you_mean(name, known))
        for name in dict.fromkeys(names)
        if name not in known
    ]
