"""Destinations of held objects, their placement streams, and the grasp family by which an object is held."""

from dataclasses import dataclass

import numpy as np

from kabo.geometry_server.candidates import (
    PlacementStream,
    base_position,
    placement_stream,
)
from kabo.geometry_server.context import ProcedureContext
from kabo.geometry_server.driving.standing import standing_of
from kabo.geometry_server.frames import WORLD, carried_frame, fits, rows, tool_frame
from kabo.geometry_server.situation import Situation
from kabo.kinematics import satisfied
from kabo.language.scene_description import GraspFamily
from kabo.scene import Region, Robot

HOLD_TOLERANCE = 1e-4  # [m, rad] within which a hold counts as a grasp of a family


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


def grasp_family_of(
    context: ProcedureContext, robot: Robot, name: str, situation: Situation
) -> GraspFamily | None:
    """The grasp family by which a robot holds an object; None if no family matches."""
    body, held = context.scene.bodies[name], situation.held(name)
    roles = {"tool": tool_frame(robot), "this": carried_frame(robot, body, held), "world": WORLD}
    q = np.array(situation.configuration(robot.name))
    for family in body.grasps.values():
        own = [c for c in family.constraints if "world" not in (c.first.owner, c.second.owner)]
        if fits(own, roles) and satisfied(rows(own, roles), q, robot.tree, HOLD_TOLERANCE):
            return family
    return None
