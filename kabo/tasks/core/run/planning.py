"""One planning run: the nodes of a task, what has changed, and the scheduler that executes jobs [T 3.6].

A *strategy* walks through the nodes and picks jobs. The scheduler executes the jobs one by one and keeps up to
date which jobs can run. It lets the strategy walk again until a whole walk has changed nothing: no job was run,
parked or queued again, no path became a solution of its container, no fallback was started. Only then has
everything been tried.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import count
from time import perf_counter
from typing import Any

from kabo.tasks.core.model.containers import Alternatives, Fallbacks, Limit, Merger, Serial, Wrapper, in_vain
from kabo.tasks.core.model.errors import TaskError, note
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.results import Refused
from kabo.tasks.core.model.solutions import Solution, State
from kabo.tasks.core.model.stages import Monitor, Stage
from kabo.tasks.core.run.fallbacks import ConnectingFallbacksNode, FallbacksNode, Lane, PropagatingFallbacksNode
from kabo.tasks.core.run.graph import reconsider
from kabo.tasks.core.run.groups import Holder, ParallelNode, SerialNode
from kabo.tasks.core.run.job_queues import Leaf
from kabo.tasks.core.run.jobs import StageJob
from kabo.tasks.core.run.leaves import ConnectorNode, GeneratorNode, Joining, MonitorNode, PropagatorNode
from kabo.tasks.core.run.mergers import MergerNode
from kabo.tasks.core.run.nodes import Level, StageNode
from kabo.tasks.core.run.strategies import Strategy, Turn
from kabo.tasks.core.run.workers import StageWorkers
from kabo.tasks.core.run.wrappers import LimitNode, WrapperNode

_GROUPS: tuple[tuple[type[Stage], type[StageNode]], ...] = (
    (Serial, SerialNode),
    (Alternatives, ParallelNode),
    (Merger, MergerNode),
    (Limit, LimitNode),
    (Wrapper, WrapperNode),
    (Monitor, MonitorNode),
)
_LEAVES = {Flow.GENERATE: GeneratorNode, Flow.CONNECT: ConnectorNode}
_FALLBACKS = {Flow.GENERATE: FallbacksNode, Flow.CONNECT: ConnectingFallbacksNode}


def _kind(stage: Stage, flow: Flow) -> type[StageNode]:
    if isinstance(stage, Fallbacks):
        return _FALLBACKS.get(flow, PropagatingFallbacksNode)
    found = next((made for base, made in _GROUPS if isinstance(stage, base)), None)
    return found or _LEAVES.get(flow, PropagatorNode)


class Planning:
    """A planning run of a task on one scene: its nodes, its job queues, its solutions so far."""

    def __init__(
        self,
        task: Serial,
        flows: Mapping[Stage, Flow],
        scene: Any,
        seed: int,
        *,
        pruning: bool = True,
        observe: Callable[[Stage, Refused], None] | None = None,
        audit: "Callable[[Planning], None] | None" = None,
        refuted: Mapping[Stage, Refused] | None = None,
    ) -> None:
        self.flows, self.scene, self.seed, self.pruning = flows, scene, seed, pruning
        self.observe, self._audit = observe, audit
        # The next number, for whatever must keep its order of arrival.
        self.count: Callable[[], int] = count(1).__next__
        self.changes = 0  # counts changes that may let a job run, or a solution be lifted
        self.asked: set[StageNode] = set()  # monitoring generators that are finding out whether more may come
        self._to_recheck: list[tuple[State, int]] = []
        self._has_work_again = False
        self.nodes: dict[Stage, StageNode] = {}
        self.order: list[StageNode] = []  # children before their containers, else in order of time
        self.root = self._built(task, None, Level(None), 0)  # type: ignore[arg-type]
        if not isinstance(self.root, SerialNode):
            raise TypeError("a task is a serial container")
        self.root.inner.top = True
        self._gates = {node: self._gates_of(node) for node in self.order}
        self._fallbacks = [node for node in self.order if isinstance(node, FallbacksNode)]
        self._joining = [node for node in self.order if isinstance(node, Joining)]
        choices = any(isinstance(stage, (Alternatives, Fallbacks)) for stage in self.nodes)
        # Where children are chosen among, others may fit that have found nothing yet.
        self._needed = [] if choices else [node for node in self.order if isinstance(node, ConnectorNode)]
        for node in self.order:
            if isinstance(node, MonitorNode):
                node.monitored = self.nodes[node.stage.monitored]  # type: ignore[attr-defined]
                node.monitored.monitors.append(node)
                node.monitored.exempt_from_pruning()
        self.jobs = 0
        self.exhausted = False
        self._rule_out(task, refuted or {})
        self.root.start()
        self._expect()
        self._turns: Iterator[Turn] = iter(())
        self._inconsistent = False  # whether an error interrupted a step

    def _built(self, stage: Stage, parent: StageNode | None, level: Level, index: int) -> StageNode:
        node = _kind(stage, self.flows[stage])(stage, self, parent, level, index)
        own = node.inner if isinstance(node, Holder) else None
        for i, child in enumerate(stage.children):
            node.children.append(self._built(child, node, own or level, i if own else index))
        if own is not None:
            own.children = node.children
        self.nodes[stage] = node
        self.order.append(node)
        return node

    def _rule_out(self, task: Serial, refuted: Mapping[Stage, Refused]) -> None:
        """Records stages that are proven to fail, and lets nothing run that needs a solution of theirs."""
        for stage, failure in refuted.items():
            self.nodes[stage].fail(None, None, failure)
        for stage in in_vain(task, refuted) if refuted else ():
            self.nodes[stage].closed = True

    @staticmethod
    def _gates_of(node: StageNode) -> list[tuple[ConnectingFallbacksNode, StageNode]]:
        found = []
        while node.parent is not None:
            if isinstance(node.parent, ConnectingFallbacksNode):
                found.append((node.parent, node))
            node = node.parent
        return found

    # ---------------------------------------------------------------------------- what nodes say has changed
    def recheck(self, state: State, side: int) -> None:
        """Requests that, after the present job, it is updated whether a state is alive on `side`."""
        if self.pruning:
            self._to_recheck.append((state, side))

    def work_changed(self, node: StageNode, lane: object) -> None:
        """Records that a node's job ran or was parked, or that it got a solution.

        Fallbacks around the node are re-examined.
        """
        self.changes += 1
        if isinstance(lane, Lane):
            while isinstance(lane, Lane):
                lane.fallbacks.doubtful[lane] = None
                lane = lane.outer
        else:
            for fallbacks, _ in self._gates[node]:
                fallbacks.stale = True

    def has_work_again(self, node: StageNode) -> None:
        """Records that a node which had no runnable jobs has some again, so that it may write states."""
        self.changes += 1
        self._has_work_again = self._has_work_again or node.flow is not Flow.CONNECT

    # ------------------------------------------------------------------------------------------ the scheduler
    def follow(self, *strategies: Strategy) -> None:
        """Picks jobs by these strategies from now on, one strategy after another.

        A run that has exhausted its strategies is resumed.
        """
        self._turns = self._scheduled(strategies)

    def _scheduled(self, strategies: Sequence[Strategy]) -> Iterator[Turn]:
        for strategy in strategies:
            before = -1
            while before != self.changes and not strategy.over():
                before = self.changes
                yield from strategy.walk()
                if not strategy.over():
                    self.end_walk()
                    if before == self.changes and any(fallbacks.give_way() for fallbacks in self._fallbacks):
                        self.settle()  # fallbacks that waited for each other

    def complete(self) -> bool:
        """Whether complete paths through the whole task wait to become solutions of the task."""
        return bool(self.root.paths.heap)  # type: ignore[attr-defined]

    def hopeless(self) -> bool:
        """Whether a connector of every solution joins nothing, for the order of the stages around it."""
        return any(node.never_fits() for node in self._needed)

    def lift(self) -> Solution | None:
        """Turns the cheapest complete path into a solution of the task and returns it.

        The result is None if its cost makes it a failure.
        """
        before = len(self.root.solutions)
        self._begin()
        self.lift_inside(self.root)
        self._inconsistent = False
        return self.root.solutions[-1] if len(self.root.solutions) > before else None

    def lift_inside(self, node: StageNode) -> bool:
        """Turns the cheapest complete path through a container into a solution of it.

        Returns False if no path waited.
        """
        lifted: bool = node.lift()  # type: ignore[attr-defined]
        if lifted:
            self.settle()
        return lifted

    def lift_complete(self) -> bool:
        """Turns one waiting path of each serial container into a solution; returns whether any path waited."""
        self._begin()
        lifted = [self.lift_inside(node) for node in self.order if isinstance(node, SerialNode)]
        self._inconsistent = False
        return any(lifted)

    def step(self, workers: StageWorkers | None = None) -> bool:
        """Executes one job, or makes one solution of a container from a complete path.

        Returns False if nothing is left to do.
        """
        if self.exhausted:
            return False
        self._begin()
        turn = next(self._turns, None)
        if turn is not None and turn[1] is not None:
            self._execute(turn[0], turn[1], workers)  # type: ignore[arg-type]
        self._inconsistent = False
        self.exhausted = turn is None
        return not self.exhausted

    def _begin(self) -> None:
        """Marks a step as begun: an error before its end, as of a cost term, leaves the run inconsistent."""
        if self._inconsistent:
            raise TaskError("an error broke planning off in the middle of a step; reset() the task to plan again")
        self._inconsistent = True

    def _execute(self, node: Leaf, job: StageJob, workers: StageWorkers | None) -> None:
        try:
            if workers is None:
                began = perf_counter()
                found, finished = job.run(node.function())
                seconds = perf_counter() - began
            else:
                found, finished, seconds = workers.run(node, job)
        except BaseException as error:
            node.put_back(job)  # interrupted by an error or a person; it runs again if planning continues
            self._inconsistent = False
            note(error, f"in stage {node.stage.path!r}")
            raise
        self.jobs += 1
        node.statistics.calls += 1
        node.statistics.seconds += seconds
        node.absorb(job, found, finished)
        self.settle()
        if self._audit is not None:
            self._audit(self)

    def pick(self, node: Leaf) -> StageJob | None:
        """The best runnable job of a node, removed from its queue.

        The result is None if no job can run or fallbacks forbid it now.
        """
        gates = self._gates[node] if node.heap else ()
        return node.pick() if all(gate.permits(child) for gate, child in gates) else None

    def settle(self) -> None:
        """Updates which states are alive and lets fallbacks move on, until nothing changes."""
        while True:
            if self._has_work_again:
                self._has_work_again = False
                self._expect(again=True)
            if self._to_recheck:
                self.changes += reconsider(self._to_recheck)
            moved = self._has_work_again or any(fallbacks.move_on(False) for fallbacks in self._fallbacks)
            if not moved and not self._to_recheck:
                return

    def end_walk(self) -> None:
        """Updates whether states may still get partners, and lets fallbacks start their next child."""
        self._expect()
        self.settle()
        for fallbacks in self._fallbacks:
            while fallbacks.move_on(True):
                self.changes += 1
                self.settle()

    def _expect(self, *, again: bool = False) -> None:
        for node in self._joining:
            if node.expect(again):
                self.work_changed(node, None)
