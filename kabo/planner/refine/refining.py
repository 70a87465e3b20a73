"""Refines a plan: makes the motion along its linear stretches faster, never slower.

A stretch is a chain of nodes with one predecessor and one successor each. Actions, knowledge and proofs are kept.
Each stretch begins and ends in the same geometric state as before, except that the end may change if only the goal
follows. Every changed motion is proven collision-free again, for all values that components may have there.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter

from kabo.errors import CutOff
from kabo.geometry_server.answers import Success
from kabo.geometry_server.situation import Situation
from kabo.planner.geometry.evaluation import Variant
from kabo.planner.refine.at_once import chains, hastened_acts, lanes_of
from kabo.planner.refine.estimating import estimated_seconds
from kabo.planner.refine.freedom import NONE, Freedoms, freedoms
from kabo.planner.refine.hastening import faster
from kabo.planner.refine.joining import ActMotion, Effort, joined, segment_length
from kabo.planner.refine.junctions import move_rests
from kabo.planner.refine.legs import legs_of
from kabo.planner.refine.overlapping import SituatedMotion, greatest_overlap
from kabo.planner.refine.refining_choice import AlternativeChoice, PlanDraft
from kabo.planner.refine.refining_stops import Stop, seconds_of, stops_of, stretches_of
from kabo.planner.refine.timing import duration, timed
from kabo.tasks.procedures import GeometricProcedures

SAMPLES = 20_000  # samples that tasks may draw for other solutions
BETTER = 1e-6  # seconds by which a motion has to differ to count as slower


@dataclass(frozen=True)
class RefinementFigures:
    """Length [rad or m, L2] and duration [s] of the longest branch, before and after, and the sum of all overlaps [s].

    Both durations are computed with the same acceleration limits, so that they can be compared.
    """

    length_found: float
    length: float
    duration_found: float
    duration: float
    overlap: float
    seconds: float

    def written(self) -> dict[str, float]:
        """The figures as a dictionary, with the keys of the plan's statistics."""
        return {
            "path_length_found": self.length_found,
            "path_length": self.length,
            "duration_found": self.duration_found,
            "duration": self.duration,
            "overlap": self.overlap,
            "refine_s": self.seconds,
        }


def refine(found: "FoundMotion", server: GeometricProcedures, *, samples: int = SAMPLES) -> RefinementFigures:
    """Shortens, times and overlaps the motion of a plan in place; returns figures before and after.

    Args:
        found: the motion of an evaluation in which every call succeeded, as it was found.
        server: the server that answered the calls; when its run has to stop, the remaining motion is not changed.
        samples: the number of samples that may be drawn to find other solutions of tasks.
    """
    began = perf_counter()
    found.untime(server)
    stops = found.stops
    stretches = list(stretches_of(stops))
    draft = PlanDraft({stop: stop.answer for stop in stops}, {stop: stop.situation for stop in stops})
    choice = AlternativeChoice(server, stops, draft, samples, partial(_estimated, server))
    for stretch in stretches:
        choice.improve(stretch)
    for stop in stops:
        stop.keep(choice.draft.situations[stop], choice.draft.answers[stop])
    for stretch in stretches:
        with suppress(CutOff):
            _refine(stretch, server)
    paths = {stop: stop.answer for stop in stops}
    time_motion(stops, server)
    paths |= found.restore_faster(stretches)
    freedoms_by_stop = {stop: freedoms_of(stop, server) for stop in stops}
    move_rests(stops, paths, server.server.context(), freedoms_by_stop, server.stop)
    _hasten(paths, server)
    for stretch in stretches:
        _hasten_lanes(stretch, freedoms_by_stop, server)
    overlap = sum(let_overlap(stops, server).values())
    after = longest(stops, length_of), longest(stops, seconds_of)
    return RefinementFigures(found.length, after[0], found.seconds, after[1], overlap, perf_counter() - began)


def _estimated(server: GeometricProcedures, answer: Success | None) -> float:
    """The duration [s] that the motion in an answer is expected to have in the end."""
    if answer is None:
        return 0.0
    lanes = lanes_of(answer.motion)
    robots = server.scene.robots
    return max(estimated_seconds(robots, lane) for lane in (lanes.values() if lanes else (answer.motion,)))


def time_motion(stops: Sequence[Stop], server: GeometricProcedures) -> None:
    """Gives all motion of a plan its trajectories, where the plan's tasks have not."""
    context = server.server.context()
    for stop in stops:
        if stop.answer is not None and stop.answer.motion:
            made = timed(context, stop.situation, stop.answer.motion)
            stop.keep(stop.situation, replace(stop.answer, motion=made))


def _hasten(paths: Mapping[Stop, Success | None], server: GeometricProcedures) -> None:
    """Makes the motion of stops along `paths` faster, as long as there is time."""
    context = server.server.context()
    for stop, answer in paths.items():
        if answer is not None and answer.motion and not server.stop():
            with suppress(CutOff):
                made = faster(context, stop.situation, answer.motion, freedoms_of(stop, server))
                if duration(made) < seconds_of(stop) - BETTER:
                    stop.keep(stop.situation, replace(answer, motion=made))


def _hasten_lanes(stretch: Sequence[Stop], known: Mapping[Stop, Freedoms], server: GeometricProcedures) -> None:
    """Makes motions of several robots at once along a stretch faster, as long as there is time."""
    for chain in chains(stretch, known):
        if server.stop():
            return
        stops, acts = zip(*chain, strict=True)
        pinned = not all(after.is_goal for after in stops[-1].following)
        with suppress(CutOff):
            made = hastened_acts(server.server.context(), acts, pinned=pinned)
            for stop, act in zip(stops, made, strict=True):
                stop.keep(act.situation, act.answer)


class FoundMotion:
    """The motion of a plan as it was found, without times and with them."""

    def __init__(
        self, variants: tuple[Variant, ...], server: GeometricProcedures, began: Callable[[], None] | None = None
    ) -> None:
        """The motion of an evaluation in which every call succeeded; the first variant is the root.

        `began` is called when the root's motion alone has its times.
        """
        self.stops = stops_of(variants, server)
        self._untimed = self._now()
        if began is not None:
            time_motion(self.stops[:1], server)
            began()
        self.length = longest(self.stops, length_of)
        time_motion(self.stops, server)
        self.seconds = longest(self.stops, seconds_of)
        self._timed = self._now()

    def _now(self) -> dict[Stop, tuple[Situation, Success | None]]:
        return {stop: (stop.situation, stop.answer) for stop in self.stops}

    def untime(self, server: GeometricProcedures) -> None:
        """Gives the plan the motion that was found, as paths without times."""
        self._untimed = {
            stop: (at, _untimed(stop, answer, server)) for stop, (at, answer) in self._untimed.items()
        }
        self._keep(self._untimed)

    def time(self, stops: Sequence[Stop] | None = None) -> None:
        """Gives the plan the motion that was found, with its times; only that of some stops, if they are given."""
        self._keep({stop: self._timed[stop] for stop in self.stops if stops is None or stop in stops})

    def restore_faster(self, stretches: Iterable[Sequence[Stop]]) -> dict[Stop, Success | None]:
        """Gives the plan the motion that was found, with its times, where that is faster; returns its paths there."""
        slower = [
            stop
            for stretch in stretches
            for part in self._parts(stretch)
            if self._is_faster(part)
            for stop in part
        ]
        self.time(slower)
        if longest(self.stops, seconds_of) > self.seconds + BETTER:
            slower = self.stops
            self.time()
        return {stop: self._untimed[stop][1] for stop in slower}

    def _parts(self, stretch: Sequence[Stop]) -> Iterator[list[Stop]]:
        """The parts of a stretch that each begin and end in the states in which they did when they were found."""
        part: list[Stop] = []
        for stop in stretch:
            part.append(stop)
            if all(after.is_goal or self._begins_alike(after) for after in stop.following):
                if self._begins_alike(part[0]):
                    yield part
                part = []

    def _begins_alike(self, stop: Stop) -> bool:
        return stop.situation.key == self._timed[stop][0].key

    def _is_faster(self, part: Sequence[Stop]) -> bool:
        answers = [self._timed[stop][1] for stop in part]
        seconds = sum(duration(answer.motion) for answer in answers if answer is not None)
        return sum(map(seconds_of, part)) > seconds + BETTER

    def _keep(self, kept: Mapping[Stop, tuple[Situation, Success | None]]) -> None:
        for stop, (situation, answer) in kept.items():
            stop.keep(situation, answer)


def freedoms_of(stop: Stop, server: GeometricProcedures) -> Freedoms:
    """The permitted changes of the motion of a stop's procedure call."""
    if stop.call is None:
        return NONE
    bodies = (server.scene.bodies.get(str(value)) for value in server.bind(stop.call).arguments.values())
    return freedoms(server.stages(stop.call), [body for body in bodies if body is not None])


def _untimed(stop: Stop, answer: Success | None, server: GeometricProcedures) -> Success | None:
    """An answer without times that its task gave to all of its motion, if they can be given anew: to ways and strokes."""
    if answer is None or not answer.motion or any(each.trajectory is None for each in answer.motion):
        return answer
    known = freedoms_of(stop, server)
    if any(known.of(each.stage).kind == "fixed" for each in answer.motion):
        return answer
    counted = tuple(replace(each, trajectory=None) for each in answer.motion)
    legs = legs_of(server.server.context(), stop.situation, counted)
    return answer if legs is None else replace(answer, motion=counted)


# ------------------------------------------------------------------------------------------------------ refinement
def _refine(stretch: Sequence[Stop], server: GeometricProcedures) -> None:
    """Makes the motion of a stretch shorter.

    Raises:
        CutOff: time or budget is spent; the stretch is as it was.
    """
    server.server.look()
    acts = [
        ActMotion((), {}, NONE)
        if (answer := stop.answer) is None
        else ActMotion(answer.motion, answer.changes, freedoms_of(stop, server))
        for stop in stretch
    ]
    context, start = server.server.context(), stretch[0].situation
    pinned = not all(after.is_goal for after in stretch[-1].following)
    made = joined(context, start, acts, Effort(), pinned=pinned)
    situation = start
    for stop, act in zip(stretch, made, strict=True):
        answer = stop.answer
        kept = None if answer is None else Success(act.motion, act.changes, learned=answer.learned)
        stop.keep(situation, kept)
        situation = situation.replace(act.changes)


# ---------------------------------------------------------------------------------------------------- both at once
def let_overlap(stops: Sequence[Stop], server: GeometricProcedures) -> dict[Stop, float]:
    """Lets motions begin before the previous one ends if the two never collide; returns the overlaps [s]."""
    made: dict[Stop, float] = {}
    for stop in stops:
        for after in stop.following:
            if server.stop() or not _independent(stop, after, server):
                continue
            assert stop.answer is not None
            assert after.answer is not None
            first, second = (
                SituatedMotion(stop.situation, stop.answer.motion),
                SituatedMotion(after.situation, after.answer.motion),
            )
            most = duration(stop.answer.motion) - made.get(stop, 0.0)
            overlap = greatest_overlap(server.server.context(), first, second, most)
            if overlap > 0.0:
                made[after] = overlap
                after.let_begin_early(overlap)
    return made


def _independent(stop: Stop, after: Stop, server: GeometricProcedures) -> bool:
    """Whether a node may begin while the previous one still moves: other robots, other objects, no dependence."""
    actions = stop.first.node.action, after.first.node.action
    if stop.call is None or after.call is None or actions[0] is None or actions[1] is None:
        return False
    if after.ways_in != 1 or set(stop.first.following) != {None} or not (_moves(stop) and _moves(after)):
        return False
    shared = {*server.single(stop.call, stop.situation)} & {*server.single(after.call, after.situation)}
    return not shared and not actions[1].reads & actions[0].effects.writes


def _moves(stop: Stop) -> bool:
    return stop.answer is not None and bool(stop.answer.motion)


# --------------------------------------------------------------------------------------------------------- figures
def length_of(stop: Stop) -> float:
    """The path length of a stop's motion [rad or m, L2]."""
    return 0.0 if stop.answer is None else sum(map(segment_length, stop.answer.motion))


def longest(stops: Sequence[Stop], own: Callable[[Stop], float]) -> float:
    """The greatest sum of `own` over the stops of a branch, among all branches."""
    total: dict[Stop, float] = {}
    for stop in reversed(stops):
        total[stop] = own(stop) + max((total[after] for after in stop.following), default=0.0)
    return total[stops[0]]
