"""Checks a loaded scene's numbers, which geometry relies on: nothing lies too far away, and joints are within limits."""

from collections.abc import Iterator, Mapping

import numpy as np

from kabo.arrays import Array
from kabo.errors import Diagnostic, did_you_mean
from kabo.language.formulas import Place
from kabo.language.scene_description import SceneDescription
from kabo.meshes import Mesh
from kabo.scene.mimic_limits import LIMITS_ARE_FROM
from kabo.scene.robots import Robot
from kabo.scene.tree import PRISMATIC

MAX_DISTANCE = 500.0  # [m] from the world's origin: up to here rounding takes half of its share of epsilon
LIMIT_SLACK = 1e-9  # [rad or m] by which a value may exceed its limit


def findings(
    description: SceneDescription,
    robots: Mapping[str, Robot],
    meshes: Mapping[str, Mesh],
    poses: Mapping[str, Array],
) -> Iterator[Diagnostic]:
    """A diagnostic for what lies too far away, for gripper values beyond limits, and for what stays behind a link.

    Args:
        description: the scene as described in its files.
        robots: the loaded robots.
        meshes: the meshes of the bodies.
        poses: world_T_body of the bodies.
    """
    for name, mesh in meshes.items():
        far = float(np.linalg.norm(poses[name][:3, 3]) + np.linalg.norm(mesh.vertices, axis=1).max())
        if not far <= MAX_DISTANCE:
            yield _too_far(description.bodies[name].place, f'body "{name}"', far)
    for name, robot in robots.items():
        far = _reach(robot)
        if not far <= MAX_DISTANCE:
            yield _too_far(description.robots[name].place, f'robot "{name}"', far)
        yield from _beyond_limits(description, name, robot)
    yield from _unknown_fingers(description, robots)
    yield from _left_behind(description, robots)


def _left_behind(description: SceneDescription, robots: Mapping[str, Robot]) -> Iterator[Diagnostic]:
    """A diagnostic for each fixed body, region and robot whose pose is in the frame of a link that moves.

    All three keep the place where the link is at first. What is on the link in truth would move with it, and nothing
    that is proven would hold.
    """
    frames = [("fixed body", each.name, each.pose) for each in description.bodies.values() if not each.movable]
    frames += [("region", each.name, each.pose) for each in description.regions.values()]
    frames += [("robot", each.name, each.base) for each in description.robots.values()]
    for kind, name, pose in frames:
        robot, dot, link = pose.frame.partition(".")
        if dot and robot in robots and not robots[robot].stands(link):
            at = pose.place or Place("scene", 1, 1)
            said = f'the {kind} "{name}" is placed on {pose.frame}, which moves, and would stay behind'
            hint = "a part of the robot belongs into its URDF; what it holds at first is `movable: true`"
            yield Diagnostic(at.file, at.line, at.column, said, hint, at.length)


def _unknown_fingers(description: SceneDescription, robots: Mapping[str, Robot]) -> Iterator[Diagnostic]:
    """A diagnostic for each joint in `fingers` of a grasp family that no gripper has that may use it."""
    for body in description.bodies.values():
        for family, grasp in body.grasps.items():
            users = [robot for name, robot in robots.items() if not grasp.robots or name in grasp.robots]
            known = sorted({joint for robot in users for joint in robot.gripper_joints})
            for joint in grasp.fingers or () if known else ():
                if joint not in known:
                    at = body.place or Place("scene", 1, 1)
                    said = (
                        f'`fingers` of grasp family "{family}" of "{body.name}": no gripper has a joint "{joint}"'
                    )
                    hint = did_you_mean(joint, known) or f"there are {', '.join(known)}"
                    yield Diagnostic(at.file, at.line, at.column, said, hint, at.length)


def _too_far(place: Place | None, thing: str, far: float) -> Diagnostic:
    at = place or Place("scene", 1, 1)
    said = f"{thing} reaches {far:.4g} m from the world's origin; kabo plans within {MAX_DISTANCE:g} m"
    hint = "lengths are metres; place the scene around its origin"
    return Diagnostic(at.file, at.line, at.column, said, hint, at.length)


def _reach(robot: Robot) -> float:
    """An upper bound of the distance of any point of the robot from the world's origin [m]."""
    tree = robot.tree
    steps = np.linalg.norm(tree.placement[:, 9:], axis=1)
    for joint in range(1, len(steps)):
        if tree.kind[joint] == PRISMATIC and tree.ratio[joint] != 0.0:
            source = tree.source[joint]
            most = max(abs(float(tree.lower[source])), abs(float(tree.upper[source])))
            steps[joint] += abs(float(tree.ratio[joint])) * most
        steps[joint] += abs(float(tree.shift[joint])) if tree.kind[joint] == PRISMATIC else 0.0
        steps[joint] += steps[tree.parent[joint]]
    far = float(steps.max())
    for link in robot.links.values():
        if link.mesh is not None and len(link.mesh.vertices):
            radius = float(
                np.linalg.norm(link.mesh.vertices, axis=1).max() + np.linalg.norm(link.joint_T_link[:3, 3])
            )
            far = max(far, float(steps[link.joint]) + radius)
    return far


def _beyond_limits(description: SceneDescription, name: str, robot: Robot) -> Iterator[Diagnostic]:
    """A diagnostic for each gripper value outside its joint's limits, in `open`, `closed` and grasp families."""
    gripper = description.robots[name].gripper
    limits = dict(zip(robot.joint_names, zip(robot.tree.lower, robot.tree.upper, strict=True), strict=True))
    given: list[tuple[str, Mapping[str, float], Place | None]] = []
    if gripper is not None:
        given += [("open", gripper.open, gripper.place), ("closed", gripper.closed, gripper.place)]
    for body in description.bodies.values():
        for family, grasp in body.grasps.items():
            if grasp.fingers is not None and (not grasp.robots or name in grasp.robots):
                given.append((f'`fingers` of grasp family "{family}" of "{body.name}"', grasp.fingers, body.place))
    for what, values, place in given:
        for joint, value in values.items():
            if joint not in limits or joint not in robot.gripper_joints:
                continue
            low, high = map(float, limits[joint])
            if not low - LIMIT_SLACK <= value <= high + LIMIT_SLACK:
                at = place or Place("scene", 1, 1)
                said = f"{what}: {joint} = {value:.6g} is outside its limits [{low:.6g}, {high:.6g}]"
                hint = f'they are those of robot "{name}": {LIMITS_ARE_FROM.removeprefix("they are ")}'
                yield Diagnostic(at.file, at.line, at.column, said, hint, at.length)
