"""Looks in long runs at what a scene shows at its start, and tells why there is no plan yet, in case time is spent."""

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter

from kabo.geometry_server import Refusal, start_faults
from kabo.knowledge import GroundedTask
from kabo.language.formulas import GroundCall
from kabo.planner.proofs.needed_calls import needed_calls
from kabo.planner.proofs.reasons import exhausted
from kabo.planner.result import Result
from kabo.planner.run import SolveRun, statistics_of
from kabo.tasks.procedures import GeometricProcedures

TOLD_EVERY_S = 1.0
LOOKED_AFTER_S = 2.0  # of a run that is this long, the look at its start is a small part


@dataclass
class Telling:
    """Stands for a run's `cancelled`, which is asked often: hands on what was refused until then, once in a while.

    Before time is spent it has looked once at what is wrong with the scene at its start.
    """

    run: SolveRun
    task: GroundedTask
    server: GeometricProcedures
    completed: Callable[[Result], Result]  # with what was seen of the start
    process: int = field(default_factory=os.getpid)
    began: float = field(default_factory=perf_counter)
    told_at: float = field(default_factory=perf_counter)
    looked: bool = False

    def __call__(self) -> bool:
        """Whether somebody wants the run to end."""
        now, told = perf_counter(), self.run.on_refused
        if os.getpid() == self.process:  # not in workers
            if not self.looked and now >= self.began + LOOKED_AFTER_S:
                self.looked = True
                start_faults(self.server.server.surroundings, parts=False)
            if told is not None and now > self.told_at + TOLD_EVERY_S:
                self._tell(told)
                self.told_at = perf_counter()
        return self.run.cancelled is not None and self.run.cancelled()

    def _tell(self, told: Callable[[Result], None]) -> None:
        failures = refused_so_far(self.server)
        needed = needed_calls(self.task, failures) if len(failures) > 1 else frozenset()
        reason = exhausted("time", failures, needed=needed)
        result = Result("exhausted", None, statistics_of(self.run, self.server), reason)
        told(self.completed(result))


def refused_so_far(server: GeometricProcedures) -> list[tuple[GroundCall, Refusal]]:
    """The calls that never succeeded, and the one that is being planned, each with its refusal of most effort."""
    records = server.records.of
    told = {c: each.places[0].refusal for c, each in records.items() if each.places and not each.successes}
    cut = {**server.records.unfinished, **server.refused_so_far()}
    return list({**{c: where.refusal for c, where in cut.items() if c not in records}, **told}.items())
