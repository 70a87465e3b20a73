"""One run of the planner: its options, what it has done so far, and how it says that there is no plan."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING, Any, cast

from kabo.budgets import StopFlag
from kabo.knowledge import Task, verdict_of
from kabo.language.problem import Problem
from kabo.options import Options
from kabo.planner.geometry.external_procedures import Procedures
from kabo.planner.proofs.reasons import beyond_reasoning, exhausted, no_plan
from kabo.planner.result import Progress, Result
from kabo.planner.search.contingent import find_skeleton
from kabo.planner.search.packed import PackedTask
from kabo.planner.search.skeleton import Exhausted, Found, Geometry, Limits, Statistics, Unreachable

if TYPE_CHECKING:  # the geometry is imported where a scene needs it: symbolic problems never pay for it
    from kabo.planner.geometry.eager import Interleaved
    from kabo.planner.geometry.refusals import Ledger
    from kabo.tasks.procedures import GeometricProcedures


@dataclass
class Run:
    """One run of the planner: its options, when it must stop, what it did so far."""

    problem: Problem
    options: Options
    progress: Callable[[Progress], None] | None
    cancelled: Callable[[], bool] | None
    workers: int = 1
    stop: StopFlag = field(init=False)
    symbolic_s: float = 0.0
    geometric_s: float = 0.0
    load_s: float = 0.0
    searched: Statistics = field(default_factory=Statistics)
    packed: PackedTask | None = None
    refined: Mapping[str, float] = field(default_factory=dict)
    witness: "Callable[[GeometricProcedures], None] | None" = None
    certified: Mapping[str, Any] = field(default_factory=dict)
    cut_off: list[str] = field(default_factory=list)  # what a plan that was found lacks, in sentences
    on_found: Callable[[Result], None] | None = None

    def __post_init__(self) -> None:
        self.stop = StopFlag(self.options.timeout, self.options.memory, self.cancelled)

    @property
    def began(self) -> float:
        """When it began [s, of `perf_counter`]."""
        return self.stop.began

    @property
    def certifies(self) -> bool:
        """Whether a plan gets a certificate."""
        return self.options.certificate and self.options.geometry == "bounding"

    def note_cut(self, doing: str, lacks: str) -> None:
        """Notes what a plan lacks because something was cut off."""
        why = "it was interrupted" if self.stop.interrupted else f"{self.stop.spent} exhausted"
        self.cut_off.append(f"{doing} was cut off ({why}): {lacks}")

    def tell(self, doing: str, calls: int = 0) -> None:
        """Sends progress to whoever asked for it."""
        if self.progress is not None:
            self.progress(Progress(doing, self.searched.expanded, self.searched.generated, calls))


def search_once(
    run: Run, task: Task, geometry: "Ledger | Interleaved | Procedures | None"
) -> Found | Unreachable | Exhausted:
    """A skeleton, the proof that there is none, or what ended the search; counted and timed."""
    began = perf_counter()
    left = run.options.max_expansions - run.searched.expanded
    most = left if geometry is None else int(min(left, geometry.most_expansions(run.options.search)))
    limits = Limits(most, run.stop)
    run.packed = run.packed or PackedTask(task)
    found = find_skeleton(
        task,
        search=run.options.search,
        geometry=cast("Geometry | None", geometry),
        limits=limits,
        packed=run.packed,
    )
    if isinstance(found, Exhausted) and found.budget != "expansions" and run.stop.spent is not None:
        found = replace(found, budget=run.stop.spent)  # the search knows only that it was to stop
    run.searched += found.statistics
    run.symbolic_s += perf_counter() - began
    return found


def failures_of(geometry: "Ledger | Interleaved | None") -> Any:
    """Every call that was refused, with its first failure."""
    return [] if geometry is None else geometry.failures()


def _in_the_way(geometry: "Ledger | Interleaved | None", server: "GeometricProcedures | None") -> Any:
    """The same, and calls that were refused with few samples, before it was cut off that they are asked with more."""
    found = failures_of(geometry)
    if server is None:
        return found
    known = {call for call, _ in found}
    more = ((call, record) for call, record in server.records.of.items() if call not in known)
    return [*found, *((call, each.places[0].failure) for call, each in more if each.places and not each.successes)]


def without_plan(
    run: Run,
    task: Task,
    found: Unreachable | Exhausted,
    server: "GeometricProcedures | None",
    geometry: "Ledger | Interleaved | None" = None,
) -> Result:
    """The result of a run that has found no plan, with the reason."""
    statistics = statistics_of(run, server)
    failures = failures_of(geometry)
    if isinstance(found, Exhausted):
        why = "interrupted" if run.stop.interrupted else found.budget
        told = _in_the_way(geometry, server)
        return Result("exhausted", None, statistics, exhausted(found.budget, told, why))
    proved = geometry is None or geometry.proved()
    unproved = beyond_reasoning(verdict_of(run.problem), failures) if proved else None
    if unproved is not None:
        return Result("exhausted", None, statistics, unproved)
    if proved:
        return Result("no_plan", None, statistics, no_plan(run.problem, task, failures, run.stop))
    return Result("exhausted", None, statistics, exhausted("samples", failures))


def statistics_of(run: Run, server: "GeometricProcedures | None") -> dict[str, Any]:
    """What the run did, in figures (docs/plans.md#the-result)."""
    figures: dict[str, Any] = {
        "total_s": perf_counter() - run.began,
        "symbolic_s": run.symbolic_s,
        "geometric_s": run.geometric_s,
        "load_s": run.load_s,
        "expanded": run.searched.expanded,
        "generated": run.searched.generated,
    }
    if server is not None:
        counted = server.statistics
        figures |= {
            "inverse_kinematics_calls": counted.inverse_kinematics_calls,
            "inverse_kinematics_s": counted.inverse_kinematics_s,
            "collision_checks": counted.collision_checks,
            "positive_collision_checks": counted.positive_collision_checks,
            "collision_s": counted.collision_s,
            "pair_checks": counted.pair_checks,
            "geometric_states": server.states_met,
            "procedures": counted.procedures,
            **run.certified,
            **run.refined,
        }
    return figures
