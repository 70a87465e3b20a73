"""Refines a plan: makes the motion along its linear stretches shorter, never longer.

A stretch is a chain of nodes with one predecessor and one successor each. Actions, knowledge and proofs are kept.
Each stretch begins and ends in the same geometric state as before, except that the end may change if only the goal
follows. Every changed motion is proven collision-free again, for all values that components may have there.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib.util import find_spec
from time import perf_counter

from kabo.errors import CutOff
from kabo.geometry_server.answers import Success
from kabo.planner.geometry.evaluation import Variant
from kabo.planner.refine.freedom import NONE, Freedoms, freedoms
from kabo.planner.refine.joining import ActMotion, Effort, joined, segment_length
from kabo.planner.refine.legs import legs_of, proven
from kabo.planner.refine.overlapping import SituatedMotion, greatest_overlap
from kabo.planner.refine.refining_choice import AlternativeChoice, PlanDraft
from kabo.planner.refine.refining_stops import Stop, stops_of, stretches_of
from kabo.planner.refine.timing import duration, timed
from kabo.tasks.procedures import GeometricProcedures

SAMPLES = 20_000  # samples that tasks may draw for other solutions
BETTER = 1e-6  # rad or s by which a motion has to differ to count as longer


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


def refine(
    variants: tuple[Variant, ...], server: GeometricProcedures, *, samples: int = SAMPLES
) -> RefinementFigures:
    """Shortens, retimes and overlaps the motion of a plan's variants in place; returns figures before and after.

    Args:
        variants: the variants of an evaluation in which every call succeeded; the first is the root.
        server: the server that answered the calls; when its run has to stop, the remaining motion is not changed.
        samples: the number of samples that may be drawn to find other solutions of tasks.
    """
    began = perf_counter()
    stops = stops_of(variants, server)
    found = FoundMotion(stops, server)
    stretches = list(stretches_of(stops))
    draft = PlanDraft({stop: stop.answer for stop in stops}, {stop: stop.situation for stop in stops})
    choice = AlternativeChoice(server, stops, draft, samples)
    for stretch in stretches:
        choice.shorten(stretch)
    for stop in stops:
        stop.keep(choice.draft.situations[stop], choice.draft.answers[stop])
    for stretch in stretches:
        with suppress(CutOff):
            _refine(stretch, server)
    _retime(stops, server)
    if longest(stops, seconds_of) > found.seconds + BETTER or longest(stops, length_of) > found.length + BETTER:
        found.restore(stops)
    overlap = sum(let_overlap(stops, server).values())
    after = longest(stops, length_of), longest(stops, seconds_of)
    return RefinementFigures(found.length, after[0], found.seconds, after[1], overlap, perf_counter() - began)


def freedoms_of(stop: Stop, server: GeometricProcedures) -> Freedoms:
    """The permitted changes of the motion of a stop's procedure call."""
    if stop.call is None:
        return NONE
    bodies = (server.scene.bodies.get(str(value)) for value in server.bind(stop.call).arguments.values())
    return freedoms(server.stages(stop.call), [body for body in bodies if body is not None])


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


def _retime(stops: Sequence[Stop], server: GeometricProcedures) -> None:
    """Times all motion anew."""
    for stop in stops:
        if stop.answer is not None:
            with suppress(CutOff):
                stop.keep(stop.situation, _timed(stop, stop.answer, server))


def _timed(stop: Stop, answer: Success, server: GeometricProcedures) -> Success:
    """A node's motion with new times, if it is proven with them."""
    context = server.server.context()
    server.server.look()
    if not answer.motion or legs_of(context, stop.situation, answer.motion) is None:
        return answer
    made = tuple(timed(context, stop.situation, answer.motion, round_corners=find_spec("toppra") is not None))
    return replace(answer, motion=made) if proven(context, stop.situation, made) else answer


class FoundMotion:
    """The motion before refinement, retimed within the same limits, for comparison and as a fallback."""

    def __init__(self, stops: Sequence[Stop], server: GeometricProcedures) -> None:
        self._kept = {stop: (stop.situation, stop.answer) for stop in stops}
        self.length = longest(stops, length_of)
        _retime(stops, server)
        self.seconds = longest(stops, seconds_of)
        self._timed = {stop: (stop.situation, stop.answer) for stop in stops}
        for stop, (situation, answer) in self._kept.items():
            stop.keep(situation, answer)

    def restore(self, stops: Sequence[Stop]) -> None:
        """Restores the motion of the plan before refinement."""
        for stop in stops:
            stop.keep(*self._timed[stop])


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


def seconds_of(stop: Stop) -> float:
    """The time from the end of the previous stop's motion to the end of this one [s]."""
    return 0.0 if stop.answer is None else duration(stop.answer.motion) - stop.first.overlap


def longest(stops: Sequence[Stop], own: Callable[[Stop], float]) -> float:
    """The greatest sum of `own` over the stops of a branch, among all branches."""
    total: dict[Stop, float] = {}
    for stop in reversed(stops):
        total[stop] = own(stop) + max((total[after] for after in stop.following), default=0.0)
    return total[stops[0]]
