"""Moves what is left of a robot's stroke to the nodes that move the robot next, across branches that part or meet.

A node ends at rest. A lift or a retreat is as long as could be had, not as long as it has to be: where the robot goes on
from the end of its least length, the rest becomes part of a free way, which is made shorter. All nodes that end there have
to agree on the new end. Every branch takes one node that ends there and at most one that begins there.
"""

from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from kabo.arrays import Array
from kabo.errors import CutOff
from kabo.geometry_server import ProcedureContext, Situation
from kabo.geometry_server.answers import Success
from kabo.planner.refine.freedom import Freedoms
from kabo.planner.refine.joining import ActMotion, Effort, joined, without_rest
from kabo.planner.refine.legs import legs_of, proven
from kabo.planner.refine.refining_stops import Stop, seconds_of
from kabo.planner.refine.timing import duration, timed
from kabo.scene import Configuration

FACTORS = (
    1.0,
    1.5,
    2.2,
)  # of their least lengths, to which strokes are cut: what is lifted by little has farther to go round
LEAST_GAIN_S = 1e-3  # by which the branches must become faster, all nodes summed up

FreedomsOf = Mapping[Stop, Freedoms]
_Kept = tuple[
    Situation, Success | None, Success | None
]  # where a stop begins, its answer without times and with them


@dataclass(frozen=True)
class Junction:
    """Nodes between which a robot stands still: those that end there, begin there, and lie between."""

    robot: str
    ending: tuple[Stop, ...]
    beginning: tuple[Stop, ...]
    between: tuple[Stop, ...]


def junctions(stops: Sequence[Stop], robot: str) -> Iterator[Junction]:
    """All junctions of a robot but the one in which it starts, in the order of their first stop."""
    place: dict[
        tuple[Stop, bool], tuple[Stop, bool]
    ] = {}  # of a stop's begin (False) or end: a tree of each place

    def root(of: tuple[Stop, bool]) -> tuple[Stop, bool]:
        while (above := place.get(of, of)) != of:
            of = above
        return of

    for stop in stops:
        if not _moves(stop, robot):
            place[root((stop, True))] = root((stop, False))
        for after in stop.following:
            if not after.is_goal:  # where a robot ends does not matter
                place[root((after, False))] = root((stop, True))
    found: dict[tuple[Stop, bool], tuple[list[Stop], list[Stop], list[Stop]]] = {}
    for stop in stops:
        for at_end in (False, True):
            groups = found.setdefault(root((stop, at_end)), ([], [], []))
            if _moves(stop, robot):
                groups[0 if at_end else 1].append(stop)
            elif not at_end:
                groups[2].append(stop)
    start = root((stops[0], False))
    for at, (ending, beginning, between) in found.items():
        if at != start and ending:
            yield Junction(robot, tuple(ending), tuple(beginning), tuple(between))


def move_rests(
    stops: Sequence[Stop],
    paths: MutableMapping[Stop, Success | None],
    context: ProcedureContext,
    freedoms: FreedomsOf,
    stop_now: Callable[[], bool] = lambda: False,
) -> None:
    """Moves the rests of strokes in place where no branch becomes slower.

    Args:
        stops: the stops of a plan in topological order, with their times.
        paths: their answers without times; those that change are replaced.
        context: the context of the geometry server.
        freedoms: the permitted changes of each stop's motion.
        stop_now: asked before each place; if true, the others are left as they are.
    """
    robots = dict.fromkeys(segment.robot for answer in paths.values() if answer for segment in answer.motion)
    for robot in robots:
        for junction in junctions(stops, robot):
            if stop_now():
                return
            with suppress(CutOff):
                for stop, (situation, path, made) in _moved(junction, paths, context, freedoms).items():
                    paths[stop] = path
                    stop.keep(situation, made)


def _moves(stop: Stop, robot: str) -> bool:
    answer = stop.answer
    return answer is not None and (robot in answer.changes or any(s.robot == robot for s in answer.motion))


def _moved(
    junction: Junction, paths: Mapping[Stop, Success | None], context: ProcedureContext, freedoms: FreedomsOf
) -> dict[Stop, _Kept]:
    """What the stops of a junction become with the best rest; nothing if none is proven, or a branch becomes slower."""
    best, gained = dict[Stop, _Kept](), 0.0
    for factor in FACTORS:
        longer = {stop: freedoms[stop].longer(factor) for stop in junction.ending}
        found = _cut_off(junction, paths, context, {**freedoms, **longer})
        gain = sum(seconds_of(stop) - _seconds(answer) for stop, (_, _, answer) in found.items())
        if found and gain > gained:
            best, gained = found, gain
    return best


def _cut_off(
    junction: Junction, paths: Mapping[Stop, Success | None], context: ProcedureContext, freedoms: FreedomsOf
) -> dict[Stop, _Kept]:
    """What the stops of a junction become without all that is longer than strokes have to be; nothing if that fails."""
    robot, rests, cut = junction.robot, list[Array](), dict[Stop, Success]()
    for stop in junction.ending:
        answer = paths[stop]
        made = None
        if answer is not None:
            act = ActMotion(answer.motion, answer.changes, freedoms[stop])
            made = without_rest(context, stop.situation, act, robot)
        if answer is None or made is None:
            return {}
        cut[stop] = replace(answer, motion=made[0].motion, changes=made[0].changes)
        rests.append(made[1])
    if any(not np.array_equal(rest, rests[0]) for rest in rests):
        return {}
    found: dict[Stop, _Kept] = {}
    here = tuple(map(float, rests[0][0]))
    for stop in (*junction.between, *junction.beginning):
        kept = _begun(stop, here, rests[0], robot, paths[stop], context, freedoms)
        if kept is None:
            return {}
        found[stop] = kept
    for stop, answer in cut.items():
        # On another branch the same stop may begin here: it would change at both ends, so the junction stays.
        if stop in found or not proven(context, stop.situation, answer.motion):
            return {}
        found[stop] = stop.situation, answer, replace(answer, motion=timed(context, stop.situation, answer.motion))
    return found if _is_faster(junction, found) else {}


def _begun(
    stop: Stop,
    here: Configuration,
    rest: Array,
    robot: str,
    path: Success | None,
    context: ProcedureContext,
    freedoms: FreedomsOf,
) -> _Kept | None:
    """A stop that begins where the rest (m, n) of a stroke does, and goes along it first; None if it cannot."""
    if stop.situation.values(robot) != (tuple(map(float, rest[-1])),):
        return None
    situation = stop.situation.replace({robot: here})
    if path is None or not path.motion:
        return None if stop.call is not None else (situation, path, path)
    motion = path.motion
    if _moves(stop, robot):
        legs = legs_of(context, stop.situation, motion)
        free = freedoms[stop].of(motion[0].stage).kind == "way" and motion[0].trajectory is None
        if legs is None or not legs[0].arm or not free or motion[0].constraint is not None:
            return None
        longer = legs[0].along(np.vstack([rest, legs[0].path[1:]]))
        act = ActMotion((longer, *motion[1:]), path.changes, freedoms[stop])
        ways = dict.fromkeys((joined(context, situation, [act], Effort())[0].motion, act.motion))
    else:
        ways = dict.fromkeys((motion,))
    made = [(timed(context, situation, way), way) for way in ways if proven(context, situation, way)]
    if not made:
        return None
    times, way = min(made, key=lambda each: duration(each[0]))
    return situation, replace(path, motion=way), replace(path, motion=times)


def _is_faster(junction: Junction, found: Mapping[Stop, _Kept]) -> bool:
    """Whether no branch through a junction becomes slower, and all together become faster."""
    gains = {stop: seconds_of(stop) - _seconds(answer) for stop, (_, _, answer) in found.items()}
    groups = ([gains[stop] for stop in group] for group in (junction.ending, junction.beginning, junction.between))
    return sum(min(group, default=0.0) for group in groups) >= 0.0 and sum(gains.values()) > LEAST_GAIN_S


def _seconds(answer: Success | None) -> float:
    return 0.0 if answer is None else duration(answer.motion)
