"""Putting an object down: lowering onto a support, opening and retreating, for every placement of its families."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kabo.geometry_server.answers import Refusals
from kabo.geometry_server.candidates import (
    Candidate,
    PlacementStream,
    base_position,
    candidate,
    placement_stream,
)
from kabo.geometry_server.context import Context
from kabo.geometry_server.frames import WORLD, Frame, Roles, carried_frame, fits, rows, tool_frame
from kabo.geometry_server.grasping import opened, stroked
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.standing import lies_inside
from kabo.geometry_server.stretches import Motion
from kabo.geometry_server.workspace import Contacts, Workspace, contacts
from kabo.kinematics import satisfied
from kabo.language.scene_description import FeatureName, GraspFamily, Stroke
from kabo.scene import Attachment, Region, Robot, attachment

Array = npt.NDArray[np.float64]

LOWERING = Stroke(FeatureName("world", "up"), 1, 0.05, 0.10)  # how far from above where no family says how to lift
HELD_EXACTLY = 1e-4  # m, rad: how exactly a hold must be a grasp of a family


@dataclass(frozen=True)
class Place:
    """Where to put something: a support, a region, or a support within a region."""

    support: str | None
    region: Region | None


Target = Place


@dataclass(frozen=True)
class Lowering:
    """A proven way to set an object down, still held: way points from above, and where it stands then."""

    way: list[Array]
    permitted: Contacts
    stands: Attachment


@dataclass(frozen=True)
class Release:
    """A proven way to let go: the open hand and the retreat."""

    opened: Array
    retreat: list[Array]
    touch: Contacts

    def append_to(self, motion: Motion, name: str, q: Array) -> None:
        """Appends open (detaching at its end) and retreat, from the configuration q in which the object stands."""
        motion.hand("open", q, self.opened, self.touch, detach=(name,))
        motion.arm("retreat", self.retreat)


def placement_streams(
    context: Context, robot: Robot, name: str, target: Place, situation: Situation, wanted: str = "any"
) -> list[PlacementStream]:
    """The streams of all placement families of what the robot holds that fit the target."""
    body, held = context.scene.bodies[name], situation.attachment(name)
    support = None
    if target.support is not None:
        (pose,) = context.surroundings.poses(situation, target.support)
        support = context.scene.bodies[target.support], pose
    hand = situation.configuration(robot.name)[robot.planned :]
    others = tuple(base_position(r) for r in context.scene.robots.values() if r is not robot)
    margin = 0.5 * context.surroundings.budget.epsilon  # the enclosing parts stick out by up to 0.4 epsilon
    chosen = [family for family in body.placements.values() if wanted in ("any", family.name)]
    made = (
        placement_stream(robot, body, held, f, support, target.region, margin, others, context.seed, hand)
        for f in chosen
    )
    return [stream for stream in made if stream is not None]


def hold(context: Context, robot: Robot, name: str, situation: Situation) -> tuple[GraspFamily, Roles] | None:
    """The grasp family by which a robot holds an object, with its roles; None if no family declares this hold."""
    body, held = context.scene.bodies[name], situation.attachment(name)
    roles = {"tool": tool_frame(robot), "this": carried_frame(robot, body, held), "world": WORLD}
    q = np.array(situation.configuration(robot.name))
    for family in body.grasps.values():
        own = [c for c in family.constraints if "world" not in (c.first.owner, c.second.owner)]
        if fits(own, roles) and satisfied(rows(own, roles), q, robot.tree, HELD_EXACTLY):
            return family, roles
    return None


def recognised(context: Context, robot: Robot, name: str, situation: Situation) -> GraspFamily | None:
    """The grasp family by which a robot holds an object; None if no family declares this hold."""
    found = hold(context, robot, name, situation)
    return None if found is None else found[0]


def lowerings(
    context: Context, robot: Robot, name: str, target: Place, situation: Situation, refusals: Refusals
) -> Iterator[tuple[PlacementStream, Lowering]]:
    """Every proven way to set down what the robot holds, in the order of the streams."""
    workspace = Workspace.of(context.surroundings, robot.name, situation)
    held_by = hold(context, robot, name, situation)
    lift = held_by[0].lift if held_by is not None and held_by[0].lift is not None else LOWERING
    for stream in placement_streams(context, robot, name, target, situation):
        roles = {"world": WORLD, "this": stream.this, "tool": tool_frame(robot)}
        for found in context.drawn(stream):
            lowering = _lowering(workspace, stream, name, target, found, lift, roles, refusals)
            if lowering is not None:
                yield stream, lowering


def _lowering(
    workspace: Workspace,
    stream: PlacementStream,
    name: str,
    target: Place,
    at: Candidate,
    lift: Stroke,
    roles: Roles,
    refusals: Refusals,
) -> Lowering | None:
    pose = at.pose(stream.this)
    if target.region is not None and not lies_inside(workspace.surroundings, name, pose, target.region):
        refusals.add("constraint")
        return None
    under = () if target.support is None else ((name, target.support),)
    lowering = workspace.permitting(under)
    hit = lowering.first_hit(at.q)
    if hit is not None:
        refusals.add("collision", hit)
        return None
    way = stroked(lowering, lift, roles, at, tool_frame(workspace.robot), refusals)
    if way is None:
        return None
    hit = workspace.first_hit(way[-1])
    if hit is not None:
        refusals.add("collision", hit)
        return None
    touch = [pair for held in workspace.carried for pair in workspace.touching(held)]
    return Lowering(way[::-1], contacts((*touch, *under)), attachment("world", pose))


def release(
    context: Context, robot: Robot, name: str, retreat: Stroke | None, situation: Situation, refusals: Refusals
) -> Release | None:
    """A proven way to let go of an object that stands, in the situation in which it is still held; or None."""
    q = np.array(situation.configuration(robot.name))
    held_by = hold(context, robot, name, situation)
    (pose,) = context.surroundings.poses(situation, name)
    after = situation.replace({name: attachment("world", pose)})
    workspace = Workspace.of(context.surroundings, robot.name, after)
    touch = workspace.touching(name)
    opening = workspace.permitting(touch)
    empty = opened(robot, q)
    index = opening.segment_hit(q, empty)
    if index >= 0:
        refusals.add("collision", opening.pairs[index])
        return None
    at, tool = candidate(robot, empty), tool_frame(robot)
    back = retreat is None
    stroke = held_by[0].approach if retreat is None and held_by is not None else retreat
    roles = {"world": WORLD, "tool": tool, "this": Frame(0, pose, context.scene.bodies[name].features)}
    way = stroked(workspace, stroke, roles, at, tool, refusals, back=back)
    return None if way is None else Release(empty, way, contacts(touch))
