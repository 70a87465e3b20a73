"""Refused calls that epsilon alone decides: attempts that pass with the original meshes, and an epsilon that may do.

A call is repeated at the least effort, on a server of its own, and attempts that something blocked are asked again with
exact geometry. It is done once a run has ended without a plan, for the first of the calls that were refused.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from kabo.errors import CutOff
from kabo.geometry_server import BLOCKED_REASONS, GeometryServer, Measure, Refusal, millimetres
from kabo.language.formulas import GroundCall
from kabo.options import LARGEST_CLEARANCE, SMALLEST_EPSILON
from kabo.tasks.procedures import GeometricProcedures
from kabo.tasks.records import FORESEEN, Where
from kabo.tasks.refusals import refusal_of
from kabo.tasks.robots.motion.kept_distances import finer_epsilon, kept_between, least_distance

MAX_CALLS = 2  # refused calls that are repeated
MAX_ATTEMPTS = 24  # attempts of each that are asked again with exact geometry
MAX_SEARCHES = 1  # of them searches for a path
DIVISOR = 4  # of epsilon, which is tried where no distance is known


def with_epsilon(
    failures: Sequence[tuple[GroundCall, Refusal]], asked: GeometricProcedures, stop: Callable[[], bool]
) -> list[tuple[GroundCall, Refusal]]:
    """The refused calls; where epsilon alone decides, the refusal has a measure that says which epsilon may do."""
    return with_measures(failures, asked, lambda call, where: epsilon_measure(asked, call, where, stop))


def with_measures(
    failures: Sequence[tuple[GroundCall, Refusal]],
    asked: GeometricProcedures,
    measure_of: Callable[[GroundCall, Where], Measure | None],
) -> list[tuple[GroundCall, Refusal]]:
    """The refused calls, the first that something blocked with what `measure_of` finds of them."""
    found, looked = [], 0
    for call, refusal in failures:
        where = _where(call, asked)
        told = any(measure.decides_alone for measure in refusal.measures)
        blocked = refusal.reason in BLOCKED_REASONS and not refusal.proof and not told
        if blocked and where is not None and looked < MAX_CALLS:
            looked += 1
            measure = measure_of(call, where)
            if measure is not None:
                refusal = replace(refusal, measures=(*refusal.measures, measure))
        found.append((call, refusal))
    return found


def epsilon_measure(
    asked: GeometricProcedures, call: GroundCall, where: Where, stop: Callable[[], bool]
) -> Measure | None:
    """What epsilon alone refuses of a call, with the distance that it takes for a collision and an epsilon that may do.

    None if most attempts fail with exact geometry, too, or if there is no time to find out.
    """
    return Repeated(asked, stop).measure(call, where)


def provable(given: GeometryServer) -> float:
    """The clearance that exact geometry must find for some epsilon to prove the one that is kept [m].

    What touches, and is apart by rounding alone, is not refused because of epsilon.
    """
    return min(given.clearance + SMALLEST_EPSILON, LARGEST_CLEARANCE)


def _where(call: GroundCall, asked: GeometricProcedures) -> Where | None:
    """Where a call was refused with the greatest effort; None if that was known without asking."""
    record = asked.records.of.get(call)
    where = record.places[0] if record is not None and record.places else asked.records.unfinished.get(call)
    return None if where is None or where.effort == FORESEEN or where.attempt else where


@dataclass(frozen=True)
class Passing:
    """A refused attempt that would pass: how far its first pair is apart, if measured, and how far it should be [m]."""

    refusal: Refusal
    apart: float | None
    wanted: float


@dataclass
class Repeated:
    """A call that is repeated on servers of its own, one of them with exact geometry.

    Subclasses ask another server whether attempts would pass, and say what it means.
    """

    asked: GeometricProcedures
    stop: Callable[[], bool]

    def __post_init__(self) -> None:
        given = self.asked.server
        epsilon, seed = given.budget.epsilon, given.seed
        kept, exact = given.clearance, given.surroundings.exact
        own = GeometryServer(given.scene, epsilon, seed, exact, self.stop, clearance=kept)
        self.epsilon, self.procedures = epsilon, GeometricProcedures(own, self.asked.folder)
        self.relaxed = self._relaxed(given)
        self.attempts: list[Refusal] = []

    def _relaxed(self, given: GeometryServer) -> GeometryServer:
        """The server that is asked whether attempts would pass without what may be in the way."""
        return GeometryServer(given.scene, self.epsilon, given.seed, True, self.stop, clearance=provable(given))

    def measure(self, call: GroundCall, where: Where) -> Measure | None:
        """The measure of what it alone refuses; None if most attempts fail without it, too."""

        def observe(_: Any, failure: Any) -> None:
            self.attempts.append(refusal_of(failure))

        try:
            self.procedures.again(call, where.situation, where.attempt, 0, observe, self._enough)
        except CutOff:
            return None
        blocked = self._asked_again()
        passing, looked = self._passing(blocked)
        if 2 * len(passing) * len(blocked) <= looked * len(self.attempts[:MAX_ATTEMPTS]):
            return None
        return self._told(passing, looked)

    def _passing(self, blocked: Sequence[Refusal]) -> tuple[list[Passing], int]:
        """The attempts that pass, each with its distances, and how many were looked at while there was time."""
        passing: list[Passing] = []
        for looked, each in enumerate(blocked):
            if self.stop():
                return passing, looked
            try:
                if each.question is not None and each.question.passes(self.relaxed.context()):
                    apart = least_distance(each, self.relaxed.surroundings)
                    passing.append(Passing(each, apart, self._wanted(each)))
            except CutOff:
                return passing, looked
        return passing, len(blocked)

    def _enough(self) -> bool:
        return len(self.attempts) >= MAX_ATTEMPTS or self.stop()

    def _asked_again(self) -> list[Refusal]:
        """The attempts that something blocked and that can be asked again; of searches for a path only the first."""
        found, searches = [], 0
        for each in self.attempts[:MAX_ATTEMPTS]:
            if each.reason in BLOCKED_REASONS and each.question is not None:
                searches += each.question.is_search
                found += [each] if not each.question.is_search or searches <= MAX_SEARCHES else []
        return found

    def _told(self, passing: Sequence[Passing], looked: int) -> Measure:
        gaps = [(each.apart - each.wanted, each.apart, each) for each in passing if each.apart is not None]
        gaps = [gap for gap in gaps if gap[0] >= SMALLEST_EPSILON]
        if not gaps:
            less, of = self.epsilon / DIVISOR, f"{len(passing)} of {looked} attempts"
            said = f"exact geometry would pass in {of}, epsilon = {millimetres(self.epsilon)} does not"
            return self._measure(said, less, less)
        room, apart, nearest = max(gaps, key=lambda each: each[0])
        first, second = nearest.refusal.pairs[0][0]
        said = f"{first} and {second} are {millimetres(apart)} apart, nearer than epsilon = {millimetres(self.epsilon)}"
        return self._measure(said, room, apart)

    def _measure(self, said: str, room: float, required: float) -> Measure:
        said = f"{said} (try --epsilon {finer_epsilon(room, self.epsilon):g})"
        return Measure("epsilon", said, required, self.epsilon, epsilon=True)

    def _wanted(self, refusal: Refusal) -> float:
        """The distance that the first pair is to keep where an attempt was refused [m]."""
        given = getattr(refusal.question, "scene", None)
        situation = None if given is None else given.situation
        return (
            kept_between(self.asked.server.surroundings, situation, refusal.pairs[0][0]) if refusal.pairs else 0.0
        )
