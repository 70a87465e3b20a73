"""The ledger of lazy geometry: which procedures were refused, and where their refusals hold.

The search takes procedures as possible. It follows each geometric component by its lineage: which call made its
present value, from which lineages. A refusal is a call and the lineages of the components that it rests on: it
holds wherever they are the same, whatever else has changed. Only lineages that a refusal names tell search nodes
apart, so as long as nothing is refused the search is that of the knowledge level alone.

A suspicion is weaker and wider: what was in the way of a call, whatever else it rested on. It refuses nothing, but the
call costs more wherever that is still in the way; so another grasp is not tried before the obstacle is moved.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from math import inf

from kabo import tuning
from kabo.geometry_server import MAX_EFFORT, Failure, Success
from kabo.language.formulas import GroundCall
from kabo.options import Search
from kabo.planner.geometry.procedure_server import ProcedureServer
from kabo.planner.search.skeleton import LearntRefusals, Origin, Pattern, Provenance
from kabo.scene import Component

Derivation = tuple[
    GroundCall, int, int, Pattern
]  # of a lineage: an attempt at a call, what it made, and from what
Provenances = tuple[
    int, ...
]  # the lineage of every component, in the order of `Ledger.components`; 0: as at the start


@dataclass(frozen=True)
class Refusal:
    """A call that fails from `attempt` on, wherever the pattern of lineages holds."""

    attempt: int
    pattern: Pattern
    failure: Failure


@dataclass
class RefusalTable:
    """What the contingent search sees of geometry: lineages, refusals, and attempts where one led nowhere."""

    server: ProcedureServer
    effort: int = 0
    refusals: dict[GroundCall, list[Refusal]] = field(default_factory=dict)
    suspicions: dict[GroundCall, dict[Pattern, None]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        scene = self.server.scene
        self.components = (*scene.robots, *scene.movable)
        self._index = {name: i for i, name in enumerate(self.components)}
        self._numbers: dict[Derivation, int] = {}
        self._number_of_value: dict[
            tuple[int, Component], int
        ] = {}  # the lineage of every value that was met [K Def. 5]
        self._with_value = {0}
        self._value_reads: dict[Derivation, frozenset[str]] = {}  # on what it rested which value a name has
        self._reads: dict[GroundCall, frozenset[int]] = {}
        self._everything = frozenset(range(len(self.components)))
        self._count = 0
        for i, name in enumerate(self.components):
            self._number_of_value[i, scene.start[name]] = 0
        self._options: dict[tuple[GroundCall, Provenances], list[tuple[int, Provenances]]] = {}
        self._origins: dict[Provenance, dict[Origin, None]] = {}
        self._relevant: dict[Provenance, None] = {}
        self._moves: dict[GroundCall, tuple[int, ...]] = {}

    # ------------------------------------------------------------------------------ what the search may ask
    @property
    def start(self) -> Provenances:
        """The trace of the first state."""
        return (0,) * len(self.components)

    def options(self, call: GroundCall, trace: Provenances) -> Sequence[tuple[int, Provenances]]:
        """The attempts at a call that are not refused, with the trace after each.

        A further attempt is offered only where every one before it led to something that was refused.
        """
        known = self._options.get((call, trace))
        if known is None:
            known = self._options[call, trace] = self._found(call, trace)
        return known

    def _found(self, call: GroundCall, trace: Provenances) -> list[tuple[int, Provenances]]:
        limit = min(
            (r.attempt for r in self.refusals.get(call, ()) if all(trace[i] == number for i, number in r.pattern)),
            default=self._max_attempts,
        )
        found = []
        for attempt in range(limit):
            after = self.after(call, attempt, trace)
            found.append((attempt, after))
            if not any((i, after[i]) in self._relevant for i in self.moves(call)):
                break
        return found

    def key(self, trace: Provenances) -> Provenances:
        """The trace without the lineages that no refusal names."""
        tainted = self._relevant
        return tuple(number if (i, number) in tainted else -1 for i, number in enumerate(trace))

    def test(self, call: GroundCall, trace: Provenances) -> bool:
        """Geometric tests in formulas are taken to hold until they are asked."""
        return True

    def confirm(self, trace: Provenances) -> bool:
        """Nothing is asked while searching."""
        return True

    def refused_everywhere(self) -> "tuple[frozenset[GroundCall], bool]":
        """The calls with a refusal of all attempts in all situations; and whether those are all refusals."""
        rows = [(call, not r.attempt and not r.pattern) for call, found in self.refusals.items() for r in found]
        return frozenset(call for call, everywhere in rows if everywhere), all(
            everywhere for _, everywhere in rows
        )

    def most_expansions(self, search: Search) -> float:
        """As many as may be."""
        return inf

    def learnt(self) -> LearntRefusals:
        """Everything but the failures themselves."""
        refusals = {
            call: tuple(dict.fromkeys((r.attempt, r.pattern) for r in rows))
            for call, rows in self.refusals.items()
        }
        suspicions = {call: tuple(rows) for call, rows in self.suspicions.items()}
        origins = {entry: tuple(self._origins[entry]) for entry in self._relevant if self._origins.get(entry)}
        named = tuple(sorted(self._relevant))
        return LearntRefusals(named, origins, refusals, suspicions, self.moves, self._max_attempts)

    @property
    def _max_attempts(self) -> int:
        """How many answers of one call may be asked for at the present effort."""
        return tuning.ATTEMPTS_PER_EFFORT * (1 + self.effort)

    # -------------------------------------------------------------------------------------------- recording
    def moves(self, call: GroundCall) -> tuple[int, ...]:
        """The components that a call moves, as far as is known."""
        known = self._moves.get(call)
        if known is None:
            known = self._moves[call] = tuple(self._index[name] for name in self.server.bind(call).moves)
        return known

    def reads(self, call: GroundCall) -> frozenset[int]:
        """The components on which it depends what a call makes, as far as is known."""
        if self.effort >= tuning.FULL_DEPENDENCE_EFFORT:
            return self._everything
        known = self._reads.get(call)
        if known is None:
            known = self._reads[call] = frozenset(self._index[name] for name in self.server.bind(call).reads)
        return known

    def after(self, call: GroundCall, attempt: int, trace: Provenances) -> Provenances:
        """The trace after a call: what it moves has the lineage of the call and of what its samples depend on."""
        reads = frozenset((i, trace[i]) for i in self.reads(call))
        result = list(trace)
        for i in self.moves(call):
            name = call, attempt, i, reads
            if name not in self._numbers:
                self._numbers[name] = self._new()
            result[i] = self._numbers[name]
            self._note_origin((i, result[i]), Origin(call, attempt, reads))
        return tuple(result)

    def record_success(self, call: GroundCall, attempt: int, trace: Provenances, answer: Success) -> Provenances:
        """The trace after a call that has succeeded: equal values have one lineage, whatever made them.

        What is not declared to be moved (parts of a group hang on another one) is learnt.
        """
        if self.effort:
            self._depend_on(call, answer.reads)
        known = self.moves(call)
        more = tuple(i for i in (self._index[name] for name in answer.changes) if i not in known)
        if more:
            self._moves[call] = known + more
            self._options.clear()
        if not all(self._record_value(call, attempt, trace, name, answer) for name in answer.changes):
            return self.record_success(call, attempt, trace, answer)
        return self.after(call, attempt, trace)

    def _record_value(
        self, call: GroundCall, attempt: int, trace: Provenances, component: str, answer: Success
    ) -> bool:
        """Notes the value of a lineage; False if it had another one: then it depends on more than was known."""
        i, reads = self._index[component], frozenset((i, trace[i]) for i in self.reads(call))
        name, value = (call, attempt, i, reads), (i, answer.changes[component])
        named = self._numbers.get(name)
        if value not in self._number_of_value:
            self._number_of_value[value] = self._new() if named is None or named in self._with_value else named
        number = self._number_of_value[value]
        another = named in self._with_value and named != number
        if another and self._depend_on(call, answer.reads | self._value_reads.get(name, frozenset())):
            return False
        if named != number:
            self._options.clear()
            self._origins.get((i, named or 0), {}).pop(Origin(call, attempt, reads), None)
        self._with_value.add(number)
        self._numbers[name], self._value_reads[name] = number, answer.reads
        return True

    def _depend_on(self, call: GroundCall, names: Iterable[str]) -> bool:
        """What a call makes depends on these as well; whether that is new. What it made until now is forgotten."""
        known = self.reads(call)
        more = frozenset(self._index[name] for name in names) - known
        if not more:
            return False
        self._reads[call] = known | more
        self._options.clear()
        self._numbers = {name: number for name, number in self._numbers.items() if name[0] != call}
        for origins in self._origins.values():
            for origin in [each for each in origins if each.call == call]:
                del origins[origin]
        return True

    def _new(self) -> int:
        self._count += 1
        return self._count

    def _note_origin(self, entry: Provenance, origin: Origin) -> None:
        origins = self._origins.setdefault(entry, {})
        if origin not in origins:
            origins[origin] = None
            if entry in self._relevant:
                self._mark_relevant(origin.reads)

    def _mark_relevant(self, pattern: Pattern) -> None:
        """Marks lineages that tell nodes apart: those of a refusal, and those from which they come."""
        waiting = sorted(pattern)
        while waiting:
            entry = waiting.pop()
            if entry not in self._relevant:
                self._relevant[entry] = None
                for origin in self._origins.get(entry, ()):
                    waiting.extend(sorted(origin.reads))

    def record_refusal(
        self, call: GroundCall, attempt: int, failure: Failure, traces: Iterable[Provenances]
    ) -> None:
        """Notes that a call failed, wherever the components that the failure reads are as in one of the traces."""
        self._options.clear()
        for trace in traces:
            pattern = frozenset((self._index[name], trace[self._index[name]]) for name in failure.reads)
            rows = self.refusals.setdefault(call, [])
            if any(row.pattern == pattern and row.attempt <= attempt for row in rows):
                pattern = frozenset(enumerate(trace))  # known, and asked all the same: at least not here once more
            rows.append(Refusal(attempt, pattern, failure))
            self._mark_relevant(pattern)
            suspected = None if failure.proof or attempt else self._suspects(call, failure, trace)
            if suspected is not None:
                self.suspicions.setdefault(call, {})[suspected] = None
                self._mark_relevant(suspected)

    def _suspects(self, call: GroundCall, failure: Failure, trace: Provenances) -> Pattern | None:
        """What was in the way, where it is; nothing, and so everywhere, if it was too far; None: only where it failed."""
        counts: Counter[int] = Counter()
        for pair, count in failure.between:
            owners = {self._index.get(name.partition(".")[0]) for name in pair} - {None, *self.moves(call)}
            counts.update(dict.fromkeys((i for i in owners if i is not None), count))
        total = sum(count for _, count in failure.between)
        blockers = [i for i, count in sorted(counts.items()) if count >= tuning.BLOCKING_SHARE * total]
        if blockers:
            return frozenset((i, trace[i]) for i in blockers)
        return frozenset() if failure.reason == "out_of_reach" else None

    def responsible_attempt(
        self, call: GroundCall, failure: Failure, trace: Provenances
    ) -> tuple[GroundCall, int] | None:
        """The attempt at a call that made what a failed call was to move; None if nothing else can be tried there.

        Where that call has no other answer, it is the one that made what it was given, and so on.
        """
        bound, objects = self.server.bind(call), self.server.scene.movable
        own = (name for name in (*bound.moves, *bound.reads) if name in failure.reads and name in objects)
        waiting = [(self._index[name], trace[self._index[name]]) for name in own]
        for entry in waiting:  # grows while it is read
            for origin in self._origins.get(entry, ()):
                if not self._no_attempt_left(origin.call, origin.attempt + 1):
                    return origin.call, origin.attempt
                before = [e for e in sorted(origin.reads) if self.components[e[0]] in objects and e not in waiting]
                waiting.extend(before)
        return None

    def _no_attempt_left(self, call: GroundCall, attempt: int) -> bool:
        """Whether there are no so many answers of a call: they are too many, or it had no more somewhere."""
        refusals = self.refusals.get(call, ())
        return attempt >= self._max_attempts or any(0 < row.attempt <= attempt for row in refusals)

    def fails_too_often(self) -> bool:
        """Whether so many calls along finished plans were refused that asking while searching is the better way."""
        counted = self.server.statistics
        calls = sum(counted.calls.values())
        failures = sum(sum(reasons.values()) for reasons in counted.failures.values())
        return failures >= tuning.MIN_FAILED_CALLS and failures >= tuning.FAILED_CALL_SHARE * calls

    def proved(self) -> bool:
        """Whether every refusal is a proof, and none of something that was sampled: no number of samples would help."""
        rows = [row for each in self.refusals.values() for row in each]
        return all(row.failure.proof and not any(number for _, number in row.pattern) for row in rows)

    def failures(self) -> list[tuple[GroundCall, Failure]]:
        """Every call that was refused with one reason each, proofs first, in order of first refusal."""
        firsts = [(call, rows[0].failure) for call, rows in self.refusals.items()]
        return sorted(firsts, key=lambda item: not item[1].proof)

    def try_harder(self) -> bool:
        """Forgets the refusals that more samples might lift and raises the effort; False at the highest."""
        if self.effort >= MAX_EFFORT:
            return False
        self.effort += 1
        self._options.clear()
        kept = {call: [r for r in rows if r.failure.proof] for call, rows in self.refusals.items()}
        self.refusals = {call: rows for call, rows in kept.items() if rows}
        self.suspicions, self._relevant = {}, {}
        self._numbers, self._value_reads, self._origins = {}, {}, {}
        for rows in self.refusals.values():
            for refusal in rows:
                self._mark_relevant(refusal.pattern)
        return True
