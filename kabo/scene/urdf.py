"""Loads a Robot from URDF files: pinocchio reads the joints, `urdf_file` the geometry of the links."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.displays import counted
from kabo.errors import did_you_mean
from kabo.language.formulas import Place
from kabo.language.scene_description import DriveDescription, GripperDescription, RobotDescription
from kabo.scene.driving_robots import base_first, full_configurations, on_floor, with_base_joints
from kabo.scene.elements import Element
from kabo.scene.joint_limits import joint_rates
from kabo.scene.mimic_limits import LIMITS_ARE_FROM, MAX_VELOCITY, MimicJoint, narrowed, slowed
from kabo.scene.robot_semantics import with_groups, with_semantics
from kabo.scene.robots import Actuation, Gripper, Link, Robot, Tool
from kabo.scene.semantics import Groups
from kabo.scene.sensors import sensors_of
from kabo.scene.structure import NoStructure
from kabo.scene.transforms import transform
from kabo.scene.tree import PRISMATIC, REVOLUTE, KinematicTree
from kabo.scene.urdf_file import UrdfFile, pinocchio, read_urdf, refusal
from kabo.scene.urdf_files.native_messages import names_in, with_messages

CONTINUOUS_JOINT_LIMIT = 2.0 * math.pi  # [rad] of a continuous joint, to either side, unless the scene limits it
MOST_TURNS = 1000.0  # [rad] to which a scene may let a continuous joint turn: rounding of sines stays below 1e-12


def load_robot(
    description: RobotDescription, base: Array, packages: Mapping[str, Path], floor: Array | None = None
) -> tuple[Robot, tuple[Path, ...]]:
    """The robot of a description with its base at world_T_base (4, 4), and the files read.

    `floor`: points (P, 3) in the world, whose hull is the region that a base drives in; None: it stands.

    Raises:
        InputError: a file does not load, or the description names links or joints that are not there.
    """
    drive = description.drive
    files = [read_urdf(description.urdf, packages, description.place, drives=drive is not None)]
    model = _model(files[0], description.place, drive)
    gripper = description.gripper
    if gripper is not None and gripper.urdf is not None:
        files.append(read_urdf(gripper.urdf, packages, gripper.place))
        arm_joints = set(model.names)
        model = _with_gripper(model, _model(files[1], gripper.place), gripper, description)
        own = tuple(name for name in model.names if name not in arm_joints)
    else:
        own = () if gripper is None or gripper.joints is None else gripper.joints
    _place_base(model, base)
    mimics = {name: rule for file in files for name, rule in file.mimics.items()}
    elements = {name: made for file in files for name, made in file.elements.items()}
    places = {name: place for file in files for name, place in file.places.items()}
    zones = frozenset[str]().union(*(file.zones for file in files))
    joints = {name: ends for file in files for name, ends in file.joints.items()}
    groups, own = Groups.of(description.semantics, joints), tuple(j for j in own if j not in mimics)
    described = with_groups(description, groups, {*mimics, *own}, tuple(model.names))
    robot = with_semantics(_assemble(described, model, mimics, elements, own, places, zones), description, groups)
    if floor is not None:
        robot = on_floor(robot, description, floor)
    _check_configurations(description, robot)
    _check_structure(description, robot)
    read = tuple(path for file in files for path in file.files)
    return robot, read if description.semantics is None else (*read, description.semantics.path)


def _model(file: UrdfFile, place: Place | None, drive: DriveDescription | None = None) -> Any:
    text = file.kinematics if drive is None else with_base_joints(file.kinematics, drive)
    model, lines, reason = with_messages(lambda: pinocchio().buildModelFromXML(text))
    if reason is None:
        return model
    named = (file.places[name] for line in lines for name in names_in(line) if name in file.places)
    told = lines[0] if lines else reason
    raise refusal(next(named, place), f'robot file "{file.path.name}" is not a usable URDF: {told}')


def _with_gripper(model: Any, gripper: Any, described: GripperDescription, description: RobotDescription) -> Any:
    mount = described.mount or ""
    bodies = [frame.name for frame in model.frames]
    if mount not in bodies:
        raise refusal(
            described.place or description.place,
            f'unknown link "{mount}" to mount the gripper on',
            did_you_mean(mount, bodies),
        )
    mount_T_gripper = transform(described.pose.position, described.pose.quaternion)
    pin = pinocchio()
    return pin.appendModel(model, gripper, model.getFrameId(mount), pin.SE3(mount_T_gripper))


def _place_base(model: Any, base: Array) -> None:
    world_M_base = pinocchio().SE3(base)
    for j in range(1, model.njoints):
        if model.parents[j] == 0:
            model.jointPlacements[j] = world_M_base * model.jointPlacements[j]
    for frame in model.frames:
        if frame.parentJoint == 0 and frame.name != "universe":
            frame.placement = world_M_base * frame.placement


def _axes(model: Any) -> list[tuple[int, Array] | None]:
    """The kind and axis of every joint in its own frame; None for a kind that kabo does not plan for."""
    pin, data = pinocchio(), model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    found: list[tuple[int, Array] | None] = [None]
    for j in range(1, model.njoints):
        if model.joints[j].nv != 1:
            found.append(None)
            continue
        jacobian = pin.getJointJacobian(model, data, j, pin.LOCAL).reshape(6, -1)  # a robot of one joint: (6,)
        column = jacobian[:, model.joints[j].idx_v]
        kind = REVOLUTE if np.linalg.norm(column[3:]) > np.linalg.norm(column[:3]) else PRISMATIC
        found.append((kind, column[3:] if kind == REVOLUTE else column[:3]))
    return found


def _z_to(axis: Array) -> Array:
    """A rotation (3, 3) of z to `axis`, without rounding errors for coordinate axes."""
    x, y, z = axis
    if z < -0.999999:
        return np.diag([1.0, -1.0, -1.0])
    k = 1.0 / (1.0 + z)
    return np.array([[1 - x * x * k, -x * y * k, x], [-x * y * k, 1 - y * y * k, y], [-x, -y, z]])


def _assemble(
    description: RobotDescription,
    model: Any,
    mimics: Mapping[str, MimicJoint],
    elements: Mapping[str, tuple[Element, ...]],
    gripper_joints: tuple[str, ...],
    places: Mapping[str, Place],
    zones: frozenset[str],
) -> Robot:
    for link in description.hulls:
        if link not in elements:
            raise refusal(
                description.place, f'no link "{link}" with a shape, in hulls', did_you_mean(link, elements)
            )
    movable = [name for name in list(model.names)[1:] if name not in mimics]
    for name in (*(description.joints or ()), *gripper_joints):
        if name not in movable:
            hint = did_you_mean(name, movable) or f"joints that move on their own: {', '.join(movable) or 'none'}"
            raise refusal(description.place, f'unknown joint "{name}"', hint)
    movable = [name for name in movable if name not in gripper_joints]
    planned = base_first(description.joints or None, movable, description.drive)
    names = (*planned, *gripper_joints)
    kinds, turns = [REVOLUTE], [np.eye(3)]
    for j, kind_axis in list(enumerate(_axes(model)))[1:]:
        if kind_axis is None:
            raise refusal(description.place, f'joint "{model.names[j]}" is neither revolute nor prismatic')
        kinds.append(kind_axis[0])
        turns.append(_z_to(kind_axis[1]))
    actuation = _actuation(model, names, mimics, description)
    speeds = {name: slowed(name, own, mimics) for name, own in _velocities(model, names).items()}
    rates = joint_rates(description, names, len(planned), speeds)
    limits = [_range(model, name, mimics, description) for name in names]
    tree = _tree(model, kinds, turns, actuation, limits, rates.velocity)
    links = _links(model, turns, elements, places, zones)
    return Robot(
        description.name,
        model,
        links,
        names,
        len(planned),
        tree,
        actuation,
        _tool(description, links),
        _gripper(description, gripper_joints, links),
        full_configurations(description, len(planned)),
        description.inverse_kinematics,
        description.hulls,
        rates.acceleration,
        sensors_of(description, links),
        jerk=rates.jerk,
    )


def _links(
    model: Any,
    turns: Sequence[Array],
    elements: Mapping[str, tuple[Element, ...]],
    places: Mapping[str, Place],
    zones: frozenset[str],
) -> dict[str, Link]:
    """The links by name; `turns` are the rotations of joint frames that align z with the joint's axis."""
    links = {}
    for frame in model.frames:
        if frame.type == pinocchio().FrameType.BODY:
            pose = frame.placement.homogeneous.copy()
            turn = np.eye(4)
            turn[:3, :3] = turns[frame.parentJoint].T
            name, own = frame.name, elements.get(frame.name, ())
            links[name] = Link(name, frame.parentJoint, turn @ pose, own, places.get(name), name in zones)
    return links


def _actuation(
    model: Any,
    names: tuple[str, ...],
    mimics: Mapping[str, MimicJoint],
    description: RobotDescription,
) -> Actuation:
    source, ratio, shift = [0], [0.0], [0.0]
    for j in range(1, model.njoints):
        name, factor, offset = model.names[j], 1.0, 0.0
        if name in mimics:
            mimic = mimics[name]
            name, factor, offset = mimic.source, mimic.multiplier, mimic.offset
        if name in names:
            source.append(names.index(name))
        elif name not in list(model.names):
            raise refusal(description.place, f'joint "{model.names[j]}" mimics the unknown joint "{name}"')
        else:
            source.append(0)
            factor, offset = 0.0, factor * _stand(model, name, mimics) + offset
        ratio.append(factor)
        shift.append(offset)
    return Actuation(tuple(source), tuple(ratio), tuple(shift))


def _range(
    model: Any, name: str, mimics: Mapping[str, MimicJoint], description: RobotDescription
) -> tuple[float, float]:
    """The limits of a joint [rad or m]: those of the URDF, within those of the scene.

    Raises:
        InputError: nothing is within all limits, or a continuous joint is to turn too far.
    """
    lower, upper = _range_in_urdf(model, name)
    endless = model.joints[model.getJointId(name)].nq > 1
    if endless and name in description.limits:
        lower, upper = -MOST_TURNS, MOST_TURNS
    lower, upper, mimic = narrowed(name, lower, upper, mimics)
    if mimic is not None:
        raise refusal(
            mimic.place,
            mimic.impossible(lower, upper),
            "correct the limits of one of them, or multiplier and offset",
        )
    if name not in description.limits:
        return lower, upper
    low, high = description.limits[name]
    place = description.limit_places.get(name) or description.place
    if endless and max(abs(low), abs(high)) > MOST_TURNS:
        said = f'the limits [{low:g}, {high:g}] of the continuous joint "{name}" reach beyond {MOST_TURNS:g} rad'
        raise refusal(place, said, "leave them out: it then turns by 360 deg to either side")
    if low > upper or high < lower:
        said = f'the limits [{low:g}, {high:g}] of "{name}" are outside those of its URDF, {lower:g} to {upper:g}'
        raise refusal(
            place, said, "a scene can only make the range of a joint narrower; change the URDF if it is wrong"
        )
    return max(lower, low), min(upper, high)


def _range_in_urdf(model: Any, name: str) -> tuple[float, float]:
    joint = model.joints[model.getJointId(name)]
    if joint.nq > 1:
        return -CONTINUOUS_JOINT_LIMIT, CONTINUOUS_JOINT_LIMIT
    return float(model.lowerPositionLimit[joint.idx_q]), float(model.upperPositionLimit[joint.idx_q])


def _stand(model: Any, name: str, mimics: Mapping[str, MimicJoint]) -> float:
    """Where a joint that is not planned stands: at zero, or as near as its limits and those of its mimics allow."""
    lower, upper, _ = narrowed(name, *_range_in_urdf(model, name), mimics)
    return float(min(max(0.0, lower), upper))


def _tree(
    model: Any,
    kinds: list[int],
    turns: list[Array],
    actuation: Actuation,
    limits: Sequence[tuple[float, float]],
    speeds: Mapping[str, float],
) -> KinematicTree:
    placement = np.zeros((model.njoints, 12))
    placement[0, [0, 4, 8]] = 1.0
    for j in range(1, model.njoints):
        parent, pose = model.parents[j], model.jointPlacements[j]
        placement[j, :9] = (turns[parent].T @ pose.rotation @ turns[j]).ravel()
        placement[j, 9:] = turns[parent].T @ pose.translation
    lower, upper = np.array(limits, np.float64).reshape(-1, 2).T.copy()
    return KinematicTree(
        np.array(list(model.parents), dtype=np.int64),
        np.array(kinds, dtype=np.int64),
        np.array(actuation.source, dtype=np.int64),
        np.array(actuation.ratio),
        np.array(actuation.shift),
        placement,
        lower,
        upper,
        np.array(list(speeds.values()), np.float64),
    )


def _velocities(model: Any, names: tuple[str, ...]) -> dict[str, float | None]:
    """The velocity limits of the URDF by joint; None where it has none."""
    speeds = {name: float(model.velocityLimit[model.joints[model.getJointId(name)].idx_v]) for name in names}
    return {name: speed if 0.0 < speed < MAX_VELOCITY else None for name, speed in speeds.items()}


def _tool(description: RobotDescription, links: Mapping[str, Link]) -> Tool | None:
    if description.tool_frame is None:
        return None
    if description.tool_frame not in links:
        hint = did_you_mean(description.tool_frame, links)
        raise refusal(description.place, f'unknown link "{description.tool_frame}" as tool frame', hint)
    return Tool(description.tool_frame, description.tool_features)


def _gripper(description: RobotDescription, joints: tuple[str, ...], links: Mapping[str, Link]) -> Gripper | None:
    gripper = description.gripper
    if gripper is None:
        return None
    for link in gripper.touch_links:
        if link not in links:
            hint = did_you_mean(link, links) or f"there are {', '.join(links)}"
            raise refusal(gripper.place, f'unknown link "{link}" in touch_links', hint)
    for name in (*gripper.open, *gripper.closed):
        if name not in joints:
            raise refusal(gripper.place, f'unknown joint "{name}" of the gripper', did_you_mean(name, joints))
    touch = tuple(f"{description.name}.{link}" for link in gripper.touch_links)
    return Gripper(joints, gripper.open, gripper.closed, touch, gripper.force, gripper.friction)


def _check_configurations(description: RobotDescription, robot: Robot) -> None:
    lower, upper = robot.tree.lower[: robot.planned], robot.tree.upper[: robot.planned]
    for name, values in robot.configurations.items():
        if len(values) != robot.planned:
            own = f" ({', '.join(robot.planned_joints[: robot.base_values])} first)" if robot.drive else ""
            count = f"{counted(len(values), 'value')}, but the robot has {robot.planned} planned joints{own}"
            hint = f"write a value for each of {', '.join(robot.planned_joints)}"
            raise refusal(description.place, f'configuration "{name}" has {count}', hint)
        for joint, value, low, high in zip(robot.planned_joints, values, lower, upper, strict=True):
            if not low <= value <= high:
                limits = f"[{low:.6g}, {high:.6g}]"
                text = f'configuration "{name}": {joint} = {value:.6g} is outside its limits {limits}'
                raise refusal(description.place, text, LIMITS_ARE_FROM)


def _check_structure(description: RobotDescription, robot: Robot) -> None:
    if robot.inverse_kinematics == "analytic" and isinstance(robot.structure, NoStructure):
        text = f'no closed form (`analytic`) of the inverse kinematics of "{robot.name}" is known: '
        hint = "write `projection`, or leave the key out"
        raise refusal(description.analytic or description.place, text + robot.structure.reason, hint)
