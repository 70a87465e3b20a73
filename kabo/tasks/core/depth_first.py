"""Depth first: one job at a time, what was offered last is followed to its end before anything more is sampled.

Scenes are generated only where they can be come to, as far as is known: what a monitor offers for a grasp waits until
a path leads from that grasp to the stage, and comes last once the grasp is of no use. The first solution costs least so,
many solutions vary less than round by round.
"""

from collections.abc import Callable, Sequence

from kabo.tasks.core.flow import Flow
from kabo.tasks.core.groups import SerialNode
from kabo.tasks.core.jobs import Job
from kabo.tasks.core.nodes import Leaf, Node
from kabo.tasks.core.solutions import LEFT, RIGHT
from kabo.tasks.core.wrappers import WrapperNode

Picked = tuple[Leaf, Job]
VAIN = 3  # the rank of what nothing would join
Pick = Callable[[Node], Job | None]


class DepthFirst:
    """Chooses jobs of the nodes of one run.

    Args:
        nodes: all but the task's own, children before containers, else in order of time.
        pick: the best job of a node, taken out of its queue; None if it has none that may run.
        by_targets: whether what was offered last may wait until all else was tried once.
    """

    def __init__(self, nodes: Sequence[Node], pick: Pick, *, by_targets: bool) -> None:
        leaves = [node for node in nodes if isinstance(node, Leaf)]
        self._pick, self._by_targets = pick, by_targets
        self._serials = [node for node in nodes if isinstance(node, SerialNode)]
        self._sources = [node for node in leaves if node.flow is Flow.GENERATE]
        self._joining = [node for node in leaves if node.flow is Flow.CONNECT]
        self._carrying = [node for node in leaves if node.flow not in (Flow.GENERATE, Flow.CONNECT)]
        self._before = {node: _connector_before(node) for node in self._sources}

    def lift(self) -> bool:
        """Makes solutions of containers of the paths that wait inside; whether there were any."""
        lifted = [node.lift() for node in self._serials]
        return any(lifted)

    def job(self) -> Picked | None:
        """The next job, with its node: what carries on, what joins, what was never asked, then more to begin with."""
        fresh = [node for node in self._sources if not node.statistics.calls]
        for node in (*self._carrying, *self._joining, *fresh):
            job = self._pick(node)
            if job is not None:
                return node, job
        return self._generated()

    def _generated(self) -> Picked | None:
        """The best job of the generators, the last first; what is in vain only if nothing else is left."""
        taken: list[tuple[tuple[int, ...], Picked]] = []
        for place, node in enumerate(reversed(self._sources)):
            job = self._pick(node)
            while job is not None and self._is_vain(node, job):
                taken.append(((VAIN, place), (node, job)))
                job = self._pick(node)
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

    def _rank(self, node: Leaf, job: Job) -> int:
        """By targets, another target comes before another configuration for one that has been asked for."""
        if not self._by_targets or not job.asked:
            return 0
        return 2 if isinstance(node, WrapperNode) else 1

    def _is_vain(self, node: Leaf, job: Job) -> bool:
        """Whether a job is for a success that is dead, or from which no path leads to what the node generates."""
        cause, before = node.cause(job), self._before[node]
        if cause is None or cause.start is None or cause.end is None:
            return False
        if not (cause.start.alive[LEFT] and cause.end.alive[RIGHT]):
            return True
        if before is None or before.level is not cause.end.level:
            return False
        return cause.end.best[RIGHT][0] < before.index - cause.end.position


def _connector_before(node: Node) -> Node | None:
    """The connector from which states would come to what a node generates; None in the first section."""
    here: Node | None = node
    while here is not None:
        before = reversed(here.level.children[: here.index])
        found = next((other for other in before if other.flow is Flow.CONNECT), None)
        if found is not None:
            return found
        here = here.parent
    return None
