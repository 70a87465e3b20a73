"""Makes motions of several robots at once faster: each robot's lane for itself, and all lanes proven apart again.

A merger lets each robot do its own part at the same time: its lane, from the beginning of the node on. A lane is made
shorter and faster as the motion of a node with one robot is; the others stand still in its proof, as when the merger's
children were planned. Then what different lanes move is proven apart at the new times. What is not proven stays as it was.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

from kabo.geometry_server import ProcedureContext, Situation
from kabo.geometry_server.answers import Success
from kabo.plan import Segment
from kabo.planner.refine.freedom import NONE, Freedoms
from kabo.planner.refine.hastening import faster
from kabo.planner.refine.joining import ActMotion, Effort, joined
from kabo.planner.refine.legs import legs_of, proven, scene_after
from kabo.planner.refine.refining_stops import Stop
from kabo.planner.refine.timing import duration, timed
from kabo.scene import Component
from kabo.tasks.robots.motion.together import Track, met
from kabo.tasks.robots.scenes import TaskScene

FOLLOWING_S = 2e-6  # seconds: a segment of a lane begins when the one before it ends, but for rounding
LEAST_GAIN_S = 1e-3  # seconds that all nodes together must save

Lanes = Mapping[str, tuple[Segment, ...]]  # the segments of each robot


def lanes_of(motion: Sequence[Segment]) -> Lanes | None:
    """The lanes of a motion of several robots that all begin at once, in stages of their own; None of any other motion.

    The segments have no trajectories any more.
    """
    found: dict[str, list[Segment]] = {}
    for segment in motion:
        lane = found.setdefault(segment.robot, [])
        begin = lane[-1].times[-1] if lane else 0.0
        if segment.trajectory is None or abs(segment.times[0] - begin) > FOLLOWING_S:
            return None
        lane.append(replace(segment, trajectory=None))
    stages = [stage for lane in found.values() for stage in {segment.stage for segment in lane}]
    if len(found) < 2 or len(stages) > len(set(stages)):
        return None
    return {robot: tuple(lane) for robot, lane in found.items()}


@dataclass(frozen=True)
class Act:
    """A node of several lanes, or without motion: where it begins, its lanes without times, and what may be changed."""

    situation: Situation
    answer: Success | None
    lanes: Lanes
    freedoms: Freedoms

    @property
    def changes(self) -> Mapping[str, Component]:
        """The components that have new values after the node."""
        return {} if self.answer is None else self.answer.changes

    @property
    def seconds(self) -> float:
        """How long its motion takes."""
        return 0.0 if self.answer is None else duration(self.answer.motion)

    @property
    def after(self) -> Situation:
        """The situation after the node."""
        return self.situation.replace(self.changes)


def act_of(stop: Stop, freedoms: Freedoms) -> Act | None:
    """The act of a stop; None if its motion cannot be changed in lanes."""
    answer = stop.answer
    if answer is None or not answer.motion:
        return Act(stop.situation, answer, {}, NONE) if stop.call is None else None
    lanes = lanes_of(answer.motion)
    if lanes is None or not any(_merged_by(merger, lanes) for merger in freedoms.mergers):
        return None
    if any(freedoms.of(segment.stage).kind == "fixed" for lane in lanes.values() for segment in lane):
        return None
    return Act(stop.situation, answer, lanes, freedoms)


def _merged_by(merger: str, lanes: Lanes) -> bool:
    """Whether each lane is the motion of a child of its own of a merger."""
    children = []
    for lane in lanes.values():
        paths = [(segment.stage or "").split("/") for segment in lane]
        depth = len(merger.split("/"))
        if any("/".join(path[:depth]) != merger for path in paths):
            return False
        children.append({path[depth] for path in paths})
    return len(set().union(*children)) == sum(map(len, children))


def chains(stops: Sequence[Stop], freedoms: Mapping[Stop, Freedoms]) -> Iterator[list[tuple[Stop, Act]]]:
    """The longest chains of a stretch's stops that are acts, those without motion at their ends left out."""
    chain: list[tuple[Stop, Act]] = []
    for stop in (*stops, None):
        act = None if stop is None else act_of(stop, freedoms[stop])
        if stop is not None and act is not None and (chain or act.lanes):
            chain.append((stop, act))
            continue
        while chain and not chain[-1][1].lanes:
            chain.pop()
        if chain:
            yield chain
        chain = []


def hastened_acts(context: ProcedureContext, acts: Sequence[Act], *, pinned: bool) -> list[Act]:
    """The acts with faster motion, proven; as they were where none was found.

    Args:
        context: the context of the geometry server.
        acts: of consecutive nodes.
        pinned: whether the robots must end in the same configurations.
    """
    found = [_hastened(context, act, anyway=True) for act in _joined(context, acts, pinned=pinned)]
    made = [act for act in found if act is not None]
    if (
        len(made) == len(acts)
        and sum(act.seconds for act in made) < sum(act.seconds for act in acts) - LEAST_GAIN_S
    ):
        return made
    return [_hastened(context, act) or act for act in acts]


def _joined(context: ProcedureContext, acts: Sequence[Act], *, pinned: bool) -> list[Act]:
    """The acts with shorter lanes, one robot's after the other's; their motion is still the former one."""
    made = list(acts)
    for robot in dict.fromkeys(robot for act in acts for robot in act.lanes):
        given = [ActMotion(act.lanes.get(robot, ()), act.changes, act.freedoms) for act in made]
        found = joined(context, made[0].situation, given, Effort(), pinned=pinned)
        situation, rows = made[0].situation, []
        for act, own in zip(made, found, strict=True):
            lanes = {**act.lanes, robot: own.motion} if robot in act.lanes else act.lanes
            answer = None if act.answer is None else replace(act.answer, changes=own.changes)
            rows.append(replace(act, situation=situation, answer=answer, lanes=lanes))
            situation = rows[-1].after
        made = rows
    return made


def _hastened(context: ProcedureContext, act: Act, *, anyway: bool = False) -> Act | None:
    """The act with the fastest motion that is proven; None if there is none, or unless `anyway` if it is not faster."""
    if not act.lanes:
        return act
    if not all(proven(context, act.situation, lane) for lane in act.lanes.values()):
        return None
    choices = []
    for lane in act.lanes.values():
        made = [faster(context, act.situation, lane, act.freedoms), timed(context, act.situation, lane)]
        choices.append(made[:1] if duration(made[0]) > duration(made[1]) - LEAST_GAIN_S else made)
    most = float("inf") if anyway else act.seconds - LEAST_GAIN_S
    for lanes in sorted(product(*choices), key=lambda lanes: max(map(duration, lanes))):
        if max(map(duration, lanes)) > most:
            break
        if _apart(context, act, lanes):
            assert act.answer is not None
            return replace(act, answer=replace(act.answer, motion=_merged(lanes)))
    return None


def _apart(context: ProcedureContext, act: Act, lanes: Sequence[Sequence[Segment]]) -> bool:
    """Whether lanes that begin at once are proven apart from each other, and change what the act says."""
    before, changed = TaskScene.of(context, act.situation), dict[str, Component]()
    tracks: list[Track] = []
    for lane in lanes:
        legs, after = legs_of(context, act.situation, lane), scene_after(context, act.situation, lane)
        if legs is None or after is None:
            return False
        after = replace(before, situation=after.situation)
        changed |= _changes(act.situation, after.situation)
        line = tuple((leg.part.stretch, leg.segment) for leg in legs)
        tracks.append(Track(lane[0].robot, before, after, line))
    # What a robot holds is where it was taken: attachments that are computed again differ by rounding.
    if changed.keys() != {name for name, value in act.changes.items() if act.situation.values(name) != (value,)}:
        return False
    return met(before, before.having(act.changes), tracks) is None


def _changes(first: Situation, last: Situation) -> Mapping[str, Component]:
    """The components that have other values in another situation, where each has one."""
    names = (*first.robots, *first.objects)
    return {name: last.values(name)[0] for name in names if first.values(name) != last.values(name)}


def _merged(lanes: Sequence[Sequence[Segment]]) -> tuple[Segment, ...]:
    """The segments of all lanes, ordered by when they begin."""
    return tuple(sorted((segment for lane in lanes for segment in lane), key=lambda segment: segment.times[0]))
