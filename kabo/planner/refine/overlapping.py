"""Computes how early a motion may begin before the previous one has ended without any possible collision.

The volumes swept by the last segments of the first motion and by the whole second motion are proven apart,
independently of timing [K Def. 1.3], so that a late robot causes no collision. All other clearances were proven
for each motion already.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry import Motion, MovingGroup
from kabo.geometry_server import ProcedureContext, ScenePredicates, Situation
from kabo.plan import Segment
from kabo.planner.refine.legs import Leg, legs_of
from kabo.planner.refine.timing import duration
from kabo.scene.transforms import flat, transform

DECIMALS = 6  # of times in seconds
LEAST_OVERLAP_S = 0.01  # seconds; a smaller overlap is not used
ROUNDING_M = 1e-9  # metres by which boxes grow for the rounding of poses
MAX_CLOSE_PAIRS = 2000  # pieces of moving bodies whose boxes meet; with more, the motions count as meeting


@dataclass(frozen=True)
class SituatedMotion:
    """A motion and the situation in which it begins."""

    situation: Situation
    motion: tuple[Segment, ...]


def greatest_overlap(
    context: ProcedureContext, first: SituatedMotion, second: SituatedMotion, most: float
) -> float:
    """The greatest time [s] by which the second motion may begin before the first ends; 0 if it must wait.

    Args:
        context: the context of the geometry server.
        first, second: motions of different robots with different objects.
        most: the greatest permitted overlap [s]; only an overlap of this length may start
            within a segment of the first motion.
    """
    legs, others = legs_of(context, *_of(first)), legs_of(context, *_of(second))
    if legs is None or others is None:
        return 0.0
    end, limit = duration(first.motion), min(most, duration(second.motion))
    theirs = [_body(leg) for leg in others]
    reached = 0.0
    for leg in reversed(legs):
        if reached >= limit or any(_may_meet(context, _body(leg), other) for other in theirs):
            break
        reached = end - leg.segment.times[0]
    found = np.floor(min(reached, limit) * 10**DECIMALS) / 10**DECIMALS
    return float(found) if found >= LEAST_OVERLAP_S else 0.0


def _of(moved: SituatedMotion) -> tuple[Situation, tuple[Segment, ...]]:
    return moved.situation, moved.motion


@dataclass(frozen=True)
class _Body:
    """The moving bodies of a leg with their names and motion, and a box around what each sweeps on each piece."""

    names: tuple[str, ...]
    motion: Motion
    low: Array  # (m - 1, bodies, 3) [m]
    high: Array


def _body(leg: Leg) -> _Body:
    scene, name = leg.part.scene, leg.segment.robot
    robot, surroundings = scene.robot(name), scene.context.surroundings
    found: list[tuple[str, MovingGroup]] = []
    for link in robot.links.values():
        if link.mesh is not None and not robot.stands(link.name):
            own, arrays = f"{name}.{link.name}", (link.mesh.vertices, link.mesh.faces)
            enclosure = surroundings.enclosure(own)
            placed = flat(link.joint_T_link)
            found.append(
                (own, MovingGroup(link.joint, placed, enclosure, arrays, link.elements, surroundings.asked(own)))
            )
    for held in scene.situation.carried(name):
        at, body = scene.situation.held(held), scene.context.scene.bodies[held]
        link = robot.links[at.parent.partition(".")[2]]
        pose = flat(link.joint_T_link @ transform(at.position, at.quaternion))
        enclosure, arrays = surroundings.enclosure(held), (body.mesh.vertices, body.mesh.faces)
        kept = surroundings.asked(held, name)
        found.append((held, MovingGroup(link.joint, pose, enclosure, arrays, body.elements, kept)))
    motion = Motion(robot.tree, tuple(group for _, group in found), leg.path)
    boxes = np.array([[_box(swept) for swept in motion.swept(*piece, 1)] for piece in motion.segments])
    return _Body(tuple(own for own, _ in found), motion, boxes[..., 0, :], boxes[..., 1, :])


def _box(swept: Any) -> Array:
    """The box (2, 3) around what a body sweeps on a piece: around its parts at both ends, grown by their deviation."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for pose in swept.poses:
        turn, centre = pose[:9].reshape(3, 3), swept.extents[:, :3]
        middle, half = centre @ turn.T + pose[9:], swept.extents[:, 3:6] @ np.abs(turn).T
        grown = half + swept.bounds[:, :1] + ROUNDING_M
        low = np.minimum(low, (middle - grown).min(axis=0))
        high = np.maximum(high, (middle + grown).max(axis=0))
    return np.array([low, high])


def _may_meet(context: ProcedureContext, first: _Body, second: _Body) -> bool:
    """Whether the bodies of two legs may meet, each leg at any of its moments."""
    shape = first.low.shape[:2], second.low.shape[:2]
    mine, theirs = (body.low.reshape(-1, 3) for body in (first, second))
    ends = first.high.reshape(-1, 3), second.high.reshape(-1, 3)
    margin = context.surroundings.budget.epsilon + context.surroundings.greatest_kept
    near = (mine[:, None] <= ends[1][None] + margin).all(axis=2) & (theirs[None] <= ends[0][:, None] + margin).all(
        axis=2
    )
    close = [(divmod(int(i), shape[0][1]), divmod(int(k), shape[1][1])) for i, k in np.argwhere(near)]
    never = context.surroundings.never_collide
    close = [each for each in close if not never(first.names[each[0][1]], second.names[each[1][1]])]
    return len(close) > MAX_CLOSE_PAIRS or any(_meet(context, first, second, *each) for each in close)


def _meet(
    context: ProcedureContext, first: _Body, second: _Body, mine: tuple[int, int], theirs: tuple[int, int]
) -> bool:
    predicates = ScenePredicates(context.surroundings, context.scene.start)
    alone = [
        Motion(body.motion.tree, (body.motion.bodies[number],), body.motion.waypoints[piece : piece + 2])
        for body, (piece, number) in ((first, mine), (second, theirs))
    ]
    return predicates.sweeps(alone[0], alone[1])
