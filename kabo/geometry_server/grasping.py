"""Taking an object: approach, closing and lifting as one proven stretch, for every grasp of its families."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kabo.geometry_server.answers import Pair, Refusals
from kabo.geometry_server.candidates import Candidate, GraspStream, candidate, grasp_stream
from kabo.geometry_server.context import Context
from kabo.geometry_server.frames import Frame, Roles
from kabo.geometry_server.reach import grasp_missing
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.standing import supports
from kabo.geometry_server.stretches import Motion, Refused, line, rounded
from kabo.geometry_server.workspace import Contacts, Workspace, contacts
from kabo.language.scene_description import GraspFamily, Stroke
from kabo.scene import Attachment, Robot, attachment
from kabo.scene.transforms import inverse

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Grasp:
    """A proven way to take an object: the approach, the closed hand, the lift, and the attachment."""

    approach: list[Array]
    closed: Array
    lift: list[Array]
    held: Attachment
    touch: Contacts
    lifting: Contacts

    def append_to(self, motion: Motion, name: str) -> None:
        """Appends approach, close (attaching at its end) and lift."""
        motion.arm("approach", self.approach)
        motion.hand("close", self.approach[-1], self.closed, self.touch, attach=((name, self.held.parent),))
        motion.arm("lift", self.lift, self.lifting)


def with_hand(robot: Robot, q: Array, values: Mapping[str, float] | None) -> Array:
    """The configuration with joints of the gripper set."""
    result = q.copy()
    for i, joint in enumerate(robot.gripper_joints, robot.planned):
        result[i] = (values or {}).get(joint, result[i])
    return rounded(result)


def opened(robot: Robot, q: Array) -> Array:
    """The configuration with the gripper open."""
    return with_hand(robot, q, None if robot.gripper is None else robot.gripper.open)


def direction(stroke: Stroke, roles: Roles, at: Candidate) -> Array:
    """The unit vector (3,) in the world along which a stroke moves, at a candidate."""
    frame = roles[stroke.along.owner]
    along = np.asarray(frame.features[stroke.along.feature or ""].direction)
    return stroke.sign * (at.pose(frame)[:3, :3] @ along)


def lengths(low: float, high: float) -> tuple[float, ...]:
    """The lengths of a stroke that are tried: all of it, half, as little as may be [m]."""
    return tuple(dict.fromkeys((high, (low + high) / 2, low)))


def families(context: Context, robot: Robot, name: str, wanted: str, situation: Situation) -> list[GraspStream]:
    """The streams of all grasp families of an object that fit the robot, or of the one that is wanted."""
    body = context.scene.bodies[name]
    (pose,) = context.surroundings.poses(situation, name)
    hand = tuple(opened(robot, np.array(situation.configuration(robot.name)))[robot.planned :])
    chosen = [f for f in body.grasps.values() if wanted in ("any", f.name)]
    streams = (grasp_stream(robot, body, family, pose, hand, context.seed) for family in chosen)
    return [stream for stream in streams if stream is not None]


def missing(robot: Robot, streams: list[GraspStream]) -> float:
    """How far out of reach [m] every family is proven to be; 0 or less: not proven."""
    return min(grasp_missing(robot, s.family.constraints, s.roles) for s in streams)


def grasps(
    context: Context, robot: Robot, name: str, streams: list[GraspStream], situation: Situation, refusals: Refusals
) -> Iterator[Grasp]:
    """Every proven grasp of the streams, in their order, within the context's number of batches."""
    workspace = Workspace.of(context.surroundings, robot.name, situation)
    under = tuple((name, other) for other in supports(context.surroundings, situation, name))
    for stream in streams:
        for found in context.drawn(stream):
            grasp = _grasp(workspace, stream, name, found, under, refusals)
            if grasp is not None:
                yield grasp


def _grasp(
    workspace: Workspace,
    stream: GraspStream,
    name: str,
    at: Candidate,
    under: tuple[Pair, ...],
    refusals: Refusals,
) -> Grasp | None:
    hit = workspace.first_hit(at.q)
    if hit is not None:
        refusals.add("collision", hit)
        return None
    family, tool = stream.family, stream.tool
    approach = stroked(workspace, family.approach, stream.roles, at, tool, refusals, back=True)
    if approach is None:
        return None
    touch = workspace.touching(name)
    closed = _closed(workspace.robot, at.q, family)
    closing = workspace.permitting(touch)
    hit_index = closing.segment_hit(at.q, closed)
    if hit_index >= 0:
        refusals.add("collision", closing.pairs[hit_index])
        return None
    (world_T_body,) = workspace.surroundings.poses(workspace.situation, name)
    frame = f"{workspace.robot.name}.{workspace.robot.tool.frame}" if workspace.robot.tool else ""
    held = attachment(frame, inverse(at.pose(tool)) @ world_T_body)
    free = workspace.grasping(name, held)
    lifting = free.permitting(under)
    lift = stroked(lifting, family.lift, stream.roles, candidate(workspace.robot, closed), tool, refusals)
    if lift is None:
        return None
    hit = free.first_hit(lift[-1]) if family.lift is not None else None
    if hit is not None:
        refusals.add("collision", hit)
        return None
    return Grasp(approach[::-1], closed, lift, held, contacts(touch), contacts((*touch, *under)))


def _closed(robot: Robot, q: Array, family: GraspFamily) -> Array:
    closed = None if robot.gripper is None else robot.gripper.closed
    return with_hand(robot, q, closed if family.fingers is None else family.fingers)


def stroked(
    workspace: Workspace,
    stroke: Stroke | None,
    roles: Roles,
    at: Candidate,
    tool: Frame,
    refusals: Refusals,
    *,
    back: bool = False,
) -> list[Array] | None:
    """The way points of a stroke from a candidate (against it if `back`), as long as can be proven, or None."""
    if stroke is None:
        return [at.q]
    along = direction(stroke, roles, at) * (-1.0 if back else 1.0)
    refused = Refused()
    for length in lengths(stroke.minimum, stroke.maximum):
        way = line(workspace, at.q, tool, along * length)
        if not isinstance(way, Refused):
            return way
        refused = way
    if refused.pairs:
        refusals.extend("collision", refused.pairs)
    else:
        refusals.add("constraint")
    return None
