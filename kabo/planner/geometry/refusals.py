"""The refusal table of lazy geometry: refused calls, and the situations in which each refusal holds [nogoods].

The search assumes that calls succeed. It tracks each geometric component by its provenance: the call that made its
present value, and the provenances of the values which that call depended on. A refusal consists of a call and the
provenances of the components that the call depends on; it holds wherever these provenances are the same, whatever
else has changed. Only provenances that some refusal names distinguish search nodes, so that as long as nothing is
refused, the search runs on the knowledge level alone.

A suspicion is weaker than a refusal but applies to more situations: it names only the provenances of the objects
that blocked a call. It refuses nothing, but makes the call more expensive wherever the same objects are in the
same places, so that the search prefers to move the obstacle before it tries another grasp.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from math import inf

from kabo import tuning
from kabo.geometry_server import MAX_EFFORT, Refusal, Success, owners
from kabo.language.formulas import GroundCall
from kabo.options import Search
from kabo.planner.geometry.procedure_server import ProcedureServer
from kabo.planner.search.skeleton import LearntRefusals, Origin, Pattern, Provenance
from kabo.scene import Component

# How a value is made: a call, an attempt at it, the component that it moves, and the provenances that it reads.
Derivation = tuple[GroundCall, int, int, Pattern]
# The provenance of every component, in the order of `RefusalTable.components`; 0: as at the start.
Provenances = tuple[int, ...]


@dataclass(frozen=True)
class LearntRefusal:
    """A call whose attempts from number `attempt` on fail wherever the components have these provenances."""

    attempt: int
    pattern: Pattern
    refusal: Refusal


@dataclass
class RefusalTable:
    """The refused procedure calls of lazy geometry, which evaluates calls only along finished skeletons."""

    server: ProcedureServer
    effort: int = 0
    refusals: dict[GroundCall, list[LearntRefusal]] = field(default_factory=dict)
    suspicions: dict[GroundCall, dict[Pattern, None]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        scene = self.server.scene
        self.components = (*scene.robots, *scene.movable)
        self._index = {name: i for i, name in enumerate(self.components)}
        self._numbers: dict[Derivation, int] = {}
        self._number_of_value: dict[tuple[int, Component], int] = {}  # of every value that was met [K Def. 5]
        self._with_value = {0}
        # The components that decided the value of a derivation.
        self._value_reads: dict[Derivation, frozenset[str]] = {}
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
        """The trace (the provenances of all components) of the initial state."""
        return (0,) * len(self.components)

    def options(self, call: GroundCall, trace: Provenances) -> Sequence[tuple[int, Provenances]]:
        """The attempts at a call that are not refused, with the trace after each.

        A further attempt is offered only if every earlier attempt makes a value that some refusal names.
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
        """The trace with -1 for every provenance that no refusal names."""
        tainted = self._relevant
        return tuple(number if (i, number) in tainted else -1 for i, number in enumerate(trace))

    def test(self, call: GroundCall, trace: Provenances) -> bool:
        """True: geometric tests inside formulas are not evaluated here."""
        return True

    def confirm(self, trace: Provenances) -> bool:
        """True: no calls are made while searching."""
        return True

    def refused_everywhere(self) -> "tuple[frozenset[GroundCall], bool]":
        """The calls that are refused in every situation, and whether the table contains no other refusals."""
        rows = [(call, not r.attempt and not r.pattern) for call, found in self.refusals.items() for r in found]
        return frozenset(call for call, everywhere in rows if everywhere), all(
            everywhere for _, everywhere in rows
        )

    def most_expansions(self, search: Search) -> float:
        """Infinity: only the budget of the run limits the search."""
        return inf

    def learnt(self) -> LearntRefusals:
        """The refusals, the suspicions and the provenances that they name, in the form used by the search."""
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
        """The indices of the components that a call moves, as far as is known."""
        known = self._moves.get(call)
        if known is None:
            known = self._moves[call] = tuple(self._index[name] for name in self.server.bind(call).moves)
        return known

    def reads(self, call: GroundCall) -> frozenset[int]:
        """The indices of the components that the result of a call depends on, as far as is known."""
        if self.effort >= tuning.FULL_DEPENDENCE_EFFORT:
            return self._everything
        known = self._reads.get(call)
        if known is None:
            known = self._reads[call] = frozenset(self._index[name] for name in self.server.bind(call).reads)
        return known

    def after(self, call: GroundCall, attempt: int, trace: Provenances) -> Provenances:
        """The trace after a call that is assumed to succeed; components that it moves get a new provenance.

        The new provenance is determined by the call, the attempt, and the provenances of the components that the
        call depends on.
        """
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
        """The trace after a successful call; equal values of a component have the same provenance.

        Components that the call moved without declaring it (parts of a group) are added to the components that it
        moves.
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
        """Records the value of a component; False if the same derivation had made another one: it then reads more."""
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
        """Records that a call also depends on these components, and forgets its derivations; whether that is new."""
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
        """Marks provenances that distinguish nodes: those of a refusal, and those from which they derive."""
        waiting = sorted(pattern)
        while waiting:
            entry = waiting.pop()
            if entry not in self._relevant:
                self._relevant[entry] = None
                for origin in self._origins.get(entry, ()):
                    waiting.extend(sorted(origin.reads))

    def record_refusal(
        self, call: GroundCall, attempt: int, refusal: Refusal, traces: Iterable[Provenances]
    ) -> None:
        """Records that a call fails wherever its components have their provenances in one of `traces`."""
        self._options.clear()
        for trace in traces:
            pattern = frozenset((self._index[name], trace[self._index[name]]) for name in refusal.reads)
            rows = self.refusals.setdefault(call, [])
            if any(row.pattern == pattern and row.attempt <= attempt for row in rows):
                # Recorded before, and called all the same: refuse it at least in exactly this trace.
                pattern = frozenset(enumerate(trace))
            rows.append(LearntRefusal(attempt, pattern, refusal))
            self._mark_relevant(pattern)
            suspected = None if refusal.proof or attempt else self._suspects(call, refusal, trace)
            if suspected is not None:
                self.suspicions.setdefault(call, {})[suspected] = None
                self._mark_relevant(suspected)

    def _suspects(self, call: GroundCall, refusal: Refusal, trace: Provenances) -> Pattern | None:
        """The provenances of what was in the way; empty (so everywhere) if it was out of reach; None: no suspicion."""
        counts: Counter[int] = Counter()
        for pair, count in refusal.pairs:
            met = {self._index.get(name) for name in owners(pair)} - {None, *self.moves(call)}
            counts.update(dict.fromkeys((i for i in met if i is not None), count))
        total = sum(count for _, count in refusal.pairs)
        blockers = [i for i, count in sorted(counts.items()) if count >= tuning.BLOCKING_SHARE * total]
        if blockers:
            return frozenset((i, trace[i]) for i in blockers)
        return frozenset() if refusal.reason == "out_of_reach" else None

    def responsible_attempt(
        self, call: GroundCall, refusal: Refusal, trace: Provenances
    ) -> tuple[GroundCall, int] | None:
        """The earlier call, with its attempt, to be replaced because it placed an object that made `call` fail.

        If the call that placed the object has no attempt left, the calls that placed the objects it depended on
        are considered, and so on. The result is None if no such call has an attempt left.
        """
        bound, objects = self.server.bind(call), self.server.scene.movable
        own = (name for name in (*bound.moves, *bound.reads) if name in refusal.reads and name in objects)
        waiting = [(self._index[name], trace[self._index[name]]) for name in own]
        for entry in waiting:  # grows while it is read
            for origin in self._origins.get(entry, ()):
                if not self._no_attempt_left(origin.call, origin.attempt + 1):
                    return origin.call, origin.attempt
                before = [e for e in sorted(origin.reads) if self.components[e[0]] in objects and e not in waiting]
                waiting.extend(before)
        return None

    def _no_attempt_left(self, call: GroundCall, attempt: int) -> bool:
        """Whether an attempt at a call is not available: above the limit, or a refusal says that there are fewer."""
        refusals = self.refusals.get(call, ())
        return attempt >= self._max_attempts or any(0 < row.attempt <= attempt for row in refusals)

    def fails_too_often(self) -> bool:
        """Whether calls along finished skeletons fail so often that eager geometry is expected to be faster."""
        counted = self.server.statistics
        calls = sum(counted.calls.values())
        failures = sum(sum(reasons.values()) for reasons in counted.failures.values())
        return failures >= tuning.MIN_FAILED_CALLS and failures >= tuning.FAILED_CALL_SHARE * calls

    def proved(self) -> bool:
        """Whether all refusals are proofs that depend on no sampled value, so that more samples would not help."""
        rows = [row for each in self.refusals.values() for row in each]
        return all(row.refusal.proof and not any(number for _, number in row.pattern) for row in rows)

    def failures(self) -> list[tuple[GroundCall, Refusal]]:
        """All refused calls, each with its first refusal; proofs come first, each group in order of refusal."""
        firsts = [(call, rows[0].refusal) for call, rows in self.refusals.items()]
        return sorted(firsts, key=lambda item: not item[1].proof)

    def try_harder(self) -> bool:
        """Raises the effort and forgets refusals that are not proofs; False if already at the highest effort."""
        if self.effort >= MAX_EFFORT:
            return False
        self.effort += 1
        self._options.clear()
        kept = {call: [r for r in rows if r.refusal.proof] for call, rows in self.refusals.items()}
        self.refusals = {call: rows for call, rows in kept.items() if rows}
        self.suspicions, self._relevant = {}, {}
        self._numbers, self._value_reads, self._origins = {}, {}, {}
        for rows in self.refusals.values():
            for refusal in rows:
                self._mark_relevant(refusal.pattern)
        return True
