"""One planning run: the nodes of a task, and the rounds in which their jobs are executed [T 3.6].

A round walks the stages in order of time; each that is ready executes one job, its best, and what comes later in the
order sees the states that came earlier in the same round. With workers, a round takes the jobs first, runs them side
by side, and takes their answers in in the order of the stages: the same for any number of workers.

Lazily, it is one job at a time, depth first: that is how a procedure tries candidate after candidate. A run may begin
so, for its first solution, and go on round by round, for others that vary.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import chain, count
from time import perf_counter
from typing import TYPE_CHECKING, Any

from kabo.tasks.core.containers import Alternatives, Fallbacks, Limit, Merger, Serial, Wrapper
from kabo.tasks.core.depth_first import DepthFirst
from kabo.tasks.core.errors import TaskError, note
from kabo.tasks.core.fallbacks import FallbacksNode
from kabo.tasks.core.flow import Flow
from kabo.tasks.core.graph import Level, reconsider
from kabo.tasks.core.groups import ParallelNode, SerialNode
from kabo.tasks.core.jobs import Job
from kabo.tasks.core.leaves import ConnectorNode, GeneratorNode, MonitorNode, PropagatorNode
from kabo.tasks.core.mergers import MergerNode
from kabo.tasks.core.nodes import Ended, Node
from kabo.tasks.core.results import Answer, Failure
from kabo.tasks.core.solutions import Solution, State
from kabo.tasks.core.stages import Monitor, Stage
from kabo.tasks.core.wrappers import LimitNode, WrapperNode

if TYPE_CHECKING:
    from kabo.tasks.core.workers import Workers

_GROUPS: tuple[tuple[type[Stage], type[Node]], ...] = (
    (Serial, SerialNode),
    (Alternatives, ParallelNode),
    (Fallbacks, FallbacksNode),
    (Merger, MergerNode),
    (Limit, LimitNode),
    (Wrapper, WrapperNode),
    (Monitor, MonitorNode),
)
_LEAVES = {Flow.GENERATE: GeneratorNode, Flow.CONNECT: ConnectorNode}


_Turn = tuple[Node, Job | None]  # whose turn it is, with which job; without one, to look for whole solutions


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
        lazy: bool = False,
        depth_first: int = 0,
        observe: Callable[[Stage, Failure], None] | None = None,
    ) -> None:
        self.flows, self.scene, self.seed, self.pruning = flows, scene, seed, pruning
        self.observe = observe
        self.count: Callable[[], int] = count(1).__next__  # numbers whatever must keep its order of arrival
        self._ended: Ended = []
        self.misfits: list[
            tuple[ConnectorNode, State, State, object]
        ] = []  # noted while states were being handed on
        self.nodes: dict[Stage, Node] = {}
        self.order: list[Node] = []  # children before their containers, else in order of time
        self.root = self._built(task, None, Level(None), 0)  # type: ignore[arg-type]
        if not isinstance(self.root, SerialNode):
            raise TypeError("a task is a serial container")
        self.root.inner.top = True
        self._gates = {node: self._gates_of(node) for node in self.order}
        self._serials = [node for node in self.order if isinstance(node, SerialNode)]
        self._round = [(node, isinstance(node, SerialNode)) for node in self.order if node is not self.root]
        self._fallbacks = [node for node in self.order if isinstance(node, FallbacksNode)]
        self._connectors = [node for node in self.order if isinstance(node, (ConnectorNode, FallbacksNode))]
        for node in self.order:
            if isinstance(node, MonitorNode):
                node.monitored = self.nodes[node.stage.monitored]  # type: ignore[attr-defined]
                node.monitored.monitors.append(node)
                node.monitored.keep()
        for fallbacks in self._fallbacks:
            fallbacks.keep_shared()
        self.jobs = 0
        self.exhausted = False
        self._left: list[Node] = []  # of a parallel round, the stages that have not had their turn
        self._worked = False  # whether anything was done in it
        self.root.start()
        self._turns = self._lazily() if lazy else chain(self._lazily_at_first(depth_first), self._walk())
        self._torn = False  # an error left a step half done

    def _built(self, stage: Stage, parent: Node | None, level: Level, index: int) -> Node:
        kind = next((made for base, made in _GROUPS if isinstance(stage, base)), None)
        node = (kind or _LEAVES.get(self.flows[stage], PropagatorNode))(stage, self, parent, level, index)
        own = node.inner if isinstance(node, (SerialNode, WrapperNode)) else None
        for i, child in enumerate(stage.children):
            node.children.append(self._built(child, node, own or level, i if own else index))
        if own is not None:
            own.children = node.children
        self.nodes[stage] = node
        self.order.append(node)
        return node

    @staticmethod
    def _gates_of(node: Node) -> list[tuple[FallbacksNode, Node]]:
        found = []
        while node.parent is not None:
            if isinstance(node.parent, FallbacksNode) and node.parent.flow is Flow.CONNECT:
                found.append((node.parent, node))
            node = node.parent
        return found

    # ------------------------------------------------------------------------------------ for the nodes
    def ended(self, states: Ended) -> None:
        """Something may have died of these; looked at after the job that runs."""
        self._ended += states

    # -------------------------------------------------------------------------------------------- rounds
    def complete(self) -> bool:
        """Whether whole solutions wait to be lifted."""
        return bool(self.root.paths.heap)  # type: ignore[attr-defined]

    def lift(self) -> Solution | None:
        """The cheapest whole solution that waits; None if its cost term refused it."""
        before = len(self.root.solutions)
        self._begin()
        self.root.lift()  # type: ignore[attr-defined]
        self._torn = False
        return self.root.solutions[-1] if len(self.root.solutions) > before else None

    def step(self) -> bool:
        """Executes one job, or lifts one solution of a container; False if nothing is left to do."""
        if self.exhausted:
            return False
        self._begin()
        turn = next(self._turns, None)
        if turn is not None:
            node, job = turn
            if job is not None:
                self._execute(node, job)
        self._torn = False
        self.exhausted = turn is None
        return not self.exhausted

    def _begin(self) -> None:
        """From here to the end of a step an error, of a cost term say, leaves the run between two states of affairs."""
        if self._torn:
            raise TaskError("an error broke planning off in the middle of a step; reset() the task to plan again")
        self._torn = True

    def _execute(self, node: Node, job: Job) -> None:
        began = perf_counter()
        try:
            found, finished = job.run(node.function())
        except BaseException as error:
            self._put_back(((node, job),))
            note(error, f"in stage {node.stage.path!r}")
            raise
        self.take_in(node, job, found, finished, perf_counter() - began)

    def _put_back(self, taken: Iterable[tuple[Node, Job]]) -> None:
        """Jobs that were broken off, by an error or a person, are asked again when planning goes on."""
        for node, job in taken:
            node.put_back(job)
        self._torn = False

    def _walk(self) -> Iterator[_Turn]:
        """Round after round; yields jobs to be executed, and ends when there are none."""
        while True:
            worked = False
            for node, lifts in self._round:
                if lifts:
                    if node.lift():  # type: ignore[attr-defined]
                        worked = True
                        self.settle()
                    continue
                if not node.heap and not self._ended and not self.misfits:
                    continue
                job = self._job(node)
                if job is not None:
                    worked = True
                    yield node, job
            if not self.between_rounds() and not worked:
                return

    def _lazily(self, *, by_targets: bool = False) -> Iterator[_Turn]:
        """One job after the other, depth first, and whatever may have completed solutions; ends without any."""
        choice = DepthFirst([node for node, _ in self._round], self._job, by_targets=by_targets)
        while True:
            if choice.lift():
                self.settle()
                yield self.root, None
                continue
            turn = choice.job()
            if turn is not None:
                yield turn
            elif not self.between_rounds():
                return

    def _lazily_at_first(self, jobs: int) -> Iterator[_Turn]:
        """Depth first, until there is a whole solution or so many jobs were executed."""
        for turn in self._lazily(by_targets=True) if jobs else ():
            yield turn
            if self.jobs >= jobs or self.root.solutions or self.complete():
                return

    def _job(self, node: Node) -> Job | None:
        gates = self._gates[node]
        if gates and not all(gate.permits(child) for gate, child in gates):
            return None
        job = node.pick()
        if job is None and (self._ended or self.misfits):
            self.settle()
        return job

    def take_in(self, node: Node, job: Job, found: list[Answer], finished: bool, seconds: float) -> None:
        """Counts a job and gives its answers to its node."""
        self.jobs += 1
        node.statistics.calls += 1
        node.statistics.seconds += seconds
        self._ended += node.absorb(job, found, finished)
        self.settle()

    def settle(self) -> None:
        """Finds out what has died."""
        while self._ended or self.misfits:
            misfits, self.misfits = self.misfits, []
            for node, start, end, lane in misfits:
                self._ended += node.pair_closed(start, end, lane)
            ended, self._ended = self._ended, []
            reconsider(ended)

    def between_rounds(self) -> bool:
        """What no single job brings about: partners that will never come, generators to fall back on."""
        waiting: Ended = []
        for node in self._connectors:
            waiting += node.waiting()
        if waiting:
            alive = sum(state.alive[side] for state, side in waiting)
            reconsider(waiting)
            self.settle()
            if sum(state.alive[side] for state, side in waiting) < alive:
                return True
        given_up = advanced = False
        for serial in self._serials:
            given_up |= serial.give_up()
        if given_up:
            self.settle()
            return True
        for fallbacks in self._fallbacks:
            advanced |= fallbacks.advance()
        return advanced

    # ----------------------------------------------------------------------------------- rounds with workers
    def parallel_round(self, workers: "Workers", connector_jobs: int, most: int | None = None) -> bool:
        """One round whose jobs run side by side, or as much of it as `most` jobs are; False if nothing is left."""
        if self.exhausted:
            return False
        self._begin()
        self.exhausted = not self._side_by_side(workers, connector_jobs, most)
        self._torn = False
        return not self.exhausted

    def _side_by_side(self, workers: "Workers", connector_jobs: int, most: int | None) -> bool:
        if not self._left:
            self._left, self._worked = [node for node, _ in self._round], False
        taken = self._taken(connector_jobs, most)
        try:
            outcomes = workers.run(taken)
        except BaseException:
            self._put_back(taken)
            raise
        for (node, job), (found, finished, seconds) in zip(taken, outcomes, strict=True):
            self.take_in(node, job, found, finished, seconds)
        return bool(self._left) or self.between_rounds() or self._worked

    def _taken(self, connector_jobs: int, most: int | None) -> list[tuple[Node, Job]]:
        """The jobs of the rest of a round, or the first of them; what is behind them is left for the next call."""
        taken: list[tuple[Node, Job]] = []
        while self._left and (most is None or len(taken) < most):
            node = self._left.pop(0)
            if isinstance(node, SerialNode):
                self._worked |= node.lift()
                self.settle()
                continue
            wanted = connector_jobs if isinstance(node, ConnectorNode) else 1
            for _ in range(wanted if most is None else min(wanted, most - len(taken))):
                job = self._job(node)
                if job is None:
                    break
                taken.append((node, job))
        self._worked |= bool(taken)
        return taken
