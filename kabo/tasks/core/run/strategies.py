"""Strategies, which determine the order in which the jobs of a run are picked [T 3.6].

Round robin: every stage that has a runnable job executes its best job, in order of time; later stages see the
states that earlier stages have written in the same round.

Depth first: all jobs that depend on the latest generated scene are executed before a further scene is generated,
so a procedure tries one candidate after another. A monitoring generator triggered by a solution, such as a grasp,
runs only when a path leads from that solution to the generator; it runs last if the solution has become useless.
Depth first finds a first solution with least effort; many solutions vary less than those of round robin.
"""

from collections.abc import Callable, Iterator
from typing import Protocol

from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.solutions import LEFT, RIGHT
from kabo.tasks.core.run.groups import SerialNode
from kabo.tasks.core.run.job_queues import Leaf
from kabo.tasks.core.run.jobs import StageJob
from kabo.tasks.core.run.mergers import MergerNode
from kabo.tasks.core.run.nodes import StageNode
from kabo.tasks.core.run.wrappers import WrapperNode

Picked = tuple[Leaf, StageJob]
Turn = tuple[StageNode, StageJob | None]  # a node and its job; no job: see whether the task is complete
USELESS = 3  # the rank of jobs whose states nothing could join


class JobSource(Protocol):
    """The interface of a planning run to its search strategy."""

    order: list[StageNode]  # children before their containers, else in order of time
    root: StageNode

    def pick(self, node: Leaf) -> StageJob | None:
        """The best runnable job of a node, removed from its queue; None if no job may run now."""
        ...

    def lift_inside(self, node: StageNode) -> bool:
        """Turns the cheapest complete path through a container into a solution of it.

        Returns False if no path waited.
        """
        ...


class Strategy(Protocol):
    """The order in which the scheduler executes jobs."""

    def walk(self) -> Iterator[Turn]:
        """The jobs to be executed, one after the other."""
        ...

    def over(self) -> bool:
        """Whether this strategy has ended, so that the next one takes over."""
        ...


class RoundRobin:
    """A strategy that executes one job of each stage in turn."""

    def __init__(self, run: JobSource) -> None:
        self._run = run
        nodes = [node for node in run.order if isinstance(node, (SerialNode, Leaf)) and node is not run.root]
        self._round = [(node, node if isinstance(node, Leaf) else None) for node in nodes]

    def over(self) -> bool:
        """False: round robin never hands over to another strategy."""
        return False

    def walk(self) -> Iterator[Turn]:
        """The jobs of one round: the best runnable job of each stage, in order of time."""
        for node, leaf in self._round:
            if leaf is None:
                self._run.lift_inside(node)
            elif leaf.heap:
                job = self._run.pick(leaf)
                if job is not None:
                    yield leaf, job


class DepthFirst:
    """A strategy that plans with the latest generated scenes to the end before any further scene is generated.

    The order is: propagators, connectors, generators that have not run yet, other generators.

    Args:
        run: the planning run whose jobs are picked.
        until: returns True when the next strategy is to take over.
        by_targets: whether a generator that has run waits until all other generators have run.
    """

    def __init__(
        self, run: JobSource, *, until: Callable[[], bool] = lambda: False, by_targets: bool = False
    ) -> None:
        leaves = [node for node in run.order if isinstance(node, Leaf)]
        self._run, self.over, self._by_targets = run, until, by_targets
        self._serials = [node for node in run.order if isinstance(node, SerialNode) and node is not run.root]
        self._sources = [node for node in leaves if node.flow is Flow.GENERATE]
        joining = [node for node in leaves if node.flow is Flow.CONNECT]
        self._carrying = [node for node in leaves if node.flow not in (Flow.GENERATE, Flow.CONNECT)] + joining
        self._before = {node: _connector_before(node) for node in self._sources}
        self._merged = {node: _merged_child(node) for node in self._sources}

    def walk(self) -> Iterator[Turn]:
        """The jobs to be executed; ends when there are none.

        Whenever the task may have got complete paths, the root node is yielded without a job.
        """
        while True:
            lifted = [self._run.lift_inside(node) for node in self._serials]
            if any(lifted):
                yield self._run.root, None
            else:
                turn = self._job()
                if turn is None:
                    return
                yield turn
            if self.over():
                return

    def _job(self) -> Picked | None:
        fresh = [node for node in self._sources if not node.statistics.calls]
        for node in (*self._carrying, *fresh):
            job = self._run.pick(node)
            if job is not None:
                return node, job
        return self._generated()

    def _generated(self) -> Picked | None:
        """The best job of the generators, the last in time first; a useless job only if there is no other.

        Of a merger's children the one with the fewest solutions comes first: all of them have to vary.
        """
        taken: list[tuple[tuple[int, ...], Picked]] = []
        for place, node in enumerate(reversed(self._sources)):
            job = self._run.pick(node)
            while job is not None and self._is_useless(node, job):
                taken.append(((USELESS, 0, place), (node, job)))
                job = self._run.pick(node)
            if job is not None:
                child = self._merged[node]
                solved = 0 if child is None else len(child.solutions)
                taken.append(((self._rank(node, job), solved, place), (node, job)))
        chosen = min((rank for rank, _ in taken), default=None)
        found = None
        for rank, (node, job) in taken:
            if rank == chosen and found is None:
                found = node, job
            else:
                node.push(job)
        return found

    def _rank(self, node: Leaf, job: StageJob) -> int:
        """The rank of a job, less is better; by targets, new targets come before further configurations for a known one."""
        if not self._by_targets or not job.asked:
            return 0
        return 2 if isinstance(node, WrapperNode) else 1

    def _is_useless(self, node: Leaf, job: StageJob) -> bool:
        """Whether a job is for a success that is dead, or from which no path leads to what the node generates."""
        cause, before = node.cause(job), self._before[node]
        if cause is None or cause.start is None or cause.end is None:
            return False
        if not (cause.start.alive[LEFT] and cause.end.alive[RIGHT]):
            return True
        if before is None or before.level is not cause.end.level:
            return False
        return cause.end.best[RIGHT][0] < before.index - cause.end.position


def _merged_child(node: StageNode) -> StageNode | None:
    """The child of the innermost merger around a node in which the node is; None outside of mergers."""
    here = node
    while here.parent is not None and not isinstance(here.parent, MergerNode):
        here = here.parent
    return None if here.parent is None else here


def _connector_before(node: StageNode) -> StageNode | None:
    """The connector through which states come to what a node generates; None in the first section."""
    here: StageNode | None = node
    while here is not None:
        before = reversed(here.level.children[: here.index])
        found = next((other for other in before if other.flow is Flow.CONNECT), None)
        if found is not None:
            return found
        here = here.parent
    return None
