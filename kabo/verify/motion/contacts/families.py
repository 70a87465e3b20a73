"""Checks that an object is held by one of its grasp families, or stands as one of its placements requires."""

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from kabo.arrays import Array
from kabo.language.scene_description import Constraint, Feature, GraspFamily, PlacementFamily, Stroke
from kabo.scene import Region
from kabo.verify.motion.calls import Call
from kabo.verify.motion.constraints import LENGTH_TOLERANCE, WORLD, Role, UnknownFeatureError, missed
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.report import Finding

FINGER_TOLERANCE = 1e-3  # [m or rad] by which the gripper's joints may differ from the family's
REGION_TOLERANCE = 1e-6  # [m] by which a body may reach out of its region


def check_grasp(
    node: str, time: float, call: Call, world: SceneModel, robot: str, name: str, q: Array, world_T_object: Array
) -> Iterator[Finding]:
    """A finding unless the robot in configuration `q` (n,) holds the object by one of its grasp families."""
    tool, body = world.tool_role(robot, q), world.scene.bodies[name]
    families = {n: f for n, f in body.grasps.items() if call.grasp in (None, n) and robot in (f.robots or [robot])}
    roles = {"this": world.role(name, world_T_object)} | ({} if tool is None else {"tool": tool})
    failures = []
    for family in families.values():
        reason = why_not(family.constraints, roles) or _wrong_fingers(family, world, robot, q)
        if reason is None:
            return
        failures.append(f"{family.name}: {reason}")
    text = f"{name} is not taken as any of its grasp families says ({'; '.join(failures) or 'none fits'})"
    yield Finding(node, text, time, (robot, name))


def families_of(world: SceneModel, robot: str, name: str, q: Array, world_T_object: Array) -> list[GraspFamily]:
    """The grasp families by which a robot in configuration `q` (n,) holds an object in this pose (4, 4)."""
    tool, body = world.tool_role(robot, q), world.scene.bodies[name]
    if tool is None:
        return []
    roles = {"this": world.role(name, world_T_object), "tool": tool}
    return [
        family
        for family in body.grasps.values()
        if robot in (family.robots or [robot])
        and why_not([c for c in family.constraints if "world" not in (c.first.owner, c.second.owner)], roles)
        is None
    ]


def placements_of(call: Call, world: SceneModel, pose: Callable[[str], Array]) -> list[PlacementFamily]:
    """The placement families that the object of a call fulfils; `pose` returns a body's pose world_T (4, 4)."""
    name = call.roles["object"]
    roles = _placed_roles(call, world, pose)
    families = world.scene.bodies[name].placements.values()
    return [f for f in families if call.placement in (None, f.name) and why_not(f.constraints, roles) is None]


def direction(stroke: Stroke, roles: Mapping[str, Role]) -> Array | None:
    """The unit vector (3,) of a stroke in the world; None if its feature does not exist."""
    owner = stroke.along.owner
    role = WORLD if owner == "world" else roles.get(owner)
    found = None if role is None else role.features.get(stroke.along.feature or "")
    if role is None or found is None or found.direction is None:
        return None
    vector = stroke.sign * (role.world_T[:3, :3] @ np.asarray(found.direction))
    return np.asarray(vector / np.linalg.norm(vector))


def grips(world: SceneModel, robot: str, family: GraspFamily | None) -> dict[str, tuple[float, float]]:
    """The permitted range of each gripper joint during contact: from its open position to the family's grip."""
    gripper = world.scene.robots[robot].gripper
    if gripper is None:
        return {}
    shut = gripper.closed if family is None or family.fingers is None else family.fingers
    return {
        joint: (
            min(value, shut.get(joint, value)) - FINGER_TOLERANCE,
            max(value, shut.get(joint, value)) + FINGER_TOLERANCE,
        )
        for joint, value in gripper.open.items()
    }


def _wrong_fingers(family: GraspFamily, world: SceneModel, robot: str, q: Array) -> str | None:
    gripper = world.scene.robots[robot].gripper
    if gripper is None:
        return None
    names = world.scene.robots[robot].joint_names
    for joint, value in (family.fingers if family.fingers is not None else gripper.closed).items():
        if joint in names and abs(q[names.index(joint)] - value) > FINGER_TOLERANCE:
            return f"{joint} is at {q[names.index(joint)]:.4g}, not {value:.4g}"
    return None


def check_placement(
    node: str, time: float, call: Call, world: SceneModel, pose: Callable[[str], Array]
) -> Iterator[Finding]:
    """A finding unless the object of a call fulfils one of its placements, inside the region that the call names.

    Args:
        node: the id of the node.
        time: the time in the node [s].
        call: the call, with its region or support.
        world: the scene.
        pose: gives the pose world_T (4, 4) of a body at that time.
    """
    name, region = call.roles["object"], call.roles.get("region")
    if region is not None and region not in world.scene.regions:
        yield Finding(node, f"{region} is no region of the scene", time)
        return
    support, roles = _support(call, world), _placed_roles(call, world, pose)
    if region is not None:
        out = world.outside(name, pose(name), region)
        if out > REGION_TOLERANCE:
            yield Finding(
                node, f"{name} ends outside of {region}, by {1000 * out:.3g} mm", time, (name, region), out
            )
    failures = []
    for family in world.scene.bodies[name].placements.values():
        if call.placement in (None, family.name):
            reason = why_not(family.constraints, roles)
            if reason is None:
                return
            failures.append(f"{family.name}: {reason}")
    text = f"{name} is not put down as any of its placements says ({'; '.join(failures) or 'none fits'})"
    yield Finding(node, text, time, (name,) if support is None else (name, support))


def _support(call: Call, world: SceneModel) -> str | None:
    region = call.roles.get("region")
    return call.roles.get("support") or (None if region is None else world.scene.regions[region].support)


def _placed_roles(call: Call, world: SceneModel, pose: Callable[[str], Array]) -> dict[str, Role]:
    """The bodies in the roles of a placement's constraints."""
    name, region, support = call.roles["object"], call.roles.get("region"), _support(call, world)
    roles = {"this": world.role(name, pose(name))}
    if support is not None:
        roles["support"] = world.role(support, pose(support))
    if region is not None:
        roles["region"] = _region_role(world.scene.regions[region])
    return roles


def _region_role(region: Region) -> Role:
    half = region.size[2]
    up = (0.0, 0.0, 1.0)
    features = {
        "center": Feature("point", (0.0, 0.0, 0.0)),
        "axis": Feature("line", (0.0, 0.0, 0.0), up),
        "up": Feature("line", (0.0, 0.0, 0.0), up),
        "top": Feature("plane", (0.0, 0.0, half), up),
        "bottom": Feature("plane", (0.0, 0.0, -half), up),
    }
    return Role(features, region.world_T_region)


def why_not(
    constraints: Sequence[Constraint], roles: Mapping[str, Role], length: float = LENGTH_TOLERANCE
) -> str | None:
    """The most violated constraint as text; None if all hold; `length` is the tolerance of lengths [m]."""
    try:
        found = missed(constraints, roles, length)
    except UnknownFeatureError as error:
        return f"there is no {error}"
    if found is None:
        return None
    constraint, measure = found
    by = f"{1000 * measure.excess:.3g} mm" if measure.kind == "length" else f"{np.degrees(measure.excess):.3g} deg"
    return f"{constraint.kind}({constraint.first}, {constraint.second}) is missed by {by}"
