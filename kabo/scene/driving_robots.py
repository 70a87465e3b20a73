"""Robots whose base drives: the joints of the base put into the URDF, and its floor.

Source: docs/reference/scenes.md#mobile-bases.
"""

import math
from dataclasses import replace
from xml.etree import ElementTree  # noqa: S405  what is parsed was written by `urdf_files`

import numpy as np

from kabo.arrays import Array
from kabo.errors import did_you_mean
from kabo.language.formulas import Place
from kabo.language.scene_description import FARTHEST, DriveDescription, RobotDescription
from kabo.scene.drives import BASE_VALUES, Drive, edges_of, hull_of_points
from kabo.scene.robots import Robot, link_pose, link_poses
from kabo.scene.tree import PRISMATIC, REVOLUTE
from kabo.scene.urdf_file import refusal

UPRIGHT_TOLERANCE = 1e-6  # of the entries of rotations: up to here a base counts as upright
_TRIAL_POSES = ((0.7, -0.4, 0.0), (0.0, 0.0, 1.1), (-0.3, 0.5, -0.6))  # x, y [m], yaw [rad]
_TURNS_TRIED = 64  # to tell by how much a floor is too small


def with_base_joints(text: str, drive: DriveDescription) -> str:
    """The URDF text with joints x, y and yaw before the root link, or in place of a planar or floating joint of the root.

    A robot that has joints of these names keeps its own.

    Raises:
        InputError: it has one or two of them.
    """
    robot = ElementTree.fromstring(text)  # noqa: S314
    joints = {joint.get("name", ""): joint for joint in robot.findall("joint")}
    own = [name for name in drive.joints if name in joints]
    if len(own) == BASE_VALUES:
        return text
    if own:
        told = f'the robot has the joint "{own[0]}" and not all of {", ".join(drive.joints)}'
        raise refusal(drive.place, told, "name three joints of the robot, or three new ones: joints: [x, y, yaw]")
    loose = next((j for j in joints.values() if j.get("type") in ("planar", "floating")), None)
    if loose is None:
        children = {child.get("link") for joint in joints.values() for child in joint.findall("child")}
        below = next(name for link in robot.findall("link") if (name := link.get("name", "")) not in children)
        above, origin = f"{drive.joints[0]}/floor", None
        ElementTree.SubElement(robot, "link", {"name": above})
    else:
        robot.remove(loose)
        ends = [loose.find(tag) for tag in ("parent", "child")]
        above, below = ("" if end is None else end.get("link", "") for end in ends)
        origin = loose.find("origin")
    _append(robot, drive, above, below, origin)
    return ElementTree.tostring(robot, encoding="unicode")


def _append(
    robot: ElementTree.Element, drive: DriveDescription, above: str, below: str, origin: ElementTree.Element | None
) -> None:
    between = [f"{name}/slide" for name in drive.joints[:2]]
    links = [above, *between, below]
    for name in between:
        ElementTree.SubElement(robot, "link", {"name": name})
    axes = ("1 0 0", "0 1 0", "0 0 1")
    ranges = ((-FARTHEST, FARTHEST), (-FARTHEST, FARTHEST), drive.turn)
    for k, (name, axis, (low, high)) in enumerate(zip(drive.joints, axes, ranges, strict=True)):
        kind, speed = ("revolute", drive.turn_speed) if k == 2 else ("prismatic", drive.speed)
        joint = ElementTree.SubElement(robot, "joint", {"name": name, "type": kind})
        if k == 0 and origin is not None:
            joint.append(origin)
        ElementTree.SubElement(joint, "parent", {"link": links[k]})
        ElementTree.SubElement(joint, "child", {"link": links[k + 1]})
        ElementTree.SubElement(joint, "axis", {"xyz": axis})
        limits = {"lower": repr(low), "upper": repr(high), "velocity": repr(speed), "effort": "0"}
        ElementTree.SubElement(joint, "limit", limits)


def base_first(
    joints: tuple[str, ...] | None, movable: list[str], drive: DriveDescription | None
) -> tuple[str, ...]:
    """The planned joints, with those of a base that drives before the others.

    Args:
        joints: as the scene names them; None: all movable ones.
        movable: the robot's joints that may be planned.
        drive: how the base drives; None: it stands.
    """
    chosen = tuple(movable) if joints is None else joints
    if drive is None:
        return chosen
    return (*drive.joints, *(name for name in chosen if name not in drive.joints))


def full_configurations(description: RobotDescription, planned: int) -> dict[str, tuple[float, ...]]:
    """The named configurations with all planned values: where a robot that drives has the arm's only, its base is at 0."""
    if description.drive is None:
        return dict(description.configurations)
    zeros = (0.0,) * BASE_VALUES
    return {
        name: (*zeros, *values) if len(values) == planned - BASE_VALUES else values
        for name, values in description.configurations.items()
    }


def on_floor(robot: Robot, description: RobotDescription, outline: Array) -> Robot:
    """The robot on its floor, with the limits of its base that this floor leaves.

    Args:
        robot: the robot, with the base's joints first.
        description: its entry in the scene.
        outline: points (P, 3) of the floor region in the world, whose hull it is.

    Raises:
        InputError: the base's joints are no x, y and yaw on a level floor, or the base does not fit onto it.
    """
    assert description.drive is not None
    drive = _drive(robot, description.drive, outline)
    place = description.drive.place
    if drive.travel is None and description.drive.travel is not None:
        known = did_you_mean(description.drive.travel, robot.configurations)
        raise refusal(place, f'no configuration "{description.drive.travel}" to travel in', known)
    for name, values in {"": robot.start(description)[: robot.planned], **robot.configurations}.items():
        if len(values) == robot.planned:
            _check_inside(drive, np.array(values[:BASE_VALUES]), name, robot.name, place)
    low, high = drive.box()
    lower, upper = robot.tree.lower.copy(), robot.tree.upper.copy()
    lower[:2], upper[:2] = np.maximum(lower[:2], low), np.minimum(upper[:2], high)
    return replace(robot, drive=drive, tree=robot.tree._replace(lower=lower, upper=upper))


def _drive(robot: Robot, described: DriveDescription, outline: Array) -> Drive:
    joint, world_T_floor = _planar(robot, described)
    links = robot.links_on(joint)
    shaped = [robot.links[name] for name in links]
    local = (outline - world_T_floor[:3, 3]) @ world_T_floor[:3, :2]
    corners = hull_of_points(local)
    if len(corners) < 3:
        raise refusal(described.place, f'the floor "{described.within}" has no area seen from above')
    points = [] if links else [np.zeros((1, 3))]
    at_zero, floor_T_world = link_poses(robot, [0.0] * len(robot.joint_names)), np.linalg.inv(world_T_floor)
    for link in shaped:  # those of wheels, on joints that are not planned, too
        placed, mesh = floor_T_world @ at_zero[link.name], link.mesh
        assert mesh is not None
        points.append(mesh.vertices @ placed[:3, :3].T + placed[:3, 3])
    travel = None if described.travel is None else robot.configurations.get(described.travel)
    arm = None if travel is None else travel[BASE_VALUES:]
    footprint = hull_of_points(np.concatenate(points)[:, :2])
    bare = next(name for name, link in robot.links.items() if link.joint == joint)
    return Drive(described.within, joint, links or (bare,), world_T_floor, *edges_of(corners), footprint, arm)


def _planar(robot: Robot, described: DriveDescription) -> tuple[int, Array]:
    """The joint that turns the base, and the frame of the floor in the world.

    Raises:
        InputError: the three joints do not move the base along x and y and about the vertical, in this order.
    """
    tree, names = robot.tree, ", ".join(described.joints)
    sources = [
        [j for j in range(1, len(tree.parent)) if tree.source[j] == k and tree.ratio[j] != 0.0] for k in range(3)
    ]
    fault = refusal(
        described.place,
        f"the joints {names} do not slide along x, along y and turn about the vertical, one after the other",
        "give the base an upright pose, and name joints of a horizontal x, y and yaw",
    )
    if any(len(each) != 1 for each in sources):
        raise fault
    moved = [each[0] for each in sources]
    if [int(tree.kind[j]) for j in moved] != [PRISMATIC, PRISMATIC, REVOLUTE] or sorted(moved) != moved:
        raise fault
    joint = moved[2]
    at_zero = _joint_pose(robot, joint, (0.0, 0.0, 0.0))
    along = _joint_pose(robot, joint, (1.0, 0.0, 0.0))[:3, 3] - at_zero[:3, 3]
    floor = np.eye(4)
    floor[:3, 3] = at_zero[:3, 3]
    floor[:3, 0], floor[:3, 1] = along, np.cross((0.0, 0.0, 1.0), along)
    floor_T_joint = np.linalg.inv(floor) @ at_zero if abs(np.linalg.det(floor)) > 0.5 else np.full((4, 4), np.nan)
    for pose in _TRIAL_POSES:
        if not np.allclose(
            _joint_pose(robot, joint, pose), floor @ _moved(pose) @ floor_T_joint, atol=UPRIGHT_TOLERANCE
        ):
            raise fault
    return joint, floor


def _joint_pose(robot: Robot, joint: int, pose: tuple[float, float, float]) -> Array:
    """The pose world_T_joint (4, 4) in the convention of the tree, with the base at a pose and the other joints at zero."""
    q = [*pose, *([0.0] * (len(robot.joint_names) - BASE_VALUES))]
    name = next(name for name, link in robot.links.items() if link.joint == joint)
    return np.asarray(link_pose(robot, q, name) @ np.linalg.inv(robot.links[name].joint_T_link))


def _moved(pose: tuple[float, float, float]) -> Array:
    x, y, yaw = pose
    result = np.eye(4)
    result[:2, :2] = [[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]]
    result[:2, 3] = x, y
    return result


def _check_inside(drive: Drive, pose: Array, name: str, robot: str, place: Place | None) -> None:
    out = float(drive.outside(pose[None])[0])
    if out <= 0.0:
        return
    lacking = too_small(drive)
    if lacking > 0.0:
        told = f'the floor "{drive.floor}" is too small for the base of "{robot}", at whatever turn:'
        raise refusal(place, f"{told} it lacks {lacking:.3g} m to every side", "make the region larger")
    where = f'in configuration "{name}"' if name else "where it begins"
    text = f'{where} the base of "{robot}" reaches {out:.3g} m out of the floor "{drive.floor}"'
    raise refusal(place, text, "move it inwards, or make the region larger")


def too_small(drive: Drive) -> float:
    """By how much every edge of the floor would have to move outwards for the base to fit at some turn [m]; 0: it fits."""
    from scipy.optimize import linprog

    best = np.inf
    for turn in np.linspace(0.0, 2.0 * np.pi, _TURNS_TRIED, endpoint=False):
        c, s = math.cos(turn), math.sin(turn)
        needed = (drive.footprint @ np.array([[c, s], [-s, c]]) @ drive.normals.T).max(axis=0)
        # The least m with normals @ p + needed - m <= offsets.
        rows = np.hstack([drive.normals, -np.ones((len(needed), 1))])
        found = linprog([0, 0, 1], A_ub=rows, b_ub=drive.offsets - needed, bounds=[(None, None)] * 3)
        best = min(best, float(found.x[2])) if found.status == 0 else best
    return max(0.0, best)
