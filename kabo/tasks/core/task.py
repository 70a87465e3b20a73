"""A task: a serial container that generates; `plan` is what callers use [T 3.6]."""

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from time import monotonic
from typing import Any

from kabo.tasks.core.model.containers import Serial
from kabo.tasks.core.model.errors import TaskError
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.interfaces import resolve, tree
from kabo.tasks.core.model.results import Refused
from kabo.tasks.core.model.solutions import Solution
from kabo.tasks.core.model.stages import Stage
from kabo.tasks.core.run.explanation import Explanation, explain
from kabo.tasks.core.run.nodes import StageStatistics
from kabo.tasks.core.run.planning import Planning
from kabo.tasks.core.run.strategies import DepthFirst, RoundRobin
from kabo.tasks.core.run.workers import StageWorkers

MAX_FINAL_LIFTS = 100  # rounds of turning complete paths into solutions after planning was stopped


def never() -> bool:
    """False: the default for `stop`."""
    return False


class Task(Serial):
    """A whole task. Planning can be stopped and continued: `plan` goes on where it left off, `reset` starts over.

    Args:
        name: the name of the task.
        children: its stages, in order of time.
        seed: the seed of all random choices.
        pruning: whether jobs wait while their states cannot become part of a solution.
        lazy: plan depth first; else round robin.
        depth_first: the number of jobs to plan depth first before round robin, unless a solution is found earlier.
        observe: called with every failure and its stage.
        audit: called with the run after every job, for tests.
        properties: properties of the task, which its stages can inherit.
    """

    def __init__(
        self,
        name: str,
        /,
        *children: Stage,
        seed: int = 0,
        pruning: bool = True,
        lazy: bool = False,
        depth_first: int = 0,
        observe: Callable[[Stage, Refused], None] | None = None,
        audit: Callable[[Planning], None] | None = None,
        **properties: Any,
    ) -> None:
        super().__init__(name, *children, **properties)
        self.seed = seed
        self.pruning, self.lazy, self.depth_first, self.observe = pruning, lazy, depth_first, observe
        self.audit = audit
        # Stages that are proven to fail, with their failures, before planning begins: nothing that needs them is run.
        self.refuted: Mapping[Stage, Refused] = {}
        self.directions: Mapping[Stage, Flow] = {}
        self._planning: Planning | None = None
        self._workers: StageWorkers | None = None

    # ------------------------------------------------------------------------------------------- planning
    def initialise(self) -> None:
        """Resolves the flow of every stage.

        Raises:
            InitialisationError: lists all faults; the task is unchanged.
        """
        self.directions = resolve(self)

    def reset(self) -> None:
        """Forgets all planning results; the stages stay."""
        self.close()
        self._planning = None

    def close(self) -> None:
        """Ends the worker processes of the task; they start again if planning continues with workers."""
        if self._workers is not None:
            self._workers.close()
            self._workers = None

    def plan(
        self,
        scene: Any = None,
        max_solutions: int | None = None,
        *,
        jobs: int | None = None,
        stop: Callable[[], bool] = never,
        commit_after: float | None = None,
        workers: int | None = None,
    ) -> list[Solution]:
        """Plans until there are `max_solutions` or everything was tried; returns all solutions in order of discovery.

        It ends, too, where a connector can join nothing because of the order of the stages, which `explain` tells.

        Args:
            scene: the scene in which the task begins; only the first call uses it.
            max_solutions: counted over all calls; None: as many as there are.
            jobs: the number of jobs that this call may execute.
            stop: called between jobs; True ends the call.
            commit_after: seconds after which one solution suffices.
            workers: number of processes, with this one, that execute jobs ahead of time; they live until `close`. The
                solutions and their order are the same for any number.

        Raises:
            InitialisationError: the stages do not fit together.
            TaskError: stages were added or removed since planning began, or an error interrupted it; `reset` it.
        """
        run = self._run(scene)
        helpers = self._helpers(run, workers)
        began, limit = monotonic(), None if jobs is None else run.jobs + jobs

        def wanted() -> bool:
            return max_solutions is None or len(run.root.solutions) < max_solutions

        def stopped() -> bool:
            late = commit_after is not None and monotonic() - began >= commit_after
            return bool(late and run.root.solutions) or stop()

        with ExitStack() as after_errors:
            after_errors.callback(self.close)
            was_stopped = False
            while wanted() and not (was_stopped := stopped()) and not run.hopeless():
                if run.complete():
                    run.lift()
                elif (limit is not None and run.jobs >= limit) or not (run.step(helpers) or run.complete()):
                    break
            for _ in range(MAX_FINAL_LIFTS if was_stopped else 0):
                if not (wanted() and run.lift_complete()):
                    break
            after_errors.pop_all()
        return self.solutions

    def adopt(self, solution: Solution, scene: Any = None) -> bool:
        """Adds a solution of the whole task that was found elsewhere, with its cost, unless a cost term replaces that.

        Returns False if the cost term makes it a failure. `scene` is as for `plan`, if nothing was planned yet.
        """
        return self._run(scene).root.report(solution)

    def _helpers(self, run: Planning, size: int | None) -> StageWorkers | None:
        if self._workers is not None and self._workers.size != size:
            self.close()
        if size is not None and size > 1 and self._workers is None:
            self._workers = StageWorkers(run, size)
        return self._workers

    def _run(self, scene: Any) -> Planning:
        if self._planning is None:
            self.initialise()
            self._planning = self._begun(scene)
        elif set(self.walk()) != set(self._planning.nodes):
            raise TaskError(
                f"stages of {self.name!r} were added or removed since planning began; reset() it first"
            )
        return self._planning

    def _begun(self, scene: Any) -> Planning:
        how: dict[str, Any] = {"pruning": self.pruning, "observe": self.observe, "audit": self.audit}
        how["refuted"] = self.refuted
        run, at_first = Planning(self, self.directions, scene, self.seed, **how), self.depth_first

        def over() -> bool:
            return bool(run.jobs >= at_first or run.root.solutions or run.complete())

        if self.lazy:
            run.follow(DepthFirst(run))
        else:
            run.follow(DepthFirst(run, until=over, by_targets=True), RoundRobin(run))
        return run

    # -------------------------------------------------------------------------------------------- results
    @property
    def solutions(self) -> list[Solution]:
        """The solutions of the whole task so far, in order of discovery."""
        return [] if self._planning is None else list(self._planning.root.solutions)

    @property
    def best(self) -> Solution | None:
        """The cheapest solution so far, of equal ones the first; None if there is none."""
        return min(self.solutions, key=lambda solution: solution.cost, default=None)

    @property
    def exhausted(self) -> bool:
        """Whether everything was tried, so that further planning finds no more solutions."""
        return self._planning is not None and self._planning.exhausted and not self._planning.complete()

    @property
    def statistics(self) -> dict[str, StageStatistics]:
        """The figures of every stage (jobs, seconds, successes, costs, failures) by path, in order of time."""
        return {stage.path: self.figures(stage) for stage in self.walk()}

    def figures(self, stage: Stage) -> StageStatistics:
        """The figures of one stage; unlike `statistics`, this distinguishes stages that have the same path."""
        node = None if self._planning is None else self._planning.nodes.get(stage)
        return StageStatistics() if node is None else node.statistics

    def found(self, stage: Stage) -> tuple[list[Solution], list[Solution]]:
        """The solutions of one stage so far, and its failures as far as they were kept."""
        node = None if self._planning is None else self._planning.nodes.get(stage)
        return ([], []) if node is None else (list(node.solutions), list(node.failures))

    def explain(self) -> Explanation:
        """The explanation why there is no solution (yet): the first stage that failed, and its reasons."""
        kept = {stage: self.found(stage)[1] for stage in self.walk()}
        return explain(self, self.directions, {stage: self.figures(stage) for stage in self.walk()}, kept)

    def tree(self) -> str:
        """The tree of the task's stages as text: the arrows of each flow, names, classes and properties."""
        return tree(self, self.directions or None)
