"""Tells from time to time why there is no plan yet, for those who may have to end the process by force."""

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter

from kabo.geometry_server import Refusal
from kabo.knowledge import GroundedTask
from kabo.language.formulas import GroundCall
from kabo.planner.proofs.needed_calls import needed_calls
from kabo.planner.proofs.reasons import exhausted
from kabo.planner.result import Result
from kabo.planner.run import SolveRun, statistics_of
from kabo.tasks.procedures import GeometricProcedures

TOLD_EVERY_S = 1.0


@dataclass
class Telling:
    """Stands for a run's `cancelled`, which is asked often: hands on what was refused until then, once in a while."""

    run: SolveRun
    task: GroundedTask
    server: GeometricProcedures
    told: Callable[[Result], None]
    cancelled: Callable[[], bool] | None
    process: int = field(default_factory=os.getpid)
    told_at: float = field(default_factory=perf_counter)

    def __call__(self) -> bool:
        """Whether somebody wants the run to end."""
        if perf_counter() > self.told_at + TOLD_EVERY_S and os.getpid() == self.process:  # not in workers
            failures = refused_so_far(self.server)
            needed = needed_calls(self.task, failures) if len(failures) > 1 else frozenset()
            reason = exhausted("time", failures, needed=needed)
            self.told(Result("exhausted", None, statistics_of(self.run, self.server), reason))
            self.told_at = perf_counter()
        return self.cancelled is not None and self.cancelled()


def refused_so_far(server: GeometricProcedures) -> list[tuple[GroundCall, Refusal]]:
    """The calls that never succeeded, and the one that is being planned, each with its refusal of most effort."""
    records = server.records.of
    told = {c: each.places[0].refusal for c, each in records.items() if each.places and not each.successes}
    cut = {**server.records.unfinished, **server.refused_so_far()}
    return list({**{c: where.refusal for c, where in cut.items() if c not in records}, **told}.items())
