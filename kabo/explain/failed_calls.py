"""What stood in the way of calls that failed: each is made afresh, and every refused attempt looked at.

At the least effort: its samples are the first of those that greater effort drew, so all of them were refused as well.
Each attempt that a body blocked is asked again with the original meshes, and with one body after the other out of the
way; for what is out of reach the least move of the base is looked for that would bring it within reach.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from kabo.errors import CutOff
from kabo.explain.findings import Finding, LeastMove, Row
from kabo.geometry_server import GeometryServer, Pair, Stream, shortfall_of
from kabo.language.formulas import GroundCall
from kabo.scene import Scene
from kabo.tasks.procedures import GeometricProcedures
from kabo.tasks.records import FORESEEN, Record, Where
from kabo.tasks.refusals import reason_of
from kabo.tasks.robots import Details

MOST_CALLS = 12  # that are looked at
MOST_BODIES = 3  # that are put out of the way, for each call
MOST_STREAMS = 3  # whose distance from reach is looked for, for each call
ASKED_AGAIN = 1500  # attempts for each call: more are counted, but not asked again
WAYS, WAYS_AGAIN = 6, 2  # searches for a way, which take longer: after so many no more is looked at


def examined(asked: GeometricProcedures, stop: Callable[[], bool]) -> list[Finding]:
    """What stood in the way of the calls of a run that failed, most telling first.

    Args:
        asked: the procedures of the run; they are left as they are.
        stop: asked now and then; True ends the looking, with what there is.
    """
    failed = [item for item in asked.records.of.items() if item[1].places and item[1].places[0].attempt == 0]
    ranked = sorted(failed, key=lambda item: _rank(item[0], item[1], asked))
    examiner = _Examiner(asked, stop)
    found = []
    for call, record in () if stop() else ranked[:MOST_CALLS]:
        try:
            found.append(examiner.finding(call, record))
        except CutOff:
            break
    return found


def _rank(call: GroundCall, record: Record, asked: GeometricProcedures) -> tuple[bool, bool, int, int, float]:
    """First what never succeeded, for no robot; of that what was sampled, then what is proven, then what was foreseen."""
    where = record.places[0]
    told = 1 if where.failure.proof else 2 if where.effort == FORESEEN else 0
    return _dispensable(call, asked), record.successes > 0, told, -record.failures, where.failure.missing or 0.0


def _dispensable(call: GroundCall, asked: GeometricProcedures) -> bool:
    """Whether the same call did not fail for another robot."""
    records, own = asked.records.of, _unmanned(call, asked.scene)
    others = [other for other in asked.calls if other != call and _unmanned(other, asked.scene) == own]
    return any(other not in records or records[other].successes for other in others)


def _unmanned(call: GroundCall, scene: Scene) -> tuple[object, ...]:
    others = tuple("robot" if value in scene.robots else value for value in call.arguments)
    return call.procedure, others, call.options


@dataclass
class _Seen:
    """The refused attempts of one call: reason, pair, what had been asked."""

    attempts: list[tuple[str, Pair | None, Details | None]] = field(default_factory=list)
    ways: int = 0

    def observe(self, stage: Any, failure: Any) -> None:
        """One attempt was refused."""
        details = failure.details if isinstance(failure.details, Details) else None
        pairs = () if details is None else details.pairs
        pair = max(pairs, key=lambda each: each[1])[0] if pairs else None
        reason = reason_of(failure)
        self.attempts.append((reason, pair, details))
        self.ways += reason == "no_path"


class _Examiner:
    """Makes failed calls afresh on a server of its own that shares nothing with the run but the scene."""

    def __init__(self, asked: GeometricProcedures, stop: Callable[[], bool]) -> None:
        given = asked.server
        own = GeometryServer(given.scene, given.budget.epsilon, given.seed, given.surroundings.exact, stop)
        self.asked, self.scene, self.stop, self.seen = asked, given.scene, stop, _Seen()
        self.procedures = GeometricProcedures(own, asked.folder)
        self.context = own.context()
        exact = GeometryServer(given.scene, given.budget.epsilon, given.seed, True, stop)
        self.exact = None if given.surroundings.exact else exact.context()

    def finding(self, call: GroundCall, record: Record) -> Finding:
        """What stood in the way of one call, where it failed first with the greatest effort."""
        where = record.places[0]
        seen = self.seen = _Seen()
        if where.effort != FORESEEN:
            self.procedures.again(call, where.situation, where.attempt, 0, seen.observe, self.enough)
        if not seen.attempts:  # there was nothing to try
            seen.attempts.append((where.failure.reason, None, None))
        nearer, robot = self._nearer(call, where, seen)
        missing = min((found.metres for found in nearer), default=where.failure.missing) or None
        rows = tuple(self._rows(seen, missing))
        freed = self._freed(call, rows, seen)
        successes, attempts = record.successes, len(seen.attempts) + record.successes
        message, proof = where.failure.message, where.failure.proof
        others = _dispensable(call, self.asked)
        return Finding(call, attempts, successes, rows, message, proof, others, freed, robot, nearer)

    def enough(self) -> bool:
        """Whether no more attempts of the call at hand are to be made."""
        return self.seen.ways >= WAYS or self.stop()

    def _rows(self, seen: _Seen, missing: float | None) -> Iterator[Row]:
        counts = Counter((reason, pair) for reason, pair, _ in seen.attempts)
        passing = Counter((seen.attempts[i][0], seen.attempts[i][1]) for i in self._passing(seen, self.exact))
        for (reason, pair), count in sorted(counts.items(), key=lambda item: (-item[1], str(item[0]))):
            far = missing if reason == "out_of_reach" else None
            yield Row(reason, pair, count, far, passing[reason, pair])

    def _passing(self, seen: _Seen, context: Any, without: str | None = None) -> list[int]:
        """The numbers of the blocked attempts that pass in another context, or with a body out of the way."""
        found, ways, asked = [], 0, 0
        for i, (reason, _, details) in enumerate(seen.attempts):
            question = None if details is None else details.question
            if question is None or context is None or reason not in ("collision", "no_path") or self.stop():
                continue
            ways, asked = ways + (question.search is not None), asked + 1
            if asked > ASKED_AGAIN or (question.search is not None and ways > WAYS_AGAIN):
                continue
            if question.passes(context, without):
                found.append(i)
        return found

    def _freed(self, call: GroundCall, rows: Sequence[Row], seen: _Seen) -> tuple[tuple[str, int], ...]:
        """Bodies that blocked, with the number of attempts that pass without each of them, the greatest first."""
        named = {str(value) for value in (*call.arguments, *(value for _, value in call.options))}
        blocking = Counter[str]()
        for row in rows:
            for name in row.between or ():
                if name in self.scene.bodies and name not in named:
                    blocking[name] += row.count
        first = sorted(blocking.items(), key=lambda item: (-item[1], item[0]))[:MOST_BODIES]
        freed = [(name, len(self._passing(seen, self.context, name))) for name, _ in first]
        return tuple(sorted(freed, key=lambda item: (-item[1], item[0])))

    def _nearer(self, call: GroundCall, where: Where, seen: _Seen) -> tuple[tuple[LeastMove, ...], str | None]:
        """For what is out of reach the least move of the base, and the least one that keeps its height."""
        if all(reason != "out_of_reach" for reason, _, _ in seen.attempts):
            return (), None
        questions = [details.question for _, _, details in seen.attempts if details and details.question]
        streams = [each for question in questions for each in _streams(question.target)]
        streams = streams or self.procedures.wanted(call, where.situation)
        robot = streams[0].robot.name if streams else None
        found = []
        for level in (False, True):
            every = [shortfall_of(stream, level=level) for stream in streams[:MOST_STREAMS] if not self.stop()]
            moves = [each for each in every if each is not None]
            least = min(moves, key=lambda each: each.metres, default=None)
            found += [] if least is None else [LeastMove(least.metres, least.by)]
        return tuple(found), robot


def _streams(target: Any) -> list[Stream]:
    """The stream of a target, if it has one."""
    stream = getattr(target, "stream", None)
    stream = getattr(stream, "stream", stream)
    return [stream] if isinstance(stream, Stream) else []
