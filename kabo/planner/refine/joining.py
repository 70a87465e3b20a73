"""Shortens the free motion of each robot across the stages and tasks of a stretch of the plan.

The purposes of the tasks are kept: the poses at which objects are grasped, released or looked at, and the strokes
to and from these poses. Between them, a robot's motion forms one run, whichever tasks its pieces were planned for.
Each run is shortened as a whole, and the configurations in which one task ends and the next begins are chosen
anew.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import ProcedureContext, Refusal, Situation, candidate, tool_frame, way_to
from kabo.plan import Segment
from kabo.planner.refine.freedom import Freedoms
from kabo.planner.refine.legs import Leg, legs_of, proven
from kabo.scene import Component
from kabo.streams import stream_key
from kabo.tasks.robots.motion.constraints import keep_of
from kabo.tasks.robots.motion.parts import MotionPart
from kabo.tasks.robots.scenes import configuration
from kabo.ways import FreeSpace, shortened

LEAST_GAIN = 1e-3  # rad by which a motion has to get shorter
SHARES = (0.5, 0.25, 0.75, 1.0)  # of a run, where one act may end and the next begin, if it has to move in it


@dataclass(frozen=True)
class ActMotion:
    """The motion of one plan node, the components that it changes, and the changes to it that are permitted."""

    motion: tuple[Segment, ...]
    changes: Mapping[str, Component]
    freedoms: Freedoms


@dataclass(frozen=True)
class Effort:
    """The effort for each run: the number of shortcuts, and of new paths if the straight one collides."""

    shortcuts: int = 150
    ways: int = 3


@dataclass(frozen=True)
class _RunPiece:
    """A part of a leg; only loose pieces may be replaced."""

    act: int
    leg: int
    path: Array  # (m, n)
    loose: bool
    way: MotionPart | None  # in whose scene its act may go another way; None of the rest of a stroke


Run = list[_RunPiece]


def joined(
    context: ProcedureContext, start: Situation, acts: Sequence[ActMotion], effort: Effort, *, pinned: bool = True
) -> list[ActMotion]:
    """The acts with shorter motion, proven collision-free, with the same start, grasps and releases.

    Args:
        context: the context of the geometry server.
        start: the situation in which the first act begins.
        acts: the motions of consecutive nodes.
        effort: the number of attempts to shorten each run.
        pinned: whether the robots must end in the same configurations; if not, a stroke at the end is cut to its
            least length.
    """
    made = list(acts)
    robots = dict.fromkeys(segment.robot for act in acts for segment in act.motion)
    for robot in robots:
        done = 0
        while True:  # what is known of the pieces changes with every run that is replaced
            runs = _runs(context, start, made, robot)
            if done >= len(runs):
                break
            made = _replaced(context, start, made, runs[done], robot, effort)
            done += 1
        if not pinned:
            made = _trimmed(context, start, made, robot)
    return made


def without_rest(
    context: ProcedureContext, start: Situation, act: ActMotion, robot: str
) -> tuple[ActMotion, Array] | None:
    """An act without the rest of the stroke at its end, and that rest (m, n); None if there is none."""
    legs = legs_of(context, start, act.motion)
    pieces = [] if legs is None else list(_pieces(legs, act.freedoms, 0))
    if legs is None or len(pieces) < 2 or not pieces[-1].loose or pieces[-1].way is not None:
        return None
    motion = _rebuilt(legs, act.freedoms, pieces[-1:], 0, pieces[-1].path[:1])
    changes = {**act.changes, robot: _end(motion, robot, context, start)}
    return replace(act, motion=motion, changes=changes), pieces[-1].path


def lengths(acts: Sequence[ActMotion]) -> float:
    """The total path length of all segments of the acts [rad or m, L2 over the joints of each segment]."""
    return sum(segment_length(segment) for act in acts for segment in act.motion)


def segment_length(segment: Segment) -> float:
    """The length of a segment's path [rad or m, L2 over its joints]."""
    return float(np.linalg.norm(np.diff(np.array(segment.waypoints), axis=0), axis=1).sum())


# -------------------------------------------------------------------------------------------------------- runs
def _situations(start: Situation, acts: Sequence[ActMotion]) -> list[Situation]:
    found = [start]
    for act in acts:
        found.append(found[-1].replace(act.changes))
    return found


def _runs(context: ProcedureContext, start: Situation, acts: Sequence[ActMotion], robot: str) -> list[Run]:
    """The runs of a robot, in order of time: consecutive loose pieces, at least one of them a free path."""
    runs: list[Run] = [[]]
    for number, (act, situation) in enumerate(zip(acts, _situations(start, acts), strict=False)):
        if not any(segment.robot == robot for segment in act.motion):
            continue
        legs = legs_of(context, situation, act.motion)
        if legs is None:
            runs.append([])
            continue
        for piece in _pieces(legs, act.freedoms, number):
            last = runs[-1][-1] if runs[-1] else None
            if not piece.loose:
                runs.append([])
            elif last is not None and not _goes_on(last, piece, acts, legs):
                runs.append([piece])
            else:
                runs[-1].append(piece)
        if runs[-1] and runs[-1][-1].way is not None and not act.freedoms.anywhere:
            runs.append([])  # its way leads to where it has to end
    return [run for run in runs if any(piece.way is not None for piece in run)]


def _goes_on(last: _RunPiece, piece: _RunPiece, acts: Sequence[ActMotion], legs: Sequence[Leg]) -> bool:
    """Whether a piece begins where the previous one ends, under the same constraint."""
    if np.abs(last.path[-1] - piece.path[0]).max() > 1e-6:
        return False
    before = acts[last.act].motion[last.leg]
    return last.way is None or before.constraint == legs[piece.leg].segment.constraint


def _pieces(legs: Sequence[Leg], freedoms: Freedoms, act: int) -> Iterator[_RunPiece]:
    """The pieces of an act's legs; a stroke beside a free path is cut into the part to keep and a loose part."""
    kinds = [
        freedoms.of(leg.segment.stage if leg.arm and leg.segment.trajectory is None else None) for leg in legs
    ]
    for k, (leg, freedom) in enumerate(zip(legs, kinds, strict=True)):
        after_way = k > 0 and kinds[k - 1].kind == "way"
        before_way = k + 1 == len(legs) or kinds[k + 1].kind == "way"
        if freedom.kind == "way":
            yield _RunPiece(act, k, leg.path, True, leg.part)
        elif freedom.kind == "stroke" and after_way:
            kept, loose = _cut(leg, leg.path[::-1], freedom.least)
            yield from _split(act, k, [(loose[::-1], True), (kept[::-1], False)])
        elif freedom.kind == "stroke" and before_way:
            kept, loose = _cut(leg, leg.path, freedom.least)
            yield from _split(act, k, [(kept, False), (loose, True)])
        else:
            yield _RunPiece(act, k, leg.path, False, None)


def _split(act: int, leg: int, parts: Sequence[tuple[Array, bool]]) -> Iterator[_RunPiece]:
    for path, loose in parts:
        if len(path) > 1:
            yield _RunPiece(act, leg, path, loose, None)


def _cut(leg: Leg, path: Array, least: float) -> tuple[Array, Array]:
    """A path (m, n) cut after the tool's first `least` metres; the second part is one way point if nothing is left."""
    robot = leg.part.scene.robot(leg.segment.robot)
    if robot.tool is None:
        return path, path[-1:]
    points = np.array([candidate(robot, q).pose(tool_frame(robot))[:3, 3] for q in path])
    passed = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    if passed[-1] <= least * (1.0 + 1e-6):
        return path, path[-1:]
    k = int(np.searchsorted(passed, least))
    share = (least - passed[k - 1]) / (passed[k] - passed[k - 1])
    if share > 1.0 - 1e-3:
        return path[: k + 1], path[k:]
    at = np.array(configuration(path[k - 1] + share * (path[k] - path[k - 1])))
    return np.vstack([path[:k], at]), np.vstack([at, path[k:]])


# --------------------------------------------------------------------------------------------------- replacing
def _replaced(
    context: ProcedureContext, start: Situation, acts: list[ActMotion], run: Run, robot: str, effort: Effort
) -> list[ActMotion]:
    """The acts with a shorter path along a run; unchanged if none is found, or if it is not proven for all acts."""
    path = _joint(run)
    found = _shorter(context, path, [piece.way for piece in run if piece.way is not None], robot, effort)
    if _length(found) > _length(path) - LEAST_GAIN:
        return acts
    for portions in _portions(found, run, acts):
        changed = _with(context, start, acts, run, portions, robot, max(portions) + 1)
        if changed is not None and _situations(start, acts)[-1].key != _situations(start, changed)[-1].key:
            continue
        if changed is not None and lengths(changed) < lengths(acts) - LEAST_GAIN / 2:
            return changed
    return acts


def _trimmed(context: ProcedureContext, start: Situation, acts: list[ActMotion], robot: str) -> list[ActMotion]:
    """The acts with a robot's last stroke cut to its least length, where nothing follows it."""
    number = max(k for k, act in enumerate(acts) if any(segment.robot == robot for segment in act.motion))
    legs = legs_of(context, _situations(start, acts)[number], acts[number].motion)
    pieces = [] if legs is None else list(_pieces(legs, acts[number].freedoms, number))
    if len(pieces) < 2 or not pieces[-1].loose or pieces[-1].way is not None:
        return acts
    changed = _with(context, start, acts, pieces[-1:], {number: pieces[-1].path[:1]}, robot, len(acts))
    return acts if changed is None else changed


def _joint(run: Run) -> Array:
    rows = [run[0].path, *(piece.path[1:] for piece in run[1:])]
    return np.vstack(rows)


def _length(path: Array) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def _shorter(
    context: ProcedureContext, path: Array, ways: Sequence[MotionPart], robot: str, effort: Effort
) -> Array:
    """A path with the same ends, no longer than the one given, and proven in the scenes of all `ways`."""
    part = ways[0]
    n, hand = part.scene.robot(robot).planned, path[0, part.scene.robot(robot).planned :]

    def whole(q: Array) -> Array:
        return np.concatenate([q, hand])

    def free(a: Array, b: Array) -> int:
        return -1 if all(way.proven(whole(a), whole(b)) for way in ways) else 0

    if free(path[0, :n], path[-1, :n]) < 0:
        return path[[0, -1]]
    keep = keep_of(part.scene, robot, part.stretch.constraint)
    kept = None if keep is None else keep.kept_rows
    space = FreeSpace(None, lambda a, b: free(a[:n], b[:n]), 1, kept=kept)
    key: tuple[str | int | float, ...]
    key = context.seed, "joined", robot, *map(float, path[0]), *map(float, path[-1])
    found = [path]
    for number in range(effort.ways if keep is None else min(1, effort.ways)):  # keeping one is slow
        samples = context.path_samples
        other = way_to(part.scene.workspace(robot), path[0], path[-1], (*key, number), samples, keep)
        if not isinstance(other, Refusal):
            found.append(np.array(other))
    proven_ones = [p for p in found if p is path or all(free(a[:n], b[:n]) < 0 for a, b in _pairs(p))]
    best = min(proven_ones, key=_length)
    return shortened(best, space, stream_key(*key), effort.shortcuts)


def _pairs(path: Array) -> Iterator[tuple[Array, Array]]:
    return zip(path, path[1:], strict=False)


def _portions(path: Array, run: Run, acts: Sequence[ActMotion]) -> Iterator[dict[int, Array]]:
    """Divisions of a path among the acts of a run; an act that moves nothing else gets a part that is not empty."""
    numbers = list(dict.fromkeys(piece.act for piece in run))
    if len(numbers) == 1:
        yield {numbers[0]: path}
        return
    moving = [not _moves_else(acts[number], run, number) for number in numbers[:-1]]
    for share in SHARES if any(moving) else (0.0,):
        at, cuts = 0.0, [0.0]
        for needed in moving:
            at = at + share * (1.0 - at) if needed else at
            cuts.append(at)
        parts = [_portion(path, a, b) for a, b in zip(cuts, [*cuts[1:], 1.0], strict=True)]
        yield dict(zip(numbers, parts, strict=True))


def _moves_else(act: ActMotion, run: Run, number: int) -> bool:
    """Whether an act moves the arm outside of a run."""
    loose = {piece.leg for piece in run if piece.act == number and piece.way is not None}
    return any(k not in loose for k in range(len(act.motion)))


def _portion(path: Array, low: float, high: float) -> Array:
    """A path between two shares of its length."""
    passed = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    inner = path[(passed > low * passed[-1] + 1e-9) & (passed < high * passed[-1] - 1e-9)]
    ends = [_point(path, passed, share * passed[-1]) for share in (low, high)]
    return np.vstack([ends[0], inner, ends[1]])


def _point(path: Array, passed: Array, at: float) -> Array:
    k = int(np.clip(np.searchsorted(passed, at, side="right") - 1, 0, len(path) - 2))
    width = passed[k + 1] - passed[k]
    share = 0.0 if width == 0.0 else min(1.0, max(0.0, (at - passed[k]) / width))
    if share in (0.0, 1.0):
        return np.asarray(path[k + int(share)])
    return np.array(configuration(path[k] + share * (path[k + 1] - path[k])))


def _with(
    context: ProcedureContext,
    start: Situation,
    acts: list[ActMotion],
    run: Run,
    portions: Mapping[int, Array],
    robot: str,
    end: int,
) -> list[ActMotion] | None:
    """The acts with portions of a path in place of a run; None if an act before number `end` is not proven then."""
    made, before = list(acts), _situations(start, acts)
    for number, portion in portions.items():
        legs = legs_of(context, before[number], acts[number].motion)
        if legs is None:
            return None
        motion = _rebuilt(legs, acts[number].freedoms, run, number, portion)
        changes = {**acts[number].changes, robot: _end(motion, robot, context, before[number])}
        made[number] = replace(acts[number], motion=motion, changes=changes)
    after = _situations(start, made)
    for number in range(min(portions), end):
        if made[number].motion and not proven(context, after[number], made[number].motion):
            return None
    return made


def _rebuilt(legs: Sequence[Leg], freedoms: Freedoms, run: Run, act: int, portion: Array) -> tuple[Segment, ...]:
    """The segments of an act, with a portion of another path in place of its pieces in a run."""
    gone = {piece.leg: piece for piece in run if piece.act == act}
    ways = [k for k, piece in gone.items() if piece.way is not None]
    motion: list[Segment] = []
    for k, leg in enumerate(legs):
        if k in gone and k in ways:
            if k == ways[0] and _length(portion) > 0.0:
                motion.append(leg.along(portion))
        elif k in gone:
            motion += [leg.along(p.path) for p in _pieces(legs, freedoms, act) if p.leg == k and not p.loose]
        else:
            motion.append(leg.segment)
    return tuple(motion)


def _end(motion: Sequence[Segment], robot: str, context: ProcedureContext, before: Situation) -> Component:
    """Where a robot is after a motion."""
    names, q = context.scene.robots[robot].joint_names, list(before.configuration(robot))
    for segment in motion:
        if segment.robot == robot:
            for joint, value in zip(segment.joints, segment.waypoints[-1], strict=True):
                q[names.index(joint)] = value
    return configuration(q)
