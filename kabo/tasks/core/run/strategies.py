"""Strategies: in which order the jobs of a run are picked; that all are, is the scheduler's concern [T 3.6].

Round by round, every stage that is ready executes one job, its best, in order of time; what comes later in the order
sees the states that came earlier in the same round.

Depth first, it is one job at a time, and what was offered last is followed to its end before anything more is sampled:
that is how a procedure tries candidate after candidate. Scenes are generated only where they can be come to, as far as
is known: what a monitor offers for a grasp waits until a path leads from that grasp to the stage, and comes last once
the grasp is of no use. The first solution costs least so, many solutions vary less than round by round.
"""

from collections.abc import Callable, Iterator
from typing import Protocol

from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.solutions import LEFT, RIGHT
from kabo.tasks.core.run.groups import SerialNode
from kabo.tasks.core.run.job_queues import Leaf
from kabo.tasks.core.run.jobs import StageJob
from kabo.tasks.core.run.nodes import StageNode
from kabo.tasks.core.run.wrappers import WrapperNode

Picked = tuple[Leaf, StageJob]
Turn = tuple[
    StageNode, StageJob | None
]  # whose turn it is, with which job; without one, to look for whole solutions
VAIN = 3  # the rank of what nothing would join


class JobSource(Protocol):
    """What a strategy may ask of its planning run."""

    order: list[StageNode]  # children before their containers, else in order of time
    root: StageNode

    def pick(self, node: Leaf) -> StageJob | None:
        """The best job of a node, taken out of its queue; None if no job of it may run now."""
        ...

    def lift_inside(self, node: StageNode) -> bool:
        """Makes a solution of a container of the cheapest path that waits in it; whether there was one."""
        ...


class Strategy(Protocol):
    """What the scheduler asks, again and again."""

    def walk(self) -> Iterator[Turn]:
        """Jobs to be executed, one after the other."""
        ...

    def over(self) -> bool:
        """Whether another strategy shall go on."""
        ...


class RoundRobin:
    """One job of each stage in turn."""

    def __init__(self, run: JobSource) -> None:
        self._run = run
        nodes = [node for node in run.order if isinstance(node, (SerialNode, Leaf)) and node is not run.root]
        self._round = [(node, node if isinstance(node, Leaf) else None) for node in nodes]

    def over(self) -> bool:
        """Never."""
        return False

    def walk(self) -> Iterator[Turn]:
        """One round."""
        for node, leaf in self._round:
            if leaf is None:
                self._run.lift_inside(node)
            elif leaf.heap:
                job = self._run.pick(leaf)
                if job is not None:
                    yield leaf, job


class DepthFirst:
    """One job at a time: what carries on, what joins, what was never asked, then more to begin with.

    Args:
        run: whose jobs.
        until: when another strategy shall go on.
        by_targets: whether what was offered last may wait until all else was tried once.
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

    def walk(self) -> Iterator[Turn]:
        """Jobs, and a turn of the task whenever containers may have completed it; ends when there are none."""
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
        """The best job of the generators, the last first; what is in vain only if nothing else is left."""
        taken: list[tuple[tuple[int, ...], Picked]] = []
        for place, node in enumerate(reversed(self._sources)):
            job = self._run.pick(node)
            while job is not None and self._is_vain(node, job):
                taken.append(((VAIN, place), (node, job)))
                job = self._run.pick(node)
            if job is not None:
                taken.append(((self._rank(node, job), place), (node, job)))
        chosen = min((rank for rank, _ in taken), default=None)
        found = None
        for rank, (node, job) in taken:
            if rank == chosen and found is None:
                found = node, job
            else:
                node.push(job)
        return found

    def _rank(self, node: Leaf, job: StageJob) -> int:
        """By targets, another target comes before another configuration for one that has been asked for."""
        if not self._by_targets or not job.asked:
            return 0
        return 2 if isinstance(node, WrapperNode) else 1

    def _is_vain(self, node: Leaf, job: StageJob) -> bool:
        """Whether a job is for a success that is dead, or from which no path leads to what the node generates."""
        cause, before = node.cause(job), self._before[node]
        if cause is None or cause.start is None or cause.end is None:
            return False
        if not (cause.start.alive[LEFT] and cause.end.alive[RIGHT]):
            return True
        if before is None or before.level is not cause.end.level:
            return False
        return cause.end.best[RIGHT][0] < before.index - cause.end.position


def _connector_before(node: StageNode) -> StageNode | None:
    """The connector from which states would come to what a node generates; None in the first section."""
    here: StageNode | None = node
    while here is not None:
        before = reversed(here.level.children[: here.index])
        found = next((other for other in before if other.flow is Flow.CONNECT), None)
        if found is not None:
            return found
        here = here.parent
    return None
