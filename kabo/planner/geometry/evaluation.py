"""Evaluates a skeleton in geometry: calls its procedures in order and keeps shared nodes shared if possible.

At a node where branches meet, a component may have several values. If no later step moves it, the procedures are
asked for an answer that is valid for all these values. A component that is moved must have one value, so the node
is evaluated separately for each value [docs/reference/plans.md#sharing].
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

from kabo.errors import CutOff
from kabo.geometry_server import Refusal, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.procedure_server import ProcedureServer
from kabo.planner.geometry.workers import SituatedCall
from kabo.planner.search.skeleton import SkeletonNode, Trace

Expect = Callable[[list[SituatedCall]], None]
Advance = Callable[[GroundCall, int, Trace, Success], Trace]  # the trace after a call that has succeeded


@dataclass(eq=False)
class Variant:
    """A skeleton node in one geometric situation, with the answer to its call and its successors by outcome."""

    node: SkeletonNode
    situation: Situation
    traces: frozenset[Trace]
    answer: Success | Refusal | None = None  # None: the node has no call
    following: dict[str | None, "Variant"] = field(default_factory=dict)
    overlap: float = 0.0  # [s] by which its motion begins before the one before it has ended


@dataclass(frozen=True)
class RefusedCall:
    """A call of the skeleton that failed, and the traces (provenances of all components) for which it failed."""

    call: GroundCall
    attempt: int
    refusal: Refusal
    traces: frozenset[Trace]


@dataclass(frozen=True)
class Evaluation:
    """All variants in topological order, and the calls that were refused.

    `whole`: whether every call that can be made was made; if not, time or budget was spent, and only the refusals
    are valid.
    """

    variants: tuple[Variant, ...]
    refused: tuple[RefusedCall, ...]
    whole: bool = True


@dataclass(frozen=True)
class _Arrival:
    """One way into a node: from which variant by which outcome, and the situation and traces on arrival."""

    origin: Variant | None
    outcome: str | None
    situation: Situation
    traces: frozenset[Trace]


@dataclass
class Evaluator:
    """Evaluates skeletons; with `share`, branches meet even if components that no later step needs differ."""

    server: ProcedureServer
    advance: Advance
    effort: int
    stop: Callable[[], bool]
    share: bool = True
    expect: Expect | None = None  # called with the calls that will be made, as soon as they are known

    def evaluate(self, root: SkeletonNode, trace: Trace) -> Evaluation:
        """Makes the calls of the skeleton in order, except those after a refused call, and returns the results."""
        variants: list[Variant] = []
        refused: list[RefusedCall] = []
        whole = True
        try:
            self._walk(root, trace, variants, refused)
        except CutOff:
            whole = False
        return Evaluation(tuple(variants), tuple(refused), whole)

    def _walk(self, root: SkeletonNode, trace: Trace, variants: list[Variant], refused: list[RefusedCall]) -> None:
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
                    if isinstance(variant.answer, Refusal):
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
        """Announces the calls of nodes whose arrivals are all known."""
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
        """For each node the components that must have one value there, because it or a later node moves or reads them."""
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
        """The arrivals, grouped by which may share one variant, in order of first arrival."""
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
        """One variant for the group; one for each arrival where the call is refused for the group as a whole."""
        together = self._variant(node, group)
        if len(group) == 1 or not isinstance(together.answer, Refusal):
            return [(together, group)]
        return [(self._variant(node, [arrival]), [arrival]) for arrival in group]

    def _variant(self, node: SkeletonNode, group: list[_Arrival]) -> Variant:
        situation, traces = self._together(group)
        call = None if node.action is None else node.action.call
        answer = None if call is None else answered(self.server, call, situation, node.attempt, self.effort)
        return Variant(node, situation, traces, answer)

    def _question(self, call: GroundCall, situation: Situation, attempt: int) -> SituatedCall:
        """The call at the least effort whose answer is not cached yet."""
        efforts = range(self.effort + 1)
        unknown = (effort for effort in efforts if not self.server.knows(call, situation, attempt, effort))
        return SituatedCall(call, situation, attempt, next(unknown, self.effort))

    @staticmethod
    def _together(group: list[_Arrival]) -> tuple[Situation, frozenset[Trace]]:
        situation, traces = group[0].situation, group[0].traces
        for arrival in group[1:]:
            situation, traces = situation.union(arrival.situation), traces | arrival.traces
        return situation, traces

    def _refusal(self, variant: Variant, refusal: Refusal) -> RefusedCall:
        action = variant.node.action
        if action is None or action.call is None:
            raise ValueError("only calls are refused")
        return RefusedCall(action.call, variant.node.attempt, refusal, variant.traces)

    def _depart(self, variant: Variant, arrivals: Mapping[SkeletonNode, list[_Arrival]]) -> None:
        situation, traces, node = variant.situation, variant.traces, variant.node
        if isinstance(variant.answer, Success) and node.action is not None and node.action.call is not None:
            call = node.action.call
            situation = situation.replace(variant.answer.changes)
            traces = frozenset(self.advance(call, node.attempt, trace, variant.answer) for trace in traces)
        for outcome, after in successors(node).items():
            arrivals[after].append(_Arrival(variant, outcome, situation, traces))


def successors(node: SkeletonNode) -> dict[str | None, SkeletonNode]:
    """The successors of a node by outcome; the only key is None if the node does not branch."""
    if node.outcomes:
        return dict(node.outcomes)
    return {} if node.next is None else {None: node.next}


def in_order(root: SkeletonNode) -> list[SkeletonNode]:
    """All nodes reachable from the root, in topological order (without recursion, since plans may be long)."""
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
) -> Success | Refusal:
    """The answer to a call at the lowest effort at which it succeeds; if none does, the refusal at `effort`."""
    answer, reads = server.call(call, situation, attempt, 0), frozenset[str]()
    for more in range(1, effort + 1):
        if isinstance(answer, Success) or answer.proof:
            break
        reads |= answer.reads
        answer = server.call(call, situation, attempt, more)
    return replace(answer, reads=answer.reads | reads) if reads and isinstance(answer, Success) else answer
