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
from typing import TYPE_CHECKING

from kabo.geometry_server import MAX_EFFORT, Failure, Success
from kabo.language.formulas import GroundCall
from kabo.options import Search
from kabo.planner.search.skeleton import Entry, LearntBook, Origin, Pattern
from kabo.scene import Component

if TYPE_CHECKING:
    from kabo.tasks.procedures import GeometricProcedures

Name = tuple[GroundCall, int, int, Pattern]  # of a lineage: an attempt at a call, what it made, and from what
Trace = tuple[int, ...]  # the lineage of every component, in the order of `Ledger.components`; 0: as at the start

IN_VAIN, OFTEN = 60, 0.4  # failures, and their share of all calls, from which on geometry is asked while searching
SHARE = 0.2  # of all that came too close, from which on a thing counts as in the way
EXACT = 2  # the effort from which on what a call makes is taken to depend on everything: any sample may be blocked
ATTEMPTS = 4  # other answers of one call that may be asked for, at effort 0; as many more at each further level


@dataclass(frozen=True)
class Refusal:
    """A call that fails from `attempt` on, wherever the pattern of lineages holds."""

    attempt: int
    pattern: Pattern
    failure: Failure


@dataclass
class Ledger:
    """What the contingent search sees of geometry: lineages, refusals, and attempts where one led nowhere."""

    server: "GeometricProcedures"
    effort: int = 0
    refusals: dict[GroundCall, list[Refusal]] = field(default_factory=dict)
    suspicions: dict[GroundCall, dict[Pattern, None]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        scene = self.server.scene
        self.components = (*scene.robots, *scene.movable)
        self._index = {name: i for i, name in enumerate(self.components)}
        self._lineages: dict[Name, int] = {}
        self._values: dict[tuple[int, Component], int] = {}  # the lineage of every value that was met [K Def. 5]
        self._valued = {0}
        self._rests: dict[Name, frozenset[str]] = {}  # on what it rested which value a name has
        self._reads: dict[GroundCall, frozenset[int]] = {}
        self._everything = frozenset(range(len(self.components)))
        self._count = 0
        for i, name in enumerate(self.components):
            self._values[i, scene.start[name]] = 0
        self._options: dict[tuple[GroundCall, Trace], list[tuple[int, Trace]]] = {}
        self._origins: dict[Entry, dict[Origin, None]] = {}
        self._tainted: dict[Entry, None] = {}
        self._moves: dict[GroundCall, tuple[int, ...]] = {}

    # ------------------------------------------------------------------------------ what the search may ask
    @property
    def start(self) -> Trace:
        """The trace of the first state."""
        return (0,) * len(self.components)

    def options(self, call: GroundCall, trace: Trace) -> Sequence[tuple[int, Trace]]:
        """The attempts at a call that are not refused, with the trace after each.

        A further attempt is offered only where every one before it led to something that was refused.
        """
        known = self._options.get((call, trace))
        if known is None:
            known = self._options[call, trace] = self._found(call, trace)
        return known

    def _found(self, call: GroundCall, trace: Trace) -> list[tuple[int, Trace]]:
        limit = min(
            (r.attempt for r in self.refusals.get(call, ()) if all(trace[i] == line for i, line in r.pattern)),
            default=ATTEMPTS * (1 + self.effort),
        )
        found = []
        for attempt in range(limit):
            after = self.after(call, attempt, trace)
            found.append((attempt, after))
            if not any((i, after[i]) in self._tainted for i in self.moves(call)):
                break
        return found

    def key(self, trace: Trace) -> Trace:
        """The trace without the lineages that no refusal names."""
        tainted = self._tainted
        return tuple(line if (i, line) in tainted else -1 for i, line in enumerate(trace))

    def test(self, call: GroundCall, trace: Trace) -> bool:
        """Geometric tests in formulas are taken to hold until they are asked."""
        return True

    def settle(self, trace: Trace) -> bool:
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

    def learnt(self) -> LearntBook:
        """Everything but the failures themselves."""
        refusals = {
            call: tuple(dict.fromkeys((r.attempt, r.pattern) for r in rows))
            for call, rows in self.refusals.items()
        }
        suspicions = {call: tuple(rows) for call, rows in self.suspicions.items()}
        origins = {entry: tuple(self._origins[entry]) for entry in self._tainted if self._origins.get(entry)}
        named = tuple(sorted(self._tainted))
        return LearntBook(named, origins, refusals, suspicions, self.moves, ATTEMPTS * (1 + self.effort))

    # ------------------------------------------------------------------------------------------ keeping books
    def moves(self, call: GroundCall) -> tuple[int, ...]:
        """The components that a call moves, as far as is known."""
        known = self._moves.get(call)
        if known is None:
            known = self._moves[call] = tuple(self._index[name] for name in self.server.bind(call).moves)
        return known

    def reads(self, call: GroundCall) -> frozenset[int]:
        """The components on which it depends what a call makes, as far as is known."""
        if self.effort >= EXACT:
            return self._everything
        known = self._reads.get(call)
        if known is None:
            known = self._reads[call] = frozenset(self._index[name] for name in self.server.bind(call).reads)
        return known

    def after(self, call: GroundCall, attempt: int, trace: Trace) -> Trace:
        """The trace after a call: what it moves has the lineage of the call and of what its samples depend on."""
        reads = frozenset((i, trace[i]) for i in self.reads(call))
        result = list(trace)
        for i in self.moves(call):
            name = call, attempt, i, reads
            if name not in self._lineages:
                self._lineages[name] = self._new()
            result[i] = self._lineages[name]
            self._note_origin((i, result[i]), Origin(call, attempt, reads))
        return tuple(result)

    def came(self, call: GroundCall, attempt: int, trace: Trace, answer: Success) -> Trace:
        """The trace after a call that has succeeded: equal values have one lineage, whatever made them.

        What is not declared to be moved (parts of a group hang on another one) is learnt.
        """
        if self.effort:
            self._rest_on(call, answer.reads)
        known = self.moves(call)
        more = tuple(i for i in (self._index[name] for name in answer.changes) if i not in known)
        if more:
            self._moves[call] = known + more
            self._options.clear()
        if not all(self._agrees(call, attempt, trace, name, answer) for name in answer.changes):
            return self.came(call, attempt, trace, answer)
        return self.after(call, attempt, trace)

    def _agrees(self, call: GroundCall, attempt: int, trace: Trace, component: str, answer: Success) -> bool:
        """Notes the value of a lineage; False if it had another one: then it depends on more than was known."""
        i, reads = self._index[component], frozenset((i, trace[i]) for i in self.reads(call))
        name, value = (call, attempt, i, reads), (i, answer.changes[component])
        named = self._lineages.get(name)
        if value not in self._values:
            self._values[value] = self._new() if named is None or named in self._valued else named
        line = self._values[value]
        another = named in self._valued and named != line
        if another and self._rest_on(call, answer.reads | self._rests.get(name, frozenset())):
            return False
        if named != line:
            self._options.clear()
            self._origins.get((i, named or 0), {}).pop(Origin(call, attempt, reads), None)
        self._valued.add(line)
        self._lineages[name], self._rests[name] = line, answer.reads
        return True

    def _rest_on(self, call: GroundCall, names: Iterable[str]) -> bool:
        """What a call makes depends on these as well; whether that is new. What it made until now is forgotten."""
        known = self.reads(call)
        more = frozenset(self._index[name] for name in names) - known
        if not more:
            return False
        self._reads[call] = known | more
        self._options.clear()
        self._lineages = {name: line for name, line in self._lineages.items() if name[0] != call}
        for origins in self._origins.values():
            for origin in [each for each in origins if each.call == call]:
                del origins[origin]
        return True

    def _new(self) -> int:
        self._count += 1
        return self._count

    def _note_origin(self, entry: Entry, origin: Origin) -> None:
        origins = self._origins.setdefault(entry, {})
        if origin not in origins:
            origins[origin] = None
            if entry in self._tainted:
                self._taint(origin.reads)

    def _taint(self, pattern: Pattern) -> None:
        """Marks lineages that tell nodes apart: those of a refusal, and those from which they come."""
        waiting = sorted(pattern)
        while waiting:
            entry = waiting.pop()
            if entry not in self._tainted:
                self._tainted[entry] = None
                for origin in self._origins.get(entry, ()):
                    waiting.extend(sorted(origin.reads))

    def refuse(self, call: GroundCall, attempt: int, failure: Failure, traces: Iterable[Trace]) -> None:
        """Notes that a call failed, wherever the components that the failure reads are as in one of the traces."""
        self._options.clear()
        for trace in traces:
            pattern = frozenset((self._index[name], trace[self._index[name]]) for name in failure.reads)
            rows = self.refusals.setdefault(call, [])
            if any(row.pattern == pattern and row.attempt <= attempt for row in rows):
                pattern = frozenset(enumerate(trace))  # known, and asked all the same: at least not here once more
            rows.append(Refusal(attempt, pattern, failure))
            self._taint(pattern)
            suspected = None if failure.proof or attempt else self._suspected(call, failure, trace)
            if suspected is not None:
                self.suspicions.setdefault(call, {})[suspected] = None
                self._taint(suspected)

    def _suspected(self, call: GroundCall, failure: Failure, trace: Trace) -> Pattern | None:
        """What was in the way, where it is; nothing, and so everywhere, if it was too far; None: only where it failed."""
        counts: Counter[int] = Counter()
        for pair, count in failure.between:
            owners = {self._index.get(name.partition(".")[0]) for name in pair} - {None, *self.moves(call)}
            counts.update(dict.fromkeys((i for i in owners if i is not None), count))
        total = sum(count for _, count in failure.between)
        blockers = [i for i, count in sorted(counts.items()) if count >= SHARE * total]
        if blockers:
            return frozenset((i, trace[i]) for i in blockers)
        return frozenset() if failure.reason == "out_of_reach" else None

    def blamed(self, call: GroundCall, failure: Failure, trace: Trace) -> tuple[GroundCall, int] | None:
        """The attempt at a call that made what a failed call was to move; None if nothing else can be tried there.

        Where that call has no other answer, it is the one that made what it was given, and so on.
        """
        bound, objects = self.server.bind(call), self.server.scene.movable
        own = (name for name in (*bound.moves, *bound.reads) if name in failure.reads and name in objects)
        waiting = [(self._index[name], trace[self._index[name]]) for name in own]
        for entry in waiting:  # grows while it is read
            for origin in self._origins.get(entry, ()):
                if not self._has_ended(origin.call, origin.attempt + 1):
                    return origin.call, origin.attempt
                before = [e for e in sorted(origin.reads) if self.components[e[0]] in objects and e not in waiting]
                waiting.extend(before)
        return None

    def _has_ended(self, call: GroundCall, attempt: int) -> bool:
        """Whether there are no so many answers of a call: they are too many, or it had no more somewhere."""
        refusals = self.refusals.get(call, ())
        return attempt >= ATTEMPTS * (1 + self.effort) or any(0 < row.attempt <= attempt for row in refusals)

    def in_vain(self) -> bool:
        """Whether so many calls along finished plans were refused that asking while searching is the better way."""
        counted = self.server.statistics
        calls = sum(counted.calls.values())
        failures = sum(sum(reasons.values()) for reasons in counted.failures.values())
        return failures >= IN_VAIN and failures >= OFTEN * calls

    def proved(self) -> bool:
        """Whether every refusal is a proof, and none of something that was sampled: no number of samples would help."""
        rows = [row for each in self.refusals.values() for row in each]
        return all(row.failure.proof and not any(line for _, line in row.pattern) for row in rows)

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
        self.suspicions, self._tainted = {}, {}
        self._lineages, self._rests, self._origins = {}, {}, {}
        for rows in self.refusals.values():
            for refusal in rows:
                self._taint(refusal.pattern)
        return True
