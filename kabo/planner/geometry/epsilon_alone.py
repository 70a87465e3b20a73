"""Refused calls that epsilon alone decides: attempts that pass with the original meshes, and an epsilon that may do.

A call is repeated at the least effort, on a server of its own, and attempts that something blocked are asked again with
exact geometry. It is done once a run has ended without a plan, for the first of the calls that were refused.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import floor, log10
from typing import Any

from kabo.errors import CutOff
from kabo.geometry_server import BLOCKED_REASONS, GeometryServer, Measure, Refusal, millimetres
from kabo.language.formulas import GroundCall
from kabo.tasks.procedures import GeometricProcedures
from kabo.tasks.records import FORESEEN, Where
from kabo.tasks.refusals import refusal_of
from kabo.tasks.robots.motion.kept_distances import least_distance

MAX_CALLS = 2  # refused calls that are repeated
MAX_ATTEMPTS = 24  # attempts of each that are asked again with exact geometry
MAX_SEARCHES = 1  # of them searches for a path
DIVISOR = 4  # of epsilon, which is tried where no distance is known
DIGITS = 2  # of an epsilon that is proposed, rounded down


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
        if refusal.reason in BLOCKED_REASONS and not refusal.proof and where is not None and looked < MAX_CALLS:
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


def _where(call: GroundCall, asked: GeometricProcedures) -> Where | None:
    """Where a call was refused with the greatest effort; None if that was known without asking."""
    record = asked.records.of.get(call)
    where = record.places[0] if record is not None and record.places else asked.records.unfinished.get(call)
    return None if where is None or where.effort == FORESEEN or where.attempt else where


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
        return GeometryServer(given.scene, self.epsilon, given.seed, True, self.stop, clearance=given.clearance)

    def measure(self, call: GroundCall, where: Where) -> Measure | None:
        """The measure of what it alone refuses; None if most attempts fail without it, too."""

        def observe(_: Any, failure: Any) -> None:
            self.attempts.append(refusal_of(failure))

        try:
            self.procedures.again(call, where.situation, where.attempt, 0, observe, self._enough)
            blocked = [each for each in self._asked_again() if each.question is not None]
            passing = [each for each in blocked if each.question.passes(self.relaxed.context())]  # type: ignore[union-attr]
        except CutOff:
            return None
        if 2 * len(passing) <= len(self.attempts[:MAX_ATTEMPTS]):
            return None
        return self._told(passing, len(blocked))

    def _enough(self) -> bool:
        return len(self.attempts) >= MAX_ATTEMPTS or self.stop()

    def _asked_again(self) -> list[Refusal]:
        """The blocked attempts that are asked again; of searches for a path only the first."""
        found, searches = [], 0
        for each in self.attempts[:MAX_ATTEMPTS]:
            if each.reason in BLOCKED_REASONS and each.question is not None:
                searches += each.question.is_search
                found += [each] if not each.question.is_search or searches <= MAX_SEARCHES else []
        return found

    def _told(self, passing: Sequence[Refusal], blocked: int) -> Measure:
        found = [(apart, each.pairs[0][0]) for each in passing if (apart := self._apart(each)) is not None]
        gaps = [each for each in found if each[0] > 0.0]
        if not gaps:
            less, of = self.epsilon / DIVISOR, f"{len(passing)} of {blocked} attempts"
            said = f"exact geometry would pass in {of}, epsilon = {millimetres(self.epsilon)} does not"
            return Measure(
                "epsilon", f"{said} (try --epsilon {_rounded(less):g})", less, self.epsilon, epsilon=True
            )
        apart, (first, second) = max(gaps)
        less = min(apart, self.epsilon / 2)
        said = f"{first} and {second} are {millimetres(apart)} apart, nearer than epsilon = {millimetres(self.epsilon)}"
        return Measure("epsilon", f"{said} (try --epsilon {_rounded(less):g})", apart, self.epsilon, epsilon=True)

    def _apart(self, refusal: Refusal) -> float | None:
        """The least distance of the pair that is taken to collide, where it was asked [m]; None of searches for a way."""
        return least_distance(refusal, self.relaxed.surroundings)


def _rounded(metres: float) -> float:
    """A length rounded down to two digits [m]."""
    unit = 10.0 ** (floor(log10(metres)) - DIGITS + 1)
    return round(floor(metres / unit + 1e-9) * unit, 12)
