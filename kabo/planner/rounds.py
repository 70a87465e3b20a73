"""Rounds of planning: search proposes a skeleton, its procedure calls are made, and refusals are recorded.

There are three kinds of rounds: without procedures (`SymbolicRounds`), with functions that the caller supplies
(`ExternalRounds`), and with the geometry of a scene (`GeometricRounds`).
"""

import logging
from collections.abc import Callable
from time import perf_counter
from typing import Any, Protocol

from kabo import tuning
from kabo.errors import CutOff
from kabo.knowledge import GroundedTask
from kabo.phases import timed
from kabo.planner.geometry.assembly import symbolic_variants
from kabo.planner.geometry.eager import EagerGeometry
from kabo.planner.geometry.evaluation import Evaluation, Evaluator, Expect, Variant, in_order
from kabo.planner.geometry.external_procedures import ExternalProcedures
from kabo.planner.geometry.procedure_server import ProcedureServer
from kabo.planner.geometry.refusals import RefusalTable
from kabo.planner.geometry.repairing import repaired
from kabo.planner.run import SolveRun, search_once
from kabo.planner.search.skeleton import Exhausted, FoundSkeleton, Geometry, SearchResult, Skeleton, Unreachable

_LOG = logging.getLogger("kabo.planner")
Variants = tuple[Variant, ...]


class Rounds(Protocol):
    """The interface of planning rounds: the geometry for each search, and the evaluation of its skeleton."""

    @property
    def geometry(self) -> Geometry | None:
        """The geometry that the next search uses; None if all procedure calls are assumed to succeed."""
        ...

    def prepare(self) -> None:
        """Prepares the next search; it is called before each search."""
        ...

    def evaluated(self, skeleton: Skeleton) -> Variants | None:
        """The variants of a skeleton with answers to all its calls; None if a call was refused (and recorded)."""
        ...

    def ending(self, found: SearchResult) -> Unreachable | Exhausted | None:
        """The final result after a search, or after a refused skeleton; None if there is more to try."""
        ...


class SymbolicRounds:
    """Rounds for problems without procedures: the first skeleton found is the plan."""

    geometry = None

    def __init__(self, run: SolveRun) -> None:
        self._run = run

    def prepare(self) -> None:
        """Reports progress before the search."""
        self._run.report_progress("searching")

    def evaluated(self, skeleton: Skeleton) -> Variants:
        """The nodes of the skeleton as variants without geometry."""
        return symbolic_variants(skeleton.root, in_order(skeleton.root))

    def ending(self, found: SearchResult) -> Unreachable | Exhausted | None:
        """The final result if the only search found no skeleton."""
        return None if isinstance(found, FoundSkeleton) else found


class ExternalRounds:
    """Rounds that call functions supplied by the caller, until all calls along a skeleton succeed."""

    def __init__(self, run: SolveRun, task: GroundedTask, procedures: ExternalProcedures) -> None:
        self._run, self._task, self.geometry = run, task, procedures
        self._seconds = 0.0  # spent in procedures before the present search

    def prepare(self) -> None:
        """Makes all calls of the procedures that are to be evaluated in advance."""
        self._run.counts = lambda: (sum(counted.calls for counted in self.geometry.counted.values()), 0)
        self._run.report_progress("asking")
        self.geometry.prepare(self._task)
        self._seconds = self.geometry.seconds

    def evaluated(self, skeleton: Skeleton) -> Variants | None:
        """The skeleton as variants without geometry; None if a call along it was refused."""
        self._leave_out_procedures()
        return (
            symbolic_variants(skeleton.root, in_order(skeleton.root)) if self.geometry.follow(skeleton) else None
        )

    def ending(self, found: SearchResult) -> Unreachable | Exhausted | None:
        """The final result if a search found no skeleton, or if the run has to stop."""
        if isinstance(found, FoundSkeleton):
            return Exhausted(self._run.searched, self._run.stop.spent or "time") if self._run.stop() else None
        self._leave_out_procedures()
        return found

    def _leave_out_procedures(self) -> None:
        """Subtracts the time in procedures from that of the search which asked them."""
        self._run.symbolic_s -= self.geometry.seconds - self._seconds
        self._seconds = self.geometry.seconds


class GeometricRounds:
    """Rounds with the geometry of a scene: calls are made lazily along skeletons, or eagerly while searching.

    Args:
        run: the run with its options and its stop flag.
        task: the grounded problem.
        server: answers the calls.
        expect: called with the calls that will be made next.
    """

    def __init__(self, run: SolveRun, task: GroundedTask, server: ProcedureServer, expect: Expect) -> None:
        self._run, self._task, self._server, self._on_expected = run, task, server, expect
        self.refusals = RefusalTable(server)
        eager = run.options.geometry_order == "eager"
        self.geometry: RefusalTable | EagerGeometry = EagerGeometry(server) if eager else self.refusals
        self._failed_skeletons = 0
        self._begun = False
        self._branches = False  # whether the last skeleton did

    @property
    def _is_lazy(self) -> bool:
        return self.geometry is self.refusals

    def prepare(self) -> None:
        """Prepares the next search: records refusals known without samples, and may switch to eager geometry.

        Those refusals are recorded once. Adaptive order switches to eager geometry when calls along skeletons fail
        too often.
        """
        if not self._begun and self._is_lazy:
            self._record_proofs()
        self._begun = True
        adaptive = self._run.options.geometry_order == "adaptive"
        if self._is_lazy and adaptive and self._branches and self.refusals.fails_too_often():
            self.geometry = EagerGeometry(self._server)  # branches multiply what finished plans ask for nothing
        self._run.report_progress("searching")

    def evaluated(self, skeleton: Skeleton) -> Variants | None:
        """The variants of the skeleton with an answer to every call; None if a call was refused.

        If the plan branches, repaired versions of the skeleton are tried as well.
        """
        self._run.report_progress("looking for motions")
        nodes = list(skeleton.nodes())
        self._branches = any(node.on is not None for node in nodes)
        _LOG.info("skeleton of %d nodes", len(nodes), extra={"fields": {"skeleton": len(nodes)}})
        for _ in range(1 + tuning.MAX_REPAIRS):
            with timed("asking for motions", _LOG):
                evaluation = self._evaluated(skeleton)
            for call in evaluation.refused:
                _LOG.debug("refused: %s", call.call, extra={"fields": {"refused": str(call.call)}})
            if not evaluation.refused:
                return evaluation.variants
            may_repair = self._branches and self._is_lazy
            other = repaired(skeleton, evaluation.refused, self.refusals) if may_repair else None
            if other is None:
                break
            skeleton = other
        return None

    def ending(self, found: SearchResult) -> Unreachable | Exhausted | None:
        """The final result (a proof or a spent budget); None if other answers or more samples can be tried."""
        if isinstance(found, FoundSkeleton):
            return self._after_refusal(found)
        proof = self._proof() if isinstance(found, Unreachable) else None
        if proof is not None:
            return proof
        return None if self._goes_on_after(found) else found

    def _after_refusal(self, found: FoundSkeleton) -> Exhausted | None:
        self._failed_skeletons += 1
        if not self._is_lazy:
            return None if self.geometry.try_harder() else Exhausted(found.statistics, "expansions")
        if (
            self._failed_skeletons
            >= tuning.MAX_FAILED_SKELETONS * tuning.FAILED_SKELETONS_GROWTH**self.refusals.effort
        ):
            self._failed_skeletons = 0
            self.refusals.try_harder()  # else skeletons could go round in circles without ever being the same
        return None

    def _goes_on_after(self, found: Unreachable | Exhausted) -> bool:
        """Whether there is more to try after a search without a skeleton: other answers, from more samples."""
        if isinstance(found, Exhausted):
            left = self._run.searched.expanded < self._run.options.max_expansions
            return found.budget == "expansions" and left and self.geometry.try_harder()
        return not self.geometry.proved() and self.geometry.try_harder()

    # ------------------------------------------------------------------------------------------------- proofs
    def _record_proofs(self) -> None:
        """Records every call that is refuted without sampling, before the search builds on it."""
        for call in dict.fromkeys(action.call for action in self._task.actions if action.call is not None):
            failure = self._server.refuted(call)
            if failure is not None:
                self.refusals.record_refusal(call, 0, failure, [self.refusals.start])

    def _proof(self) -> Unreachable | None:
        """The proof that there is no plan whatever is sampled, where geometry was asked while searching."""
        if self._is_lazy:
            return None
        if not self.refusals.refusals:
            self._record_proofs()
        found = search_once(self._run, self._task, self.refusals) if self.refusals.proved() else None
        if not isinstance(found, Unreachable):
            return None
        self.geometry = self.refusals
        return found

    # ------------------------------------------------------------------------------------------------- asking
    def _evaluated(self, skeleton: Skeleton) -> Evaluation:
        """The evaluation of the skeleton; its refusals are recorded.

        Raises:
            CutOff: time or budget was spent before all was asked.
        """
        began, geometry = perf_counter(), self.geometry
        lazy = isinstance(geometry, RefusalTable)
        advance: Callable[..., Any] = geometry.record_success if isinstance(geometry, RefusalTable) else _unchanged
        evaluator = Evaluator(self._server, advance, geometry.effort, self._server.stop, lazy, self._on_expected)
        evaluation = evaluator.evaluate(skeleton.root, geometry.start)
        if isinstance(geometry, RefusalTable):
            for refused in evaluation.refused:
                geometry.record_refusal(refused.call, refused.attempt, refused.refusal, refused.traces)
        self._run.geometric_s += perf_counter() - began
        if not evaluation.whole:
            raise CutOff
        return evaluation


def _unchanged(_call: object, _attempt: int, trace: object, _answer: object) -> object:
    return trace
