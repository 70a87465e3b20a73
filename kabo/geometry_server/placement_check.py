"""A check before any search: whether a robot could place an object somewhere at all, whatever its grasp.

The object is treated as a free body: a tree of six joints is projected onto the placement's constraints, and at
each pose found the robot tries to grasp it. Finding no grasp is no proof, but saves a search from trying
every grasp. With another seed other samples are drawn; what is found with one lasts as long as the scene is loaded.
"""

from collections.abc import Iterator

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.candidates import Stream, base_position, grasp_roles, grasp_stream, within
from kabo.geometry_server.configurations import joints_at
from kabo.geometry_server.context import ProcedureContext
from kabo.geometry_server.destinations import Destination
from kabo.geometry_server.driving.standing import standing_of
from kabo.geometry_server.frames import WORLD, Frame, fits, rows, standing_frame
from kabo.geometry_server.reachability import grasp_missing
from kabo.geometry_server.situation import Situation
from kabo.kinematics import FREE_BODY, sample, stacked
from kabo.scene import Body, Configuration, Robot
from kabo.scene.transforms import length, unflat
from kabo.streams import stream_key

PLACES_TRIED, GRASPS_TRIED = 24, 16  # poses of the object, and grasps at each of them
PLACES_PROJECTED = 3  # poses at which grasps are projected where none could be drawn
PLACES_MEASURED = 1  # poses at which the distance out of reach is measured
SURELY_MISSING = 1e-3  # [m] beyond reach: far more than the tolerance within which constraints hold


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
    key = "may place", robot.name, hand, *_place_key(context, body, target, situation)
    found: tuple[bool] = context.surroundings.lasting(
        key, lambda: (_may_place(context, robot, body, target, situation),)
    )
    return found[0]


def _may_place(
    context: ProcedureContext, robot: Robot, body: Body, target: Destination, situation: Situation
) -> bool:
    streams: list[
        Stream | None
    ] = []  # None where every grasp is proven out of reach: there none is drawn or projected
    undrawn: list[Stream | None] = []  # those where no pose of the hand can be drawn: all of them are projected
    found = _nearest_places(context, robot, body, target, situation)
    for stream in _grasps(context, robot, body, found, situation):
        drawn = None if stream is None else stream.draws(GRASPS_TRIED)
        if drawn:
            return True
        (undrawn if stream is not None and drawn is None else streams).append(stream)
    # Projection seldom finds a grasp where none was drawn, and is slow: it is tried at a few distances.
    few = streams[:: -(-len(streams) // PLACES_PROJECTED)] if streams else []
    return not found or any(made.batch(0, GRASPS_TRIED) for made in (*undrawn, *few) if made is not None)


def grasps_there(
    context: ProcedureContext,
    robot: Robot,
    body: Body,
    target: Destination,
    situation: Situation,
    most: int = PLACES_MEASURED,
) -> list[Stream]:
    """The grasp streams of a body at the `most` poses on a target that are nearest to the robot's base."""
    near = _nearest_places(context, robot, body, target, situation)[:most]
    found = _grasps(context, robot, body, near, situation, far=True)
    return [stream for stream in found if stream is not None]


def _nearest_places(
    context: ProcedureContext, robot: Robot, body: Body, target: Destination, situation: Situation
) -> list[Array]:
    """The poses (4, 4) of `places`, those nearest to the robot's base first."""
    # Of every robot it is asked about the same places.
    found: tuple[Array, ...] = context.surroundings.lasting(
        ("places", *_place_key(context, body, target, situation)),
        lambda: tuple(places(context, body, target, situation)),
    )
    base = base_position(robot)
    return sorted(found, key=lambda pose: length(pose[:3, 3] - base))


def _place_key(
    context: ProcedureContext, body: Body, target: Destination, situation: Situation
) -> tuple[object, ...]:
    """The seed, a body, where it is to be placed, and where that is now."""
    under = () if target.support is None else context.surroundings.poses(situation, target.support)
    region = None if target.region is None else target.region.name
    return context.seed, body.name, target.support, region, *(pose.tobytes() for pose in under)


def _grasps(
    context: ProcedureContext,
    robot: Robot,
    body: Body,
    poses: list[Array],
    situation: Situation,
    *,
    far: bool = False,
) -> Iterator[Stream | None]:
    """The streams of grasps by the open hand of a body at each of some poses.

    Unless those out of reach are wanted, too (`far`), these are None: most of them may be, and none costs little.
    """
    hand = _open_hand(robot, situation.configuration(robot.name))
    standing = standing_of(context.surroundings, robot)
    for pose in poses:
        for family in body.grasps.values():
            roles = grasp_roles(robot, body, family, pose)
            if roles is None:
                continue
            if not far and grasp_missing(robot, family.constraints, roles) > SURELY_MISSING:
                yield None
                continue
            made = grasp_stream(robot, body, family, pose, hand, context.seed, standing)
            assert made is not None, "the family fits"
            yield made.stream


def _open_hand(robot: Robot, q: Configuration) -> tuple[float, ...]:
    """The values of the gripper's joints when it is open."""
    values = {} if robot.gripper is None else robot.gripper.open
    now = zip(robot.gripper_joints, q[robot.planned :], strict=True)
    return tuple(round(values.get(joint, value), 9) + 0.0 for joint, value in now)
