"""Rounds of planning with geometry: search proposes a skeleton, geometry is asked along it, what it refuses is learnt.

They end with a skeleton in which everything that was asked succeeded, with a proof, or with the budget.
"""

from collections.abc import Callable
from time import perf_counter
from typing import TYPE_CHECKING, Any, cast

from kabo.errors import CutOff
from kabo.knowledge import GroundedTask
from kabo.planner.geometry.eager import Interleaved
from kabo.planner.geometry.evaluation import Evaluation, Evaluator, Expect, Variant
from kabo.planner.geometry.refusals import Ledger
from kabo.planner.geometry.repairing import REPAIRS, repaired
from kabo.planner.run import Run, search_once
from kabo.planner.search.skeleton import Exhausted, Skeleton, Unreachable

if TYPE_CHECKING:
    from kabo.tasks.procedures import GeometricProcedures

VAIN = 100  # skeletons that are refused before more samples are drawn; four times as many each time after

Variants = tuple[Variant, ...]


class Rounds:
    """The rounds of one run; `geometry` is what the search sees of it at the time.

    Args:
        run: the options, and when to stop. task: what is known, and how it changes. server: the procedures.
        expect: told which questions come.
    """

    def __init__(self, run: Run, task: GroundedTask, server: "GeometricProcedures", expect: Expect) -> None:
        self.run, self.task, self.server, self.expect = run, task, server, expect
        self.ledger = Ledger(server)
        eager = run.options.geometry_order == "eager"
        self.geometry: Ledger | Interleaved = Interleaved(server) if eager else self.ledger
        self._vain = 0

    def played(self) -> Variants | Unreachable | Exhausted:
        """The variants of a skeleton without a refusal; the proof that there is none; or the budget that was spent."""
        try:
            return self._played()
        except CutOff:
            return Exhausted(self.run.searched, self.run.stop.spent or "time")

    def _played(self) -> Variants | Unreachable | Exhausted:
        if self.geometry is self.ledger:
            self._note_proofs()
        while True:
            self._change_order()
            self._tell("searching")
            found = search_once(self.run, self.task, self.geometry)
            if isinstance(found, Unreachable | Exhausted):
                proof = self._proof() if isinstance(found, Unreachable) else None
                if proof is not None or not self._goes_on_after(found):
                    return proof or found
                continue
            self._tell("moving")
            variants = self._with_repairs(found.skeleton)
            if variants is not None:
                return variants
            self._vain += 1
            if self.geometry is not self.ledger and not self.geometry.try_harder():
                return Exhausted(found.statistics, "expansions")
            if self.geometry is self.ledger and self._vain >= VAIN * 4**self.ledger.effort:
                self._vain = 0
                self.ledger.try_harder()  # without end, skeletons may go round in circles that never are the same

    def _change_order(self) -> None:
        """Asks while searching from now on, where asking along finished plans is in vain and branches multiply that."""
        adaptive = self.run.options.geometry_order == "adaptive"
        if self.geometry is self.ledger and adaptive and self.task.branchings and self.ledger.in_vain():
            self.geometry = Interleaved(self.server)

    def _goes_on_after(self, found: Unreachable | Exhausted) -> bool:
        """Whether there is more to try after a search without a skeleton: other answers, from more samples."""
        if isinstance(found, Exhausted):
            left = self.run.searched.expanded < self.run.options.max_expansions
            return found.budget == "expansions" and left and self.geometry.try_harder()
        return not self.geometry.proved() and self.geometry.try_harder()

    def _tell(self, doing: str) -> None:
        self.run.tell(doing, sum(self.server.statistics.calls.values()))

    # ------------------------------------------------------------------------------------------------- proofs
    def _note_proofs(self) -> None:
        """What can be refuted without sampling is, before the search builds on it."""
        for call in dict.fromkeys(action.call for action in self.task.actions if action.call is not None):
            failure = self.server.refuted(call)
            if failure is not None:
                self.ledger.refuse(call, 0, failure, [self.ledger.start])

    def _proof(self) -> Unreachable | None:
        """The proof that there is no plan whatever is sampled, where geometry was asked while searching."""
        if self.geometry is self.ledger:
            return None
        if not self.ledger.refusals:
            self._note_proofs()
        found = search_once(self.run, self.task, self.ledger) if self.ledger.proved() else None
        if not isinstance(found, Unreachable):
            return None
        self.geometry = self.ledger
        return found

    # ------------------------------------------------------------------------------------------------- asking
    def _with_repairs(self, skeleton: Skeleton) -> Variants | None:
        """The variants of the skeleton; where plans branch, other answers are tried before another skeleton is."""
        for _ in range(1 + REPAIRS):
            evaluation = self._evaluated(skeleton)
            if not evaluation.refused:
                break
            mendable = bool(self.task.branchings) and self.geometry is self.ledger
            found = repaired(skeleton, evaluation.refused, self.ledger) if mendable else None
            if found is None:
                break
            skeleton = found
        return None if evaluation.refused else evaluation.variants

    def _evaluated(self, skeleton: Skeleton) -> Evaluation:
        """The evaluation of the skeleton, its refusals noted.

        Raises:
            CutOff: time or budget was spent before all was asked.
        """
        began, geometry = perf_counter(), self.geometry
        lazy = isinstance(geometry, Ledger)
        advance: Callable[..., Any] = geometry.came if isinstance(geometry, Ledger) else _as_it_is
        evaluator = Evaluator(self.server, advance, geometry.effort, self.server.stop, lazy, self.expect)
        evaluation = evaluator.evaluate(skeleton.root, cast("Any", geometry.start))
        if isinstance(geometry, Ledger):
            for refused in evaluation.refused:
                geometry.refuse(refused.call, refused.attempt, refused.failure, refused.traces)
        self.run.geometric_s += perf_counter() - began
        if not evaluation.whole:
            raise CutOff
        return evaluation


def _as_it_is(_call: object, _attempt: int, trace: object, _answer: object) -> object:
    return trace
