"""Destinations of held objects, their placement streams, and the grasp family by which an object is held."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.candidates import (
    PlacementStream,
    base_position,
    placement_stream,
)
from kabo.geometry_server.context import ProcedureContext
from kabo.geometry_server.driving.standing import standing_of
from kabo.geometry_server.frames import WORLD, Frame, carried_frame, fits, has, rows, standing_frame, tool_frame
from kabo.geometry_server.situation import Situation
from kabo.kinematics import missed, satisfied
from kabo.language.scene_description import Constraint, GraspFamily
from kabo.scene import Body, KinematicTree, Region, Robot, Scene

HOLD_TOLERANCE = 1e-4  # [m, rad] within which a hold counts as a grasp of a family
OBSERVED_HOLD = 1e-3  # [m, rad]: the same of a hold that was observed in a run, as `kabo verify` takes it
FINGER_TOLERANCE = 1e-3  # [m, rad] within which a hand is as wide as a family says


@dataclass(frozen=True)
class Destination:
    """The place where an object is to be put: on a support, in a region, or on a support within a region."""

    support: str | None
    region: Region | None


def placement_streams(
    context: ProcedureContext,
    robot: Robot,
    name: str,
    target: Destination,
    situation: Situation,
    wanted: str = "any",
) -> list[PlacementStream]:
    """A placement stream for each placement family of the held object that fits the target."""
    body, held = context.scene.bodies[name], situation.held(name)
    support = None
    if target.support is not None:
        (pose,) = context.surroundings.poses(situation, target.support)
        support = context.scene.bodies[target.support], pose
    hand = situation.configuration(robot.name)[robot.planned :]
    others = tuple(base_position(r) for r in context.scene.robots.values() if r is not robot)
    margin = 0.5 * context.surroundings.budget.epsilon  # the enclosing parts stick out by up to 0.4 epsilon
    chosen = [family for family in body.placements.values() if wanted in ("any", family.name)]
    standing = standing_of(context.surroundings, robot)
    made = (
        placement_stream(
            robot, body, held, f, support, target.region, margin, others, context.seed, hand, standing
        )
        for f in chosen
    )
    return [stream for stream in made if stream is not None]


def why_nowhere(scene: Scene, name: str, target: Destination, wanted: str = "any") -> str | None:
    """The reason why no placement family of an object fits the target, wherever everything is; None if one fits."""
    body, told = scene.bodies[name], []
    roles = {"this": standing_frame(body, np.eye(4)), "world": WORLD}
    if target.support is not None:
        roles["support"] = standing_frame(scene.bodies[target.support], np.eye(4))
    if target.region is not None:
        roles["region"] = Frame(0, target.region.world_T_region, {})
    owners = {"this": name, "support": target.support, "region": target.region and target.region.name}
    for family in body.placements.values():
        if wanted not in ("any", family.name):
            continue
        named = (each for c in family.constraints if c.kind != "inside" for each in (c.first, c.second))
        lacking = next((each for each in named if not has(roles, each)), None)
        if lacking is None:
            return None
        if lacking.owner in roles:
            why = f"which {owners.get(lacking.owner, lacking.owner)} lacks"
        else:
            who = "there is" if target.region is None else f"{target.region.name} has"
            why = f"and {who} no {lacking.owner}"
        told.append(f"{family.name} names {lacking}, {why}")
    return f"{name} has no placement family that fits: {'; '.join(told) or 'it has none'}"


def grasp_family_of(
    context: ProcedureContext, robot: Robot, name: str, situation: Situation
) -> GraspFamily | None:
    """The grasp family by which a robot holds an object; None if no family matches."""
    body, held = context.scene.bodies[name], situation.held(name)
    roles = {"tool": tool_frame(robot), "this": carried_frame(robot, body, held), "world": WORLD}
    return family_of_hold(robot, body, roles, np.array(situation.configuration(robot.name)))


def family_of_hold(robot: Robot, body: Body, roles: Mapping[str, Frame], q: Array) -> GraspFamily | None:
    """The first grasp family of a body that this robot may use and that fits where its tool is; None if none does.

    Families may differ in the width of the hand alone: those come first that say the width that it has. A hold that was
    observed in a run fits none exactly: then those count that `kabo verify` takes it for.

    Args:
        robot: the robot. body: the body. roles: the frames of `tool` and `this`. q: the robot's configuration (n,).
    """
    allowed = []
    for family in body.grasps.values():
        own = [c for c in family.constraints if "world" not in (c.first.owner, c.second.owner)]
        if (family.robots is None or robot.name in family.robots) and fits(own, roles):
            allowed.append((family, own))
    tree = robot.tree
    found = [each for each, own in allowed if satisfied(rows(own, roles), q, tree, HOLD_TOLERANCE)]
    found = found or [each for each, own in allowed if all(_nearly(c, roles, q, tree) for c in own)]
    return next((family for family in found if _is_as_wide(robot, family, q)), found[0] if found else None)


def _nearly(constraint: Constraint, roles: Mapping[str, Frame], q: Array, tree: KinematicTree) -> bool:
    """Whether a constraint is missed by no more than a hold that was observed may be, in length and in angle."""
    return max(missed(rows([constraint], roles), q, tree)) <= OBSERVED_HOLD


def _is_as_wide(robot: Robot, family: GraspFamily, q: Array) -> bool:
    """Whether the hand of a robot in a configuration (n,) is as wide as a family says."""
    if robot.gripper is None:
        return True
    shut = robot.gripper.closed if family.fingers is None else family.fingers
    wanted = {joint: shut.get(joint, value) for joint, value in robot.gripper.open.items()}
    return all(
        abs(q[robot.joint_names.index(joint)] - value) <= FINGER_TOLERANCE for joint, value in wanted.items()
    )
