"""Eager geometry, as the thesis interleaves it [K Tables 6.2, 6.7]: calls are asked while searching.

A call is asked when the node that it leads to is about to be expanded, not when that node is generated: what waits in an
open list has cost nothing, and nobody asks for what is never expanded.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf

from kabo import tuning
from kabo.geometry_server import MAX_EFFORT, Failure, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.options import Search
from kabo.planner.geometry.evaluation import answered
from kabo.planner.geometry.procedure_server import ProcedureServer


class DeferredState:
    """What holds in geometry after an attempt at a call, which is asked when somebody needs to know."""

    __slots__ = ("attempt", "before", "call", "state")

    def __init__(
        self, before: int | None, call: GroundCall | None, attempt: int, state: int | None = None
    ) -> None:
        self.before, self.call, self.attempt = before, call, attempt
        self.state = state  # the identifier of the geometric state after it; None: refused, or not asked yet


@dataclass
class EagerGeometry:
    """What the contingent search sees of geometry when it asks on its way.

    A trace is a geometric state, known or awaited. At first a call has one answer in each state (a geometric branching
    factor of one); where that leads nowhere, more answers are asked for, with more samples [K 6.1.2].
    """

    server: ProcedureServer
    effort: int = 0
    failed: dict[GroundCall, Failure] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.start = DeferredState(None, None, 0, self.server.identify(self.server.scene.start))
        self._awaited: dict[tuple[int, GroundCall], tuple[tuple[int, DeferredState], ...]] = {}
        self._refused: dict[tuple[int, GroundCall], int] = {}  # from which attempt on

    def options(self, call: GroundCall, trace: DeferredState) -> Sequence[tuple[int, DeferredState]]:
        """The attempts at a call that may succeed, each with what is awaited of it."""
        if not self.confirm(trace) or trace.state is None:
            return ()
        asked = trace.state, call
        if asked not in self._awaited:
            attempts = range(1 + tuning.EAGER_ATTEMPTS_PER_EFFORT * self.effort)
            self._awaited[asked] = tuple((k, DeferredState(trace.state, call, k)) for k in attempts)
        limit = self._refused.get(asked)
        return self._awaited[asked] if limit is None else self._awaited[asked][:limit]

    def confirm(self, trace: DeferredState) -> bool:
        """Whether the call that a trace comes from has succeeded; asked now if it was not before."""
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
        """Every geometric state is a node of its own, and so is everything that is awaited."""
        return trace if trace.state is None else trace.state

    def test(self, call: GroundCall, trace: DeferredState) -> bool:
        """Geometric tests in formulas are taken to hold."""
        return True

    def refused_everywhere(self) -> "tuple[frozenset[GroundCall], bool]":
        """Nothing is said of calls without a situation."""
        return frozenset(), False

    def learnt(self) -> None:
        """Nothing that could be compiled."""

    def most_expansions(self, search: Search) -> float:
        """How far to look before more answers are asked for; as far as may be for the thesis' strategies [K 6.2]."""
        return (
            tuning.EAGER_EXPANSIONS * tuning.EAGER_EXPANSIONS_GROWTH**self.effort
            if search in ("best", "greedy", "astar")
            else inf
        )

    def try_harder(self) -> bool:
        """More answers of each call, from more samples; False at the highest effort."""
        self.effort += 1
        self._awaited, self._refused = {}, {}
        return self.effort <= MAX_EFFORT

    def failures(self) -> list[tuple[GroundCall, Failure]]:
        """Every call that failed somewhere, with its first failure."""
        return list(self.failed.items())

    def proved(self) -> bool:
        """Never: other answers of the calls that succeed are not looked at."""
        return False
