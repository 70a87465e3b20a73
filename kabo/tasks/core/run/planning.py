"""One planning run: the nodes of a task, what has changed, and the one scheduler that executes jobs [T 3.6].

A *strategy* walks through the nodes and picks jobs. The scheduler executes them one by one, keeps up to date what can
run, and lets the strategy walk again, until a whole walk has changed nothing: no job was run, parked or revived, no
solution lifted, no fallback asked, nothing waited for any more. Only then everything was tried.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import count
from time import perf_counter
from typing import Any

from kabo.tasks.core.model.containers import Alternatives, Fallbacks, Limit, Merger, Serial, Wrapper
from kabo.tasks.core.model.errors import TaskError, note
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.results import Failure
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
    """A run of a task on one scene: its graph, its queues, its solutions so far."""

    def __init__(
        self,
        task: Serial,
        flows: Mapping[Stage, Flow],
        scene: Any,
        seed: int,
        *,
        pruning: bool = True,
        observe: Callable[[Stage, Failure], None] | None = None,
        audit: "Callable[[Planning], None] | None" = None,
    ) -> None:
        self.flows, self.scene, self.seed, self.pruning = flows, scene, seed, pruning
        self.observe, self._audit = observe, audit
        self.count: Callable[[], int] = count(1).__next__  # numbers whatever must keep its order of arrival
        self.changes = 0  # counts whatever may let a job run, or a solution be lifted, that could not before
        self.asked: set[StageNode] = (
            set()
        )  # the monitors that one question, whether more may come, was handed on to
        self._touched: list[tuple[State, int]] = []
        self._woken = False
        self.nodes: dict[Stage, StageNode] = {}
        self.order: list[StageNode] = []  # children before their containers, else in order of time
        self.root = self._built(task, None, Level(None), 0)  # type: ignore[arg-type]
        if not isinstance(self.root, SerialNode):
            raise TypeError("a task is a serial container")
        self.root.inner.top = True
        self._gates = {node: self._gates_of(node) for node in self.order}
        self._fallbacks = [node for node in self.order if isinstance(node, FallbacksNode)]
        self._joining = [node for node in self.order if isinstance(node, Joining)]
        for node in self.order:
            if isinstance(node, MonitorNode):
                node.monitored = self.nodes[node.stage.monitored]  # type: ignore[attr-defined]
                node.monitored.monitors.append(node)
                node.monitored.keep()
        self.jobs = 0
        self.exhausted = False
        self.root.start()
        self._expect()
        self._turns: Iterator[Turn] = iter(())
        self._torn = False  # an error left a step half done

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

    @staticmethod
    def _gates_of(node: StageNode) -> list[tuple[ConnectingFallbacksNode, StageNode]]:
        found = []
        while node.parent is not None:
            if isinstance(node.parent, ConnectingFallbacksNode):
                found.append((node.parent, node))
            node = node.parent
        return found

    # ---------------------------------------------------------------------------- what nodes say has changed
    def touch(self, state: State, side: int) -> None:
        """A state may have died on that side, or be alive again; looked at after the job that runs."""
        if self.pruning:
            self._touched.append((state, side))

    def rested(self, node: StageNode, lane: object) -> None:
        """Work in a node was done, lifted or parked, of a lane or for all: fallbacks around it may have to go on."""
        self.changes += 1
        if isinstance(lane, Lane):
            while isinstance(lane, Lane):
                lane.fallbacks.doubtful[lane] = None
                lane = lane.outer
        else:
            for fallbacks, _ in self._gates[node]:
                fallbacks.stale = True

    def woken(self, node: StageNode) -> None:
        """A node has jobs again, so states may come from it."""
        self.changes += 1
        self._woken = self._woken or node.flow is not Flow.CONNECT

    # ------------------------------------------------------------------------------------------ the scheduler
    def follow(self, *strategies: Strategy) -> None:
        """From now on jobs are picked by these strategies, one after the other; a run that ended goes on."""
        self._turns = self._scheduled(strategies)

    def _scheduled(self, strategies: Sequence[Strategy]) -> Iterator[Turn]:
        for strategy in strategies:
            before = -1
            while before != self.changes and not strategy.over():
                before = self.changes
                yield from strategy.walk()
                if not strategy.over():
                    self.rest()
                    if before == self.changes and any(fallbacks.give_way() for fallbacks in self._fallbacks):
                        self.settle()  # what waited in a circle

    def complete(self) -> bool:
        """Whether whole solutions wait to be lifted."""
        return bool(self.root.paths.heap)  # type: ignore[attr-defined]

    def lift(self) -> Solution | None:
        """The cheapest whole solution that waits; None if its cost term refused it."""
        before = len(self.root.solutions)
        self._begin()
        self.lift_inside(self.root)
        self._torn = False
        return self.root.solutions[-1] if len(self.root.solutions) > before else None

    def lift_inside(self, node: StageNode) -> bool:
        """Makes a solution of a container of the cheapest path that waits in it; whether there was one."""
        lifted: bool = node.lift()  # type: ignore[attr-defined]
        if lifted:
            self.settle()
        return lifted

    def lift_what_is_there(self) -> bool:
        """Lifts what is complete, inside and as a whole, for a run that shall end; whether there was anything."""
        self._begin()
        lifted = [self.lift_inside(node) for node in self.order if isinstance(node, SerialNode)]
        self._torn = False
        return any(lifted)

    def step(self, workers: StageWorkers | None = None) -> bool:
        """Executes one job, or lifts one solution of a container; False if nothing is left to do."""
        if self.exhausted:
            return False
        self._begin()
        turn = next(self._turns, None)
        if turn is not None and turn[1] is not None:
            self._execute(turn[0], turn[1], workers)  # type: ignore[arg-type]
        self._torn = False
        self.exhausted = turn is None
        return not self.exhausted

    def _begin(self) -> None:
        """From here to the end of a step an error, of a cost term say, leaves the run between two states of affairs."""
        if self._torn:
            raise TaskError("an error broke planning off in the middle of a step; reset() the task to plan again")
        self._torn = True

    def _execute(self, node: Leaf, job: StageJob, workers: StageWorkers | None) -> None:
        try:
            if workers is None:
                began = perf_counter()
                found, finished = job.run(node.function())
                seconds = perf_counter() - began
            else:
                found, finished, seconds = workers.run(node, job)
        except BaseException as error:
            node.put_back(job)  # broken off, by an error or a person, it is asked again when planning goes on
            self._torn = False
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
        """The best job of a node, taken out of its queue, if it may run now."""
        gates = self._gates[node] if node.heap else ()
        return node.pick() if all(gate.permits(child) for gate, child in gates) else None

    def settle(self) -> None:
        """Finds out what has died and what is alive again, and then where fallbacks have to go on."""
        while True:
            if self._woken:
                self._woken = False
                self._expect(again=True)
            if self._touched:
                self.changes += reconsider(self._touched)
            moved = self._woken or any(fallbacks.move_on(False) for fallbacks in self._fallbacks)
            if not moved and not self._touched:
                return

    def rest(self) -> None:
        """What no single job brings about: partners that will not come any more, generators to fall back on."""
        self._expect()
        self.settle()
        for fallbacks in self._fallbacks:
            while fallbacks.move_on(True):
                self.changes += 1
                self.settle()

    def _expect(self, *, again: bool = False) -> None:
        for node in self._joining:
            if node.expect(again):
                self.rested(node, None)
