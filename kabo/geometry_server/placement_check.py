"""A check before any search: whether a robot could place an object somewhere at all, whatever its grasp.

The object is treated as a free body: a tree of six joints is projected onto the placement's constraints, and at
each pose found the robot tries to grasp it. Finding no grasp is no proof, but saves a search from trying
every grasp.
"""

from collections.abc import Iterator

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.candidates import Stream, base_position, grasp_stream, joints_at, within
from kabo.geometry_server.context import ProcedureContext
from kabo.geometry_server.destinations import Destination
from kabo.geometry_server.driving.standing import standing_of
from kabo.geometry_server.frames import WORLD, Frame, fits, rows, standing_frame
from kabo.geometry_server.situation import Situation
from kabo.kinematics import FREE_BODY, sample, stacked
from kabo.scene import Body, Configuration, Robot
from kabo.scene.transforms import unflat
from kabo.streams import stream_key

PLACES_TRIED, GRASPS_TRIED = 24, 16  # poses of the object, and grasps at each of them
PLACES_MEASURED = 1  # poses at which the distance out of reach is measured


def places(context: ProcedureContext, body: Body, target: Destination, situation: Situation) -> Iterator[Array]:
    """Poses (4, 4) at which a body fulfils its placement families on a target, a few for each family."""
    this = Frame(6, np.eye(4), body.features)
    roles = {"this": this, "world": WORLD}
    if target.support is not None:
        (pose,) = context.surroundings.poses(situation, target.support)
        roles["support"] = standing_frame(context.scene.bodies[target.support], pose)
    for family in body.placements.values():
        if fits(family.constraints, roles):
            parts = [rows(family.constraints, roles)]
            if target.region is not None:
                parts.append(within(this, body, target.region, 0.0))
            key = stream_key(context.seed, "foresight", body.name, family.name, str(target.support))
            found, valid = sample(
                FREE_BODY,
                stacked(parts),
                key,
                0,
                PLACES_TRIED,
                FREE_BODY.lower,
                FREE_BODY.upper,
                np.ones(6, dtype=bool),
            )
            for q in found[valid]:
                yield unflat(joints_at(FREE_BODY, q)[6])


def may_place(
    context: ProcedureContext, robot: Robot, body: Body, target: Destination, situation: Situation
) -> bool:
    """Whether the robot has a grasp of the body at some sampled pose on the target; True if no pose was found."""
    hand = _open_hand(robot, situation.configuration(robot.name))
    standing = standing_of(context.surroundings, robot)
    none = True
    for pose in places(context, body, target, situation):
        none = False
        for family in body.grasps.values():
            made = grasp_stream(robot, body, family, pose, hand, context.seed, standing)
            if made is not None and made.stream.batch(0, GRASPS_TRIED):
                return True
    return none


def grasps_there(
    context: ProcedureContext,
    robot: Robot,
    body: Body,
    target: Destination,
    situation: Situation,
    most: int = PLACES_MEASURED,
) -> list[Stream]:
    """The grasp streams of a body at the `most` poses on a target that are nearest to the robot's base."""
    hand, base = _open_hand(robot, situation.configuration(robot.name)), base_position(robot)
    near = sorted(
        places(context, body, target, situation), key=lambda pose: float(np.linalg.norm(pose[:3, 3] - base))
    )
    made = (
        grasp_stream(robot, body, family, pose, hand, context.seed, standing_of(context.surroundings, robot))
        for pose in near[:most]
        for family in body.grasps.values()
    )
    return [found.stream for found in made if found is not None]


def _open_hand(robot: Robot, q: Configuration) -> tuple[float, ...]:
    """The values of the gripper's joints when it is open."""
    values = {} if robot.gripper is None else robot.gripper.open
    now = zip(robot.gripper_joints, q[robot.planned :], strict=True)
    return tuple(round(values.get(joint, value), 9) + 0.0 for joint, value in now)
