"""The procedures, each a pure function of (arguments, situation, seed): move, pick, place, transfer and so on.

Every procedure tries candidates in the order of their streams, builds its motion from stretches that are proven
free, and answers with the first that works, or with what was in the way. (Task files will take the place of this file.)
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt

from kabo.geometry_server import grasping, placing
from kabo.geometry_server.answers import Answer, Failure, Refusals, Success
from kabo.geometry_server.context import Context
from kabo.geometry_server.foresight import may_place
from kabo.geometry_server.frames import tool_frame
from kabo.geometry_server.placing import Target
from kabo.geometry_server.reach import region_missing
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.stretches import Keep, Motion, Refused, keep_constraint, rounded, way_to
from kabo.geometry_server.workspace import Workspace, contacts
from kabo.kinematics import stream_key, uniform
from kabo.scene import Component, Robot

Array = npt.NDArray[np.float64]

RANDOM_POSES = 32  # random configurations that `move` tries
GRASPS = 8  # grasps that `restack` tries, each with its placements


class Procedure(Protocol):
    """A procedure: its arguments by name, the situation, and how many successes to pass over."""

    def __call__(
        self, context: Context, arguments: Mapping[str, str], situation: Situation, attempt: int
    ) -> Answer:
        """The answer."""
        ...


@dataclass(frozen=True)
class Signature:
    """A procedure, its arguments in their order, those by name only with their defaults, and what it concerns.

    `moves` are the arguments whose components change; `reads` those on whose components the samples depend.
    `refute` finds a proof, without sampling, that the call must fail.
    """

    run: Procedure
    parameters: tuple[str, ...]
    optional: Mapping[str, str]
    moves: tuple[str, ...]
    reads: tuple[str, ...]
    refute: Callable[[Context, Mapping[str, str], Situation], Failure | None] | None = None


def _way(
    context: Context,
    workspace: Workspace,
    start: Array,
    goal: Array,
    what: str,
    refusals: Refusals,
    keep: Keep | None = None,
) -> list[Array] | None:
    """The way points from start to goal, or None with the reason noted; its stream is keyed by both ends."""
    key: tuple[str | int | float, ...] = (context.seed, "way", workspace.robot.name, what)
    key += (*map(float, start), *map(float, goal))
    way = way_to(workspace, start, goal, key, context.path_samples, keep)
    if not isinstance(way, Refused):
        return way
    refusals.extend("no_path", way.pairs)
    return None


def _values(robot: Robot, q: Array) -> tuple[float, ...]:
    return tuple(float(v) for v in rounded(q))


def move(context: Context, arguments: Mapping[str, str], situation: Situation, attempt: int) -> Answer:
    """The robot goes home; asked again, to the first, second … random configuration that it can reach."""
    robot = context.scene.robots[arguments["robot"]]
    workspace = Workspace.of(context.surroundings, robot.name, situation)
    start = np.array(situation.configuration(robot.name))
    refusals = Refusals()
    for goal in _waypoints(context, robot, start, attempt):
        if np.array_equal(goal, start):
            refusals.add("constraint")
            continue
        hit = workspace.first_hit(goal)
        if hit is not None:
            refusals.add("collision", hit)
            continue
        way = _way(context, workspace, start, goal, "move", refusals)
        if way is not None:
            motion = Motion(robot, "move")
            motion.arm("move", way)
            return Success(tuple(motion.segments), {robot.name: _values(robot, way[-1])})
    return refusals.failure(f"{robot.name} finds no way to move", frozenset({robot.name}), _movable(context))


def _waypoints(context: Context, robot: Robot, start: Array, attempt: int) -> Iterator[Array]:
    n = robot.planned
    if attempt == 0 and "home" in robot.configurations:
        yield rounded(np.concatenate([robot.configurations["home"], start[n:]]))
        return
    key = stream_key(context.seed, "move", robot.name)
    for number in range((attempt - 1) * RANDOM_POSES, attempt * RANDOM_POSES):
        share = np.array([uniform(key, number, i) for i in range(n)])
        q = robot.tree.lower[:n] + share * (robot.tree.upper[:n] - robot.tree.lower[:n])
        yield rounded(np.concatenate([q, start[n:]]))


def pick(context: Context, arguments: Mapping[str, str], situation: Situation, attempt: int) -> Answer:
    """The robot opens its hand, reaches, approaches, closes and lifts: the object is in its hand."""
    robot, name = context.scene.robots[arguments["robot"]], arguments["object"]
    refusals = Refusals()
    taken = 0
    streams = grasping.families(context, robot, name, arguments["grasp"], situation)
    impossible = pick_refuted(context, arguments, situation)
    if impossible is not None:
        return impossible
    workspace = Workspace.of(context.surroundings, robot.name, situation)
    start = np.array(situation.configuration(robot.name))
    empty = grasping.opened(robot, start)
    index = workspace.segment_hit(start, empty)
    if index >= 0:
        refusals.add("collision", workspace.pairs[index])
        return refusals.failure(f"{robot.name} cannot open its hand", frozenset({robot.name}), _movable(context))
    for grasp in grasping.grasps(context, robot, name, streams, situation, refusals):
        way = _way(context, workspace, empty, grasp.approach[0], "reach", refusals)
        if way is None:
            continue
        taken += 1
        if taken > attempt:
            motion = Motion(robot, "pick")
            motion.hand("open", start, empty)
            motion.arm("reach", way)
            grasp.append_to(motion, name)
            changes: dict[str, Component] = {robot.name: _values(robot, grasp.lift[-1]), name: grasp.held}
            return Success(tuple(motion.segments), changes)
    return refusals.failure(f"{robot.name} cannot pick {name}", frozenset({name}), _movable(context))


def pick_refuted(context: Context, arguments: Mapping[str, str], situation: Situation) -> Failure | None:
    """The proof that an object cannot be grasped where it stands: no family fits, or it is out of reach."""
    robot, name = context.scene.robots[arguments["robot"]], arguments["object"]
    streams = grasping.families(context, robot, name, arguments["grasp"], situation)
    if not streams:
        text = f"{name} has no grasp family that {robot.name} can use"
        return Failure("empty_family", text, proof=True)
    missing = grasping.missing(robot, streams)
    if missing <= 0.0:
        return None
    text = f"{name} is {missing:.3f} m out of reach of {robot.name}"
    return Failure("out_of_reach", text, frozenset({name}), proof=True, missing=missing)


def put_refuted(context: Context, arguments: Mapping[str, str], situation: Situation) -> Failure | None:
    """Why an object cannot be put in a region, however it is held: out of reach, or no grasp found there."""
    robot, body = context.scene.robots[arguments["robot"]], context.scene.bodies[arguments["object"]]
    region = context.scene.regions[arguments["region"]]
    missing = region_missing(robot, body, region, tool_frame(robot))
    if missing > 0.0:
        text = f"{region.name} is {missing:.3f} m out of reach of {robot.name} with {body.name}"
        return Failure("out_of_reach", text, proof=True, missing=missing)
    if may_place(context, robot, body, Target(region.support, region), situation):
        return None
    text = f"{robot.name} found no grasp of {body.name} anywhere in {region.name}"
    return Failure("out_of_reach", text)


def place(context: Context, arguments: Mapping[str, str], situation: Situation, attempt: int) -> Answer:
    """The robot carries what it holds to the region, sets it down, lets go and retreats."""
    return _put(context, arguments, situation, attempt, "place", lets_go=True)


def transfer(context: Context, arguments: Mapping[str, str], situation: Situation, attempt: int) -> Answer:
    """As place, but the object is still held in the end; `keep` names a motion constraint for the way."""
    return _put(context, arguments, situation, attempt, "transfer", lets_go=False)


def _put(
    context: Context,
    arguments: Mapping[str, str],
    situation: Situation,
    attempt: int,
    procedure: str,
    *,
    lets_go: bool,
) -> Answer:
    robot, name = context.scene.robots[arguments["robot"]], arguments["object"]
    region = context.scene.regions[arguments["region"]]
    what = f"{robot.name} cannot {procedure} {name} in {region.name}"
    if not _holds(robot, name, situation):
        return Failure("constraint", f"{what}: it does not hold it", frozenset({name}), proof=True)
    target = Target(region.support, region)
    return _set_down(context, robot, name, target, situation, attempt, procedure, what, arguments, lets_go)


def _set_down(
    context: Context,
    robot: Robot,
    name: str,
    target: Target,
    situation: Situation,
    attempt: int,
    procedure: str,
    what: str,
    arguments: Mapping[str, str],
    lets_go: bool,
) -> Answer:
    refusals, taken = Refusals(), 0
    workspace = Workspace.of(context.surroundings, robot.name, situation)
    start = np.array(situation.configuration(robot.name))
    keep = keep_constraint(context, robot, situation, arguments.get("keep", ""))
    for stream, lowering in placing.lowerings(context, robot, name, target, situation, refusals):
        if keep is not None and not keep.holds_along(lowering.way):
            refusals.add("constraint")
            continue
        below = situation.replace({robot.name: _values(robot, lowering.way[-1])})
        release = None
        if lets_go:
            release = placing.release(context, robot, name, stream.family.retreat, below, refusals)
            if release is None:
                continue
        way = _way(context, workspace, start, lowering.way[0], "transfer", refusals, keep)
        if way is None:
            continue
        taken += 1
        if taken > attempt:
            motion = Motion(robot, procedure)
            permitted = frozenset(pair for pair in lowering.permitted if target.support not in pair)
            motion.arm("transfer", way, permitted, constraint=None if keep is None else keep.name)
            motion.arm("lower", lowering.way, lowering.permitted, constraint=None if keep is None else keep.name)
            changes: dict[str, Component] = {robot.name: _values(robot, lowering.way[-1])}
            if release is not None:
                release.append_to(motion, name, lowering.way[-1])
                changes = {robot.name: _values(robot, release.retreat[-1]), name: lowering.stands}
            return Success(tuple(motion.segments), changes)
    return refusals.failure(what, frozenset({name}), _movable(context))


def release(context: Context, arguments: Mapping[str, str], situation: Situation, attempt: int) -> Answer:
    """The robot lets go of an object that stands in the region, and retreats."""
    robot, name = context.scene.robots[arguments["robot"]], arguments["object"]
    what = f"{robot.name} cannot release {name}"
    if not _holds(robot, name, situation):
        return Failure("constraint", f"{what}: it does not hold it", frozenset({name}), proof=True)
    refusals = Refusals()
    start = np.array(situation.configuration(robot.name))
    let_go = None if attempt else placing.release(context, robot, name, None, situation, refusals)
    if let_go is None:
        return refusals.failure(what, frozenset({name, robot.name}), _movable(context))
    (pose,) = context.surroundings.poses(situation, name)
    region = context.scene.regions[arguments["region"]]
    if not placing.lies_inside(context.surroundings, name, pose, region):
        text = f"{what}: it does not stand in {region.name}"
        return Failure("constraint", text, frozenset({name, robot.name}), proof=True)
    motion = Motion(robot, "release")
    let_go.append_to(motion, name, start)
    stands = placing.attachment("world", pose)
    return Success(tuple(motion.segments), {robot.name: _values(robot, let_go.retreat[-1]), name: stands})


def restack(context: Context, arguments: Mapping[str, str], situation: Situation, attempt: int) -> Answer:
    """The robot picks an object and puts it down on another body."""
    robot, name, other = context.scene.robots[arguments["robot"]], arguments["this"], arguments["other"]
    what = f"{robot.name} cannot put {name} on {other}"
    failure: Failure | None = None
    taken = 0
    for choice in range(GRASPS):
        picked = pick(context, {"robot": robot.name, "object": name, "grasp": "any"}, situation, choice)
        if isinstance(picked, Failure):
            return failure or picked
        held = situation.replace(picked.changes)
        put = _set_down(context, robot, name, Target(other, None), held, 0, "restack", what, {}, lets_go=True)
        if isinstance(put, Failure):
            failure = replace(put, reads=put.reads | {name} | ({other} & set(context.scene.movable)))
            continue
        taken += 1
        if taken > attempt:
            motion = Motion(robot, "restack")
            motion.extend(picked.motion)
            motion.extend(put.motion)
            return Success(tuple(motion.segments), {**picked.changes, **put.changes})
    return failure or Failure("empty_family", f"{what} in yet another way", frozenset({name}))


def sense(context: Context, arguments: Mapping[str, str], situation: Situation, attempt: int) -> Answer:
    """The robot goes to the configuration in which it senses, if it has one; what it holds keeps a constraint."""
    robot, name = context.scene.robots[arguments["robot"]], arguments["object"]
    if attempt:
        return Failure("empty_family", f"{robot.name} senses {name} in one way only", frozenset({name}))
    there = robot.configurations.get(arguments["at"])
    if there is None:
        return Success((), {})
    start = np.array(situation.configuration(robot.name))
    goal = rounded(np.concatenate([there, start[robot.planned :]]))
    refusals = Refusals()
    workspace = Workspace.of(context.surroundings, robot.name, situation)
    keep = keep_constraint(context, robot, situation, arguments["keep"])
    hit = workspace.first_hit(goal)
    if hit is not None:
        refusals.add("collision", hit)
    else:
        way = _way(context, workspace, start, goal, "sense", refusals, keep)
        if way is not None:
            motion = Motion(robot, arguments["procedure"])
            touch = [pair for held in workspace.carried for pair in workspace.touching(held)]
            named = None if keep is None else keep.name
            motion.arm(arguments["at"], way, contacts(touch), constraint=named)
            return Success(tuple(motion.segments), {robot.name: _values(robot, way[-1])})
    what = f"{robot.name} cannot reach its configuration {arguments['at']} with {name}"
    return refusals.failure(what, frozenset({robot.name, name}), _movable(context))


def _holds(robot: Robot, name: str, situation: Situation) -> bool:
    return name in situation.carried(robot.name)


def _movable(context: Context) -> tuple[str, ...]:
    return (*context.scene.robots, *context.scene.movable)


_BOTH, _ROBOT, _OBJECT = ("robot", "object"), ("robot",), ("object",)

PROCEDURES: Mapping[str, Signature] = {
    "move": Signature(move, _ROBOT, {}, _ROBOT, ()),
    "pick": Signature(pick, _BOTH, {"grasp": "any"}, _BOTH, _OBJECT, pick_refuted),
    "place": Signature(place, (*_BOTH, "region"), {"placement": "any"}, _BOTH, _OBJECT, put_refuted),
    "transfer": Signature(
        transfer, (*_BOTH, "region"), {"placement": "any", "keep": ""}, _ROBOT, _OBJECT, put_refuted
    ),
    "release": Signature(release, (*_BOTH, "region"), {}, _BOTH, _BOTH),
    "restack": Signature(restack, ("robot", "this", "other"), {}, ("robot", "this"), ("this", "other")),
    "sense": Signature(sense, _BOTH, {"at": "sense", "keep": ""}, _ROBOT, _OBJECT),
    "sense_weight": Signature(sense, _BOTH, {"at": "weigh", "keep": "upright"}, _ROBOT, _OBJECT),
}
