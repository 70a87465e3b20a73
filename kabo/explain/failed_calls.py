"""Finds out why calls failed: repeats each of them and examines every refused attempt.

Each call is repeated at the lowest effort only: its samples are the first samples of every higher effort, so they
were all refused in the run as well. Each attempt that a body blocked is checked again with the original meshes,
and with one blocking body removed at a time. For targets out of reach, the shortest displacement of the robot's
base that brings them within reach is computed.
"""

from collections import Counter
from collections.abc import Callable, Container, Hashable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from kabo.errors import CutOff
from kabo.explain.findings import Finding, LeastMove, Row, Sample
from kabo.explain.samples import chosen_samples
from kabo.geometry_server import BLOCKED_REASONS, GeometryServer, Measure, Pair, Refusal, moved_base, shortfall_of
from kabo.knowledge import GroundedTask
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.clearance_alone import clearance_measure
from kabo.planner.geometry.epsilon_alone import epsilon_measure, provable
from kabo.planner.proofs.needed_calls import needed_calls
from kabo.scene import Scene
from kabo.tasks.procedures import GeometricProcedures
from kabo.tasks.records import FORESEEN, Record, Where
from kabo.tasks.refusals import refusal_of

MAX_CALLS = 12  # failed calls that are examined
MAX_BODIES = 3  # bodies that are taken out, for each call
MAX_STREAMS = 3  # streams of candidates whose distance from reach is computed, for each call
MAX_REPEATED_ATTEMPTS = 1500  # attempts that are checked again, for each call; more are only counted
MAX_PATH_SEARCHES = 6  # failed searches for a path after which a call is not repeated further
MAX_REPEATED_PATH_SEARCHES = 2  # searches for a path that are checked again, for each check


def examined(
    asked: GeometricProcedures,
    task: GroundedTask,
    stop: Callable[[], bool],
    told: Callable[[list[Finding]], None] = lambda _: None,
) -> list[Finding]:
    """The findings about the failed procedure calls of a run, the most informative first.

    Args:
        asked: the server that answered the calls of the run; it is not changed.
        task: the grounded problem.
        stop: called periodically; when it returns True, the calls that are left are told as they were counted.
        told: called with all findings whenever one more call has been examined.
    """
    found, needed = counted_only(asked, task), _needed(asked, task)
    told(found)
    if stop():
        return found
    examiner, records = _Examiner(asked, needed, stop), dict(_failed(asked))
    for number, finding in enumerate(found):
        try:
            found[number] = examiner.finding(finding.call, records[finding.call])
        except CutOff:
            break
        told(found)
        if stop():
            break
    return found


def counted_only(asked: GeometricProcedures, task: GroundedTask) -> list[Finding]:
    """The failed calls of a run as it counted them, nothing repeated, the most informative first."""
    needed = _needed(asked, task)
    ranked = sorted(_failed(asked), key=lambda item: (item[0] not in needed, *_rank(item[0], item[1], asked)))
    return [_counted(call, record, asked, call in needed) for call, record in ranked[:MAX_CALLS]]


def _failed(asked: GeometricProcedures) -> list[tuple[GroundCall, Record]]:
    """The calls that failed, or were cut off before they could, and their records."""
    records = asked.records
    failed = [item for item in records.of.items() if item[1].places and item[1].places[0].attempt == 0]
    known, cut = {call for call, _ in failed}, {**records.unfinished, **asked.refused_so_far()}
    return failed + [(call, Record(places=[where])) for call, where in cut.items() if call not in known]


def _needed(asked: GeometricProcedures, task: GroundedTask) -> frozenset[GroundCall]:
    return needed_calls(task, [(call, record.places[0].refusal) for call, record in _failed(asked)])


def _counted(call: GroundCall, record: Record, asked: GeometricProcedures, needed: bool) -> Finding:
    """The finding for one call as the run counted its attempts."""
    refusal = record.places[0].refusal
    base = next((each for each in refusal.measures if each.name.startswith("base of ")), None)
    missing = base.missing if base is not None else refusal.missing
    row = Row(
        refusal.reason, None, max(refusal.attempts, 1), missing if refusal.reason == "out_of_reach" else None
    )
    rows: tuple[Row, ...] = (row,)
    blocked = sum(count for _, count in refusal.pairs)
    if refusal.reason in BLOCKED_REASONS and refusal.pairs:
        rows = (replace(row, between=refusal.pairs[0][0]),)
        if blocked <= row.count:  # each attempt was blocked by one pair: how often by which is known
            rows = tuple(replace(row, between=pair, count=count) for pair, count in refusal.pairs)
    attempts = sum(each.count for each in rows) + record.successes
    found = Finding(
        call, attempts, record.successes, rows, refusal.comment, refusal.proof, _dispensable(call, asked)
    )
    return replace(found, measures=refusal.measures, needed=needed, repeated=False)


def _rank(call: GroundCall, record: Record, asked: GeometricProcedures) -> tuple[bool, bool, int, int, float]:
    """The order of findings: calls that never succeeded for any robot first; sampled ones before proofs and forecasts."""
    where = record.places[0]
    rank = 1 if where.refusal.proof else 2 if where.effort == FORESEEN else 0
    return _dispensable(call, asked), record.successes > 0, rank, -record.failures, where.refusal.missing or 0.0


def _dispensable(call: GroundCall, asked: GeometricProcedures) -> bool:
    """Whether the same call with another robot did not fail."""
    records, own = asked.records.of, _unmanned(call, asked.scene)
    others = [other for other in asked.calls if other != call and _unmanned(other, asked.scene) == own]
    return any(other not in records or records[other].successes for other in others)


def _unmanned(call: GroundCall, scene: Scene) -> tuple[object, ...]:
    others = tuple("robot" if value in scene.robots else value for value in call.arguments)
    return call.procedure, others, call.options


@dataclass
class _Seen:
    """Collects the refused attempts of one call, and counts those that found no path."""

    attempts: list[Refusal] = field(default_factory=list)
    ways: int = 0

    def observe(self, stage: Any, failure: Any) -> None:
        """Records a refused attempt."""
        refusal = refusal_of(failure)
        self.attempts.append(refusal)
        self.ways += refusal.reason == "no_path"


class _Examiner:
    """Repeats failed calls on a server of its own, which shares only the scene with the run."""

    def __init__(
        self, asked: GeometricProcedures, needed: Container[GroundCall], stop: Callable[[], bool]
    ) -> None:
        given, self.needed = asked.server, needed
        epsilon, seed, exactly, kept = given.budget.epsilon, given.seed, given.surroundings.exact, given.clearance
        own = GeometryServer(given.scene, epsilon, seed, exactly, stop, clearance=kept)
        self.asked, self.scene, self.stop, self.seen = asked, given.scene, stop, _Seen()
        self.procedures = GeometricProcedures(own, asked.folder)
        self.context = own.context()
        exact = GeometryServer(given.scene, epsilon, seed, True, stop, clearance=provable(given))
        self.exact = None if given.surroundings.exact else exact.context()

    def finding(self, call: GroundCall, record: Record) -> Finding:
        """The finding for one call, in the situation where it first failed at its greatest effort."""
        where = record.places[0]
        seen = self.seen = _Seen()
        if where.effort != FORESEEN:
            self.procedures.again(call, where.situation, where.attempt, 0, seen.observe, self.enough)
        if not seen.attempts:  # there was nothing to try
            seen.attempts.append(Refusal(where.refusal.reason))
        kept = None if where.refusal.proof else clearance_measure(self.asked, call, where, self.stop)
        nearer, robot = self._nearer(call, where, seen)
        missing = min((found.metres for found in nearer), default=where.refusal.missing) or None
        rows = tuple(self._rows(seen, missing))
        freed = self._freed(call, rows, seen)
        successes, attempts = record.successes, len(seen.attempts) + record.successes
        message, proof = where.refusal.comment, where.refusal.proof
        others = _dispensable(call, self.asked)
        floor = None if robot is None else self._floor(robot)
        found = Finding(call, attempts, successes, rows, message, proof, others, freed, robot, nearer, floor)
        measures = self._measures(where, seen, () if floor is not None else nearer, robot)
        alone = kept
        if alone is None and 2 * found.because_of_epsilon > found.refused:
            alone = epsilon_measure(self.asked, call, where, self.stop)
        measures = measures if alone is None else (*measures, alone)
        needed, handed, shown = call in self.needed, self._handed_by(call, where), self._samples(where, seen, rows)
        return replace(found, measures=measures, needed=needed, handed_by=handed, samples=shown)

    def _samples(self, where: Where, seen: _Seen, rows: Sequence[Row]) -> tuple[Sample, ...]:
        kinds: list[Hashable] = [(row.reason, row.between, row.said) for row in rows]
        return chosen_samples(self.scene, seen.attempts, where.situation, kinds, _kind, _worst)

    def _measures(
        self, where: Where, seen: _Seen, nearer: Sequence[LeastMove], robot: str | None
    ) -> tuple[Measure, ...]:
        """Of every limit that was not met the value that came nearest; of what is out of reach, the least move as well."""
        nearest: dict[str, Measure] = {}
        for measure in (each for refusal in (where.refusal, *seen.attempts) for each in refusal.measures):
            best = nearest.get(measure.name)
            nearest[measure.name] = measure if best is None or measure.missing < best.missing else best
        name = f"base of {robot}"
        if nearer and nearer[-1].metres and name not in nearest:
            assert robot is not None
            nearest[name] = moved_base(self.scene.robots[robot], nearer[-1].metres, nearer[-1].by)
        return tuple(nearest.values())

    def _handed_by(self, call: GroundCall, where: Where) -> tuple[str, ...]:
        """The other robots that have brought the call's object to where it was when the call failed."""
        named = [str(value) for value in call.arguments]
        own = next((name for name in named if name in self.scene.robots), None)
        thing = next((name for name in named if name in self.scene.movable), None)
        if own is None or thing is None or where.situation.objects[thing] == (self.scene.start.objects[thing],):
            return ()
        done = (other for other, record in self.asked.records.of.items() if record.successes)
        others = (str(value) for other in done if thing in other.arguments for value in other.arguments)
        return tuple(dict.fromkeys(name for name in others if name in self.scene.robots and name != own))

    def _floor(self, robot: str) -> str | None:
        """The region that a robot's base drives in; None if the base stands."""
        drive = self.scene.robots[robot].drive
        return None if drive is None else drive.floor

    def enough(self) -> bool:
        """Whether the present call has been repeated often enough."""
        return self.seen.ways >= MAX_PATH_SEARCHES or self.stop()

    def _rows(self, seen: _Seen, missing: float | None) -> Iterator[Row]:
        counts, passing = Counter(map(_kind, seen.attempts)), Counter(map(_kind, self._passing(seen, self.exact)))
        for (reason, pair, said), count in sorted(counts.items(), key=lambda item: (-item[1], str(item[0]))):
            far = missing if reason == "out_of_reach" else None
            yield Row(reason, pair, count, far, passing[reason, pair, said], said)

    def _passing(self, seen: _Seen, context: Any, without: str | None = None) -> list[Refusal]:
        """The blocked attempts that pass in another context, or without a body."""
        found, ways, asked = [], 0, 0
        for each in seen.attempts:
            question = each.question
            if question is None or context is None or each.reason not in BLOCKED_REASONS or self.stop():
                continue
            ways, asked = ways + question.is_search, asked + 1
            if asked > MAX_REPEATED_ATTEMPTS or (question.is_search and ways > MAX_REPEATED_PATH_SEARCHES):
                continue
            if question.passes(context, without):
                found.append(each)
        return found

    def _freed(self, call: GroundCall, rows: Sequence[Row], seen: _Seen) -> tuple[tuple[str, int], ...]:
        """Bodies that blocked, with the number of attempts that pass without each of them, the greatest first."""
        named = {str(value) for value in (*call.arguments, *(value for _, value in call.options))}
        blocking = Counter[str]()
        for row in rows:
            for name in row.between or ():
                if name in self.scene.bodies and name not in named:
                    blocking[name] += row.count
        first = sorted(blocking.items(), key=lambda item: (-item[1], item[0]))[:MAX_BODIES]
        freed = [(name, len(self._passing(seen, self.context, name))) for name, _ in first]
        return tuple(sorted(freed, key=lambda item: (-item[1], item[0])))

    def _nearer(self, call: GroundCall, where: Where, seen: _Seen) -> tuple[tuple[LeastMove, ...], str | None]:
        """For a target out of reach, the least move of the base and the least one at its height; and the robot."""
        if all(each.reason != "out_of_reach" for each in seen.attempts):
            return (), None
        questions = [each.question for each in seen.attempts if each.question is not None]
        streams = [stream for question in questions for stream in question.streams]
        streams = streams or self.procedures.wanted(call, where.situation)
        robot = streams[0].robot.name if streams else None
        found = []
        levels = (False, True) if robot is None or self._floor(robot) is None else (True,)
        for level in levels:
            every = [shortfall_of(stream, level=level) for stream in streams[:MAX_STREAMS] if not self.stop()]
            moves = [each for each in every if each is not None]
            least = min(moves, key=lambda each: each.metres, default=None)
            found += [] if least is None else [LeastMove(least.metres, least.by)]
        return tuple(found), robot


def _kind(refusal: Refusal) -> tuple[str, Pair | None, str | None]:
    """What attempts are counted by."""
    return refusal.reason, _worst(refusal), _said(refusal)


def _said(refusal: Refusal) -> str | None:
    """What a stage said of an attempt for which no number, pair or distance speaks."""
    told = refusal.measures or refusal.pairs or refusal.reason in ("out_of_reach", "no_path", "collision")
    return None if told or not refusal.comment else refusal.comment


def _worst(refusal: Refusal) -> Pair | None:
    """The pair that came too close most often; None if none did."""
    return max(refusal.pairs, key=lambda each: each[1])[0] if refusal.pairs else None
