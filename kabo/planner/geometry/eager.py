"""Eager geometry, interleaved with search as in the thesis [K Tables 6.2, 6.7]: calls are made during the search.

A call is made when the node that it leads to is about to be expanded, not when this node is generated. Nodes in
the open list that are never expanded therefore need no geometric computation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf

from kabo import tuning
from kabo.geometry_server import MAX_EFFORT, Refusal, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.options import Search
from kabo.planner.geometry.evaluation import answered
from kabo.planner.geometry.procedure_server import ProcedureServer


class DeferredState:
    """The geometric state after an attempt at a call; the call is made only when the state is first needed."""

    __slots__ = ("attempt", "before", "call", "state")

    def __init__(
        self, before: int | None, call: GroundCall | None, attempt: int, state: int | None = None
    ) -> None:
        self.before, self.call, self.attempt = before, call, attempt
        self.state = state  # the identifier of the geometric state after it; None: refused, or not computed yet


@dataclass
class EagerGeometry:
    """Geometry for a contingent search that makes procedure calls during the search.

    Here a trace (the geometric part of a search node) is a geometric state, computed or deferred. At first, one
    answer to each call is used in each state (a geometric branching factor of one). If no plan is found, more
    answers are computed, from more samples [K 6.1.2].
    """

    server: ProcedureServer
    effort: int = 0
    failed: dict[GroundCall, Refusal] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.start = DeferredState(None, None, 0, self.server.identify(self.server.scene.start))
        self._awaited: dict[tuple[int, GroundCall], tuple[tuple[int, DeferredState], ...]] = {}
        self._refused: dict[tuple[int, GroundCall], int] = {}  # from which attempt on

    def options(self, call: GroundCall, trace: DeferredState) -> Sequence[tuple[int, DeferredState]]:
        """The attempts at a call that may succeed, each with the deferred state after it."""
        if not self.confirm(trace) or trace.state is None:
            return ()
        asked = trace.state, call
        if asked not in self._awaited:
            attempts = range(1 + tuning.EAGER_ATTEMPTS_PER_EFFORT * self.effort)
            self._awaited[asked] = tuple((k, DeferredState(trace.state, call, k)) for k in attempts)
        limit = self._refused.get(asked)
        return self._awaited[asked] if limit is None else self._awaited[asked][:limit]

    def confirm(self, trace: DeferredState) -> bool:
        """Whether the call that leads to a trace succeeds; the call is made now if it is still pending."""
        if trace.state is None and trace.call is not None and trace.before is not None:
            asked = trace.before, trace.call
            if trace.attempt >= self._refused.get(asked, inf):
                return False
            before = self.server.state(trace.before)
            answer = answered(self.server, trace.call, Situation.of(before), trace.attempt, self.effort)
            if isinstance(answer, Success):
                trace.state = self.server.identify(before.replace(answer.changes))
            else:
                self.failed.setdefault(trace.call, answer)
                self._refused[asked] = trace.attempt
        return trace.state is not None

    def key(self, trace: DeferredState) -> object:
        """The identifier of the geometric state; for a deferred state, the deferred state itself."""
        return trace if trace.state is None else trace.state

    def test(self, call: GroundCall, trace: DeferredState) -> bool:
        """True: geometric tests inside formulas are not evaluated here."""
        return True

    def refused_everywhere(self) -> "tuple[frozenset[GroundCall], bool]":
        """An empty set, and False: eager geometry records refusals in single states only."""
        return frozenset(), False

    def learnt(self) -> None:
        """None, because refusals in single states cannot be compiled into a finite-domain task."""

    def most_expansions(self, search: Search) -> float:
        """The number of expansions before more answers are offered; infinite for some algorithms [K 6.2]."""
        return (
            tuning.EAGER_EXPANSIONS * tuning.EAGER_EXPANSIONS_GROWTH**self.effort
            if search in ("best", "greedy", "astar")
            else inf
        )

    def try_harder(self) -> bool:
        """Raises the effort: each call gets more answers, from more samples; False if already at the highest."""
        self.effort += 1
        self._awaited, self._refused = {}, {}
        return self.effort <= MAX_EFFORT

    def failures(self) -> list[tuple[GroundCall, Refusal]]:
        """All calls that failed in some state, each with its first refusal."""
        return list(self.failed.items())

    def proved(self) -> bool:
        """False: refusals prove nothing here, since other answers of successful calls were not tried."""
        return False
