"""Evaluates a skeleton in geometry: every procedure along it is asked, in order, and what is equal stays shared.

Branches meet in the nodes of the skeleton. Where they meet, components that nothing from there on moves may have
several values, and a procedure answers for all of them at once; components that are moved must have one value, so
the node is evaluated once for each [docs/plans.md#sharing].
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

from kabo.errors import CutOff
from kabo.geometry_server import Failure, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.procedure_server import ProcedureServer
from kabo.planner.geometry.workers import ProcedureCall
from kabo.planner.search.skeleton import SkeletonNode, Trace

Expect = Callable[[list[ProcedureCall]], None]
Advance = Callable[[GroundCall, int, Trace, Success], Trace]  # the trace after a call that has succeeded


@dataclass(eq=False)
class Variant:
    """A node of the skeleton in one situation, its answer there, and what follows each outcome."""

    node: SkeletonNode
    situation: Situation
    traces: frozenset[Trace]
    answer: Success | Failure | None = None  # None: nothing to ask
    following: dict[str | None, "Variant"] = field(default_factory=dict)
    overlap: float = 0.0  # [s] by which its motion begins before the one before it has ended


@dataclass(frozen=True)
class Refused:
    """A call of the skeleton that failed, and the traces in which it did."""

    call: GroundCall
    attempt: int
    failure: Failure
    traces: frozenset[Trace]


@dataclass(frozen=True)
class Evaluation:
    """All variants in an order in which each comes before what follows it; refused calls, if any.

    `whole`: every procedure was asked that can be; else time or budget was spent before, and only refusals are of use.
    """

    variants: tuple[Variant, ...]
    refused: tuple[Refused, ...]
    whole: bool = True


@dataclass(frozen=True)
class _Arrival:
    """One way into a node: from which variant by which outcome, and what holds then."""

    origin: Variant | None
    outcome: str | None
    situation: Situation
    traces: frozenset[Trace]


@dataclass
class Evaluator:
    """Walks a skeleton from its root; `share` lets branches meet although other components differ."""

    server: ProcedureServer
    advance: Advance
    effort: int
    stop: Callable[[], bool]
    share: bool = True
    expect: Expect | None = None  # told which questions come, as soon as they are known

    def evaluate(self, root: SkeletonNode, trace: Trace) -> Evaluation:
        """Asks every procedure of the skeleton; what follows a refusal is left out, the rest is asked."""
        variants: list[Variant] = []
        refused: list[Refused] = []
        whole = True
        try:
            self._walk(root, trace, variants, refused)
        except CutOff:
            whole = False
        return Evaluation(tuple(variants), tuple(refused), whole)

    def _walk(self, root: SkeletonNode, trace: Trace, variants: list[Variant], refused: list[Refused]) -> None:
        order = in_order(root)
        live = self._live(order)
        arrivals: dict[SkeletonNode, list[_Arrival]] = {node: [] for node in order}
        start = Situation.of(self.server.scene.start)
        arrivals[root].append(_Arrival(None, None, start, frozenset([trace])))
        ways_in = Counter(after for node in order for after in successors(node).values())
        for node in order:
            for group in self._meet(arrivals[node], live[node]):
                for variant, came in self._ask(node, group):
                    variants.append(variant)
                    for arrival in came:
                        if arrival.origin is not None:
                            arrival.origin.following[arrival.outcome] = variant
                    if isinstance(variant.answer, Failure):
                        refused.append(self._refusal(variant, variant.answer))
                    else:
                        self._depart(variant, arrivals)
                    if self.stop():
                        raise CutOff
            after = Counter(successors(node).values())
            ways_in -= after
            self._expect((each for each in after if not ways_in[each]), arrivals, live)

    def _expect(
        self,
        ready: Iterable[SkeletonNode],
        arrivals: Mapping[SkeletonNode, list[_Arrival]],
        live: Mapping[SkeletonNode, frozenset[str]],
    ) -> None:
        """Tells what is going to be asked at nodes into which every way is known."""
        if self.expect is None:
            return
        questions = [
            self._question(node.action.call, self._together(group)[0], node.attempt)
            for node in ready
            if node.action is not None and node.action.call is not None
            for group in self._meet(arrivals[node], live[node])
        ]
        self.expect(questions)

    def _live(self, order: list[SkeletonNode]) -> dict[SkeletonNode, frozenset[str]]:
        """For each node the components that it, or what follows it, needs to have one value."""
        live: dict[SkeletonNode, frozenset[str]] = {}
        for node in reversed(order):
            later = frozenset().union(*(live[after] for after in successors(node).values()))
            call = None if node.action is None else node.action.call
            if call is not None:
                bound = self.server.bind(call)
                later |= {*bound.moves, *bound.reads}
            live[node] = later
        return live

    def _meet(self, arrivals: list[_Arrival], live: frozenset[str]) -> Iterable[list[_Arrival]]:
        """The arrivals in groups that may share one variant, in order of first arrival."""
        groups: dict[object, list[_Arrival]] = {}
        for arrival in arrivals:
            situation = arrival.situation
            single = {*live, *self._held(situation, live)}
            key = tuple((name, situation.values(name)) for name in sorted(single)) if self.share else situation.key
            groups.setdefault(key, []).append(arrival)
        return groups.values()

    def _held(self, situation: Situation, live: frozenset[str]) -> set[str]:
        held = {name for robot in live if robot in situation.robots for name in situation.carried(robot)}
        return held | (situation.carriers({*live, *held}) if situation.nested else frozenset())

    def _ask(self, node: SkeletonNode, group: list[_Arrival]) -> list[tuple[Variant, list[_Arrival]]]:
        """One variant for the group, or one for each arrival where the group together is refused."""
        together = self._variant(node, group)
        if len(group) == 1 or not isinstance(together.answer, Failure):
            return [(together, group)]
        return [(self._variant(node, [arrival]), [arrival]) for arrival in group]

    def _variant(self, node: SkeletonNode, group: list[_Arrival]) -> Variant:
        situation, traces = self._together(group)
        call = None if node.action is None else node.action.call
        answer = None if call is None else answered(self.server, call, situation, node.attempt, self.effort)
        return Variant(node, situation, traces, answer)

    def _question(self, call: GroundCall, situation: Situation, attempt: int) -> ProcedureCall:
        """What will be asked first of all that is not remembered."""
        efforts = range(self.effort + 1)
        unknown = (effort for effort in efforts if not self.server.knows(call, situation, attempt, effort))
        return ProcedureCall(call, situation, attempt, next(unknown, self.effort))

    @staticmethod
    def _together(group: list[_Arrival]) -> tuple[Situation, frozenset[Trace]]:
        situation, traces = group[0].situation, group[0].traces
        for arrival in group[1:]:
            situation, traces = situation.union(arrival.situation), traces | arrival.traces
        return situation, traces

    def _refusal(self, variant: Variant, failure: Failure) -> Refused:
        action = variant.node.action
        if action is None or action.call is None:
            raise ValueError("only calls are refused")
        return Refused(action.call, variant.node.attempt, failure, variant.traces)

    def _depart(self, variant: Variant, arrivals: Mapping[SkeletonNode, list[_Arrival]]) -> None:
        situation, traces, node = variant.situation, variant.traces, variant.node
        if isinstance(variant.answer, Success) and node.action is not None and node.action.call is not None:
            call = node.action.call
            situation = situation.replace(variant.answer.changes)
            traces = frozenset(self.advance(call, node.attempt, trace, variant.answer) for trace in traces)
        for outcome, after in successors(node).items():
            arrivals[after].append(_Arrival(variant, outcome, situation, traces))


def successors(node: SkeletonNode) -> dict[str | None, SkeletonNode]:
    """What follows a node by outcome; None where there is no branch."""
    if node.outcomes:
        return dict(node.outcomes)
    return {} if node.next is None else {None: node.next}


def in_order(root: SkeletonNode) -> list[SkeletonNode]:
    """Every node that the root reaches, each before all that follow it (no recursion: plans may be long)."""
    done: dict[SkeletonNode, None] = {}
    stack: list[tuple[SkeletonNode, bool]] = [(root, False)]
    while stack:
        node, expanded = stack.pop()
        if expanded:
            done.setdefault(node)
        elif node not in done:
            stack.append((node, True))
            stack.extend((after, False) for after in successors(node).values() if after not in done)
    return list(reversed(done))


def answered(
    server: ProcedureServer, call: GroundCall, situation: Situation, attempt: int, effort: int
) -> Success | Failure:
    """The answer of a call at the least effort at which it succeeds, or at the whole effort."""
    answer, reads = server.call(call, situation, attempt, 0), frozenset[str]()
    for more in range(1, effort + 1):
        if isinstance(answer, Success) or answer.proof:
            break
        reads |= answer.reads
        answer = server.call(call, situation, attempt, more)
    return replace(answer, reads=answer.reads | reads) if reads and isinstance(answer, Success) else answer
