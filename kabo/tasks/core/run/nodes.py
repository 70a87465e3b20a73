"""Nodes, which hold the data of one planning run about each stage, and the states between stages [T 3.6].

A stage never changes during planning; its node holds the states that have arrived, its jobs, solutions and
failures. A job can run if the state that it reads is alive (may still become part of a whole solution) on the side
that the job does not compute; else it is parked until the state is alive again. Jobs that have run less often come
first; of those, jobs on longer paths; of those, jobs on cheaper paths.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from kabo.tasks.core.model.costs import told
from kabo.tasks.core.model.errors import UndefinedProperty
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.properties import PropertyResolver
from kabo.tasks.core.model.results import Answer, Answers, Failure, Refused, Result
from kabo.tasks.core.model.solutions import LEFT, RIGHT, Solution, State
from kabo.tasks.core.model.stages import Stage
from kabo.tasks.core.run.graph import meet, relax
from kabo.tasks.core.run.jobs import StageJob, job_seed, stage_seed

MAX_KEPT_FAILURES = 100  # failures of one stage that are kept for explanations; all are counted
INFINITE = float("inf")


@dataclass
class StageStatistics:
    """The figures of a stage in one run: jobs and their seconds, successes and costs, failures and mismatches by reason."""

    calls: int = 0
    seconds: float = 0.0
    successes: int = 0
    failures: Counter[str] = field(default_factory=Counter)
    mismatches: Counter[str] = field(default_factory=Counter)
    costs: list[float] = field(default_factory=list)


class Scheduler(Protocol):
    """The interface of the scheduler to the nodes of its planning run."""

    flows: Mapping[Stage, Flow]
    scene: Any
    seed: int
    pruning: bool
    observe: Callable[[Stage, Refused], None] | None
    count: Callable[[], int]  # the next number, for whatever must keep its order of arrival
    changes: int  # counts changes that may let a job run, or a solution be lifted
    asked: "set[StageNode]"  # monitoring generators that are finding out whether more may come
    order: "list[StageNode]"  # children before their containers, else in order of time

    def recheck(self, state: State, side: int) -> None:
        """Requests that, after the present job, it is updated whether a state is alive on `side`."""
        ...

    def work_changed(self, node: "StageNode", lane: object) -> None:
        """Reports that a node's job ran or was parked, or that it got a solution from a complete path.

        Args:
            node: the node.
            lane: the lane to which the change is confined; None: any lane may be affected.
        """
        ...

    def has_work_again(self, node: "StageNode") -> None:
        """Reports that a node which had no runnable jobs has runnable jobs again."""
        ...


class StageNode:
    """The data of a stage in one planning run: its states, jobs, solutions and failures."""

    def __init__(
        self, stage: Stage, planning: Scheduler, parent: "StageNode | None", level: "Level", index: int
    ) -> None:
        self.stage = stage
        self.planning = planning
        self.parent = parent
        self.level = level  # where its solutions are edges
        self.index = index
        self.flow: Flow = planning.flows[stage]
        self.reads = (self.flow.reads_start, self.flow.reads_end)  # whether states come to it, by side
        self.children: list[StageNode] = []
        self.statistics = StageStatistics()
        self.failures: list[Solution] = []
        self.solutions: list[Solution] = []
        self.monitors: list[StageNode] = []
        self.closed = False  # a limit is reached: it runs no more jobs
        self.kept = False  # exempt from pruning, because a monitoring generator waits for its solutions
        self._resolver = PropertyResolver(stage.properties)
        self._seed = stage_seed(planning.seed, stage.path)
        self._jobs = 0

    # ---------------------------------------------------------------------------- what a run asks of a node
    def start(self) -> None:
        """Queues the initial jobs; only generators have any."""

    def take(self, state: State, side: int, lane: object) -> None:
        """Receives a state that arrives at `side` of the stage, in a lane or in none (None)."""
        raise NotImplementedError

    def rekey(self, state: State, side: int) -> None:
        """Updates the priority of jobs that read a state at `side`, to which a better path was found."""

    def revived(self, state: State) -> None:
        """Queues parked jobs again that read the state, because the state is alive again."""

    def revived_inside(self, inner: State) -> None:
        """Queues parked jobs again that depend on `inner`, a state inside this node that is alive again."""

    def works_on(self, state: State, side: int) -> bool:
        """Whether something may still lead from the state through this node to `side`."""
        raise NotImplementedError

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether runnable jobs may still add further solutions from the state."""
        raise NotImplementedError

    def may_lead(self, inner: State, side: int) -> bool:
        """Whether runnable jobs may still add solutions of this node through `inner`, a state at its border."""
        return False

    def may_join(self, start: State, end: State, lane: object) -> bool:
        """Whether runnable jobs may still join the two states in the lane; called only for nodes that connect."""
        raise NotImplementedError

    def partners(self, state: State, side: int) -> Iterable[State]:
        """The states on `side` that the given state may still be joined with; empty unless the node connects."""
        return ()

    def busy(self) -> bool:
        """Whether this node has runnable jobs."""
        raise NotImplementedError

    def absorb(self, job: StageJob, found: list[Answer], finished: bool) -> None:
        """Records the answers of a job of this node; `finished` says that they are the last."""
        raise NotImplementedError

    def function(self) -> Callable[..., Answers]:
        """The stage function that the jobs of this node call."""
        raise NotImplementedError

    # -------------------------------------------------------------------------------- what it says to others
    def may_solve(self) -> bool:
        """Whether this node may still have solutions: it is busy, or states or pairs of states may still come to it."""
        if self.busy():
            return True
        here = self
        while here.parent is not None:
            if here.parent.may_pass_on(here):
                return True
            here = here.parent
        return self.may_receive()

    def may_receive(self) -> bool:
        """Whether new states, or for a connector new pairs of states, may still come to this node."""
        if self.closed:
            return False
        left = self.reads[LEFT] and self._delivered(LEFT)
        right = self.reads[RIGHT] and self._delivered(RIGHT)
        if self.flow is not Flow.CONNECT or left is right:
            return left or right
        return any(True for _ in self.arrived(RIGHT if left else LEFT))

    def _delivered(self, side: int) -> bool:
        if self.parent is not None and self.parent.level is self.level:
            return self.parent.delivers_to(self, side)
        return self.level.delivers(self.index if side == LEFT else self.index + 1, side)

    def arrived(self, side: int) -> Iterable[State]:
        """The states that have arrived on `side` so far; called only for nodes that connect."""
        raise NotImplementedError

    def may_pass_on(self, child: "StageNode") -> bool:
        """Whether this node may still start the child, or give it a pair of states, if an earlier child fails."""
        return False

    def child_solved(self, child: "StageNode", solution: Solution) -> None:
        """Receives a new solution of a child."""
        raise NotImplementedError

    def works_at_border(self, state: State) -> bool:
        """Whether a child's solution at `state`, on the border inside this node, waits to be transformed."""
        return False

    def border_delivers(self, side: int) -> bool:
        """Whether new states may still arrive from outside at the border on `side` of this node."""
        return self.parent is not None and self.reads[side] and self.parent.delivers_to(self, side)

    def delivers_to(self, child: "StageNode", side: int) -> bool:
        """Whether new states may still come to `side` of a child."""
        return child.level.delivers(child.index if side == LEFT else child.index + 1, side)

    def report(self, solution: Solution) -> bool:
        """Applies the cost term to a solution, and records and passes on the solution.

        Returns False if the solution became a failure.
        """
        term = self.stage.cost
        if term is not None and not solution.failed:
            cost, comment, details = told(term(solution))
            solution.cost = float(cost)
            solution.comment = ", ".join(text for text in (solution.comment, comment) if text)
            solution.details = solution.details if details is None else details
        if not solution.cost < INFINITE:
            comment = solution.comment or (
                "infinite cost" if solution.cost == INFINITE else "the cost is no number"
            )
            self.fail(solution.start, solution.end, Failure("cost", comment))
            return False
        self.statistics.successes += 1
        self.statistics.costs.append(solution.cost)
        self.solutions.append(solution)
        if self.parent is not None:
            self.parent.child_solved(self, solution)
        for monitor in self.monitors:
            monitor.trigger(solution)  # type: ignore[attr-defined]
        return True

    def fail(self, start: State | None, end: State | None, failure: Refused) -> None:
        """Counts a failure; the first `MAX_KEPT_FAILURES` are kept for explanations, with their details."""
        self.statistics.failures[failure.reason] += 1
        if self.planning.observe is not None:
            self.planning.observe(self.stage, failure)
        if len(self.failures) < MAX_KEPT_FAILURES:
            self.failures.append(
                Solution(
                    self.stage,
                    start,
                    end,
                    INFINITE,
                    failure.comment,
                    reason=failure.reason,
                    details=failure.details if isinstance(failure, Failure) else failure,
                )
            )

    def exempt_from_pruning(self) -> None:
        """Exempts this node, and all nodes that it depends on, from pruning, for a monitoring generator."""
        if self.kept:
            return
        self.kept = True
        beside = [child for child in self.children if child.level is self.level]
        if self.parent is not None and self.parent.level is self.level:
            beside.append(self.parent)
        if self.reads[LEFT]:
            beside.append(self.level.children[self.index - 1] if self.index else self.level.owner)
        if self.reads[RIGHT]:
            last = self.index + 1 == len(self.level.children)
            beside.append(self.level.owner if last else self.level.children[self.index + 1])
        for node in beside:
            node.exempt_from_pruning()

    # -------------------------------------------------------------------------------------------- for all
    def new_state(self, scene: Any, properties: Any, lane: object = None) -> State:
        """A new state with the next free number; it is not yet part of the graph."""
        return State(scene, properties, self.planning.count(), lane)

    def arguments(self, scenes: tuple[Any, ...], *interfaces: Any) -> tuple[Any, ...] | UndefinedProperty:
        """The arguments of a new job: scenes, property values, seed.

        If an interface state lacks a property that is referred to, the error is returned instead.
        """
        try:
            values = self._resolver.values(*interfaces)
        except UndefinedProperty as error:
            return error
        self._jobs += 1
        return (*scenes, values, job_seed(self._seed, self._jobs))

    def solution(
        self, start: State | None, end: State | None, result: Result, parts: tuple[Solution, ...] = ()
    ) -> Solution:
        """A new solution of this node's stage between two states, with a result's cost, comment and motion."""
        number, details = self.planning.count(), result.details
        cost, comment, motion = result.cost, result.comment, result.motion
        return Solution(self.stage, start, end, cost, comment, motion, parts, number, details=details)


class Level:
    """The states between the children of one container, or beside the child of a wrapper, and their solutions."""

    def __init__(self, owner: StageNode) -> None:
        self.owner = owner
        self.children: list[StageNode] = []
        self.top = False  # whether this is the task's own level: its borders are the goal

    # --------------------------------------------------------------------------------------------- growing
    def enter(self, outer: State, side: int, number: int, lane: object) -> State:
        """Creates the inner counterpart of a state that arrives at the border."""
        inner = State(outer.scene, outer.properties, number, lane)
        inner.level, inner.announced = self, True
        inner.position = 0 if side == LEFT else len(self.children)
        inner.outside.append(outer)
        outer.inside.append(inner)
        near = outer.best[side]
        inner.reached(side, (0, near[0] + near[1], near[2]))
        inner.alive[side] = outer.alive[side] or self.owner.kept
        self.owner.planning.recheck(inner, 1 - side)
        self.owner.planning.recheck(outer, 1 - side)
        return inner

    def add(self, solution: Solution, index: int) -> None:
        """Adds a solution of the child at `index`; new states go to the neighbouring children."""
        start, end = solution.start, solution.end
        if start is None or end is None:
            raise ValueError("a success has a state on both sides")
        for state, position in ((start, index), (end, index + 1)):
            if state.level is None:
                state.level, state.position = self, position
        start.edges[RIGHT].append(solution)
        end.edges[LEFT].append(solution)
        relax([(start, end, solution.cost, LEFT), (end, start, solution.cost, RIGHT)])
        for state, side in ((start, LEFT), (end, RIGHT)):
            far = 1 - side
            if not state.announced:
                state.announced = True
                neighbour = self.neighbour(state, side)
                if neighbour is not None and neighbour.reads[far]:
                    neighbour.take(state, far, state.lane)
                self.owner.planning.recheck(state, side)
            other = end if state is start else start
            if state.alive[far] != other.alive[far]:
                self.owner.planning.recheck(state, far)

    def neighbour(self, state: State, side: int) -> StageNode | None:
        """The child on `side` of a state; None if the container's border is there."""
        k = state.position if side == RIGHT else state.position - 1
        return self.children[k] if 0 <= k < len(self.children) else None

    def at_border(self, state: State, side: int) -> bool:
        """Whether the state lies at the container's border on `side`."""
        return state.position == (0 if side == LEFT else len(self.children))

    def complete(self, state: State, side: int) -> bool:
        """Whether solutions of the children form a path between the container's border on `side` and the state."""
        needed = state.position if side == LEFT else len(self.children) - state.position
        return state.best[side][0] == needed

    # --------------------------------------------------------------------------------------------- support
    def supported(self, state: State, side: int) -> bool:
        """Whether the state may still be extended towards `side`, apart from the solutions that there are."""
        neighbour = self.neighbour(state, side)
        if neighbour is not None:
            if neighbour.reads[1 - side]:
                return neighbour.works_on(state, side)
            # A container wrote the state: there may be more paths through that container.
            return any(inner.alive[side] for inner in state.inside if inner.level.at_border(inner, 1 - side))
        if self.top or self.owner.kept or not state.outside or self.owner.works_at_border(state):
            return True
        return any(outer.alive[side] for outer in state.outside)

    def _may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether the neighbour on that side may still add solutions from the state."""
        neighbour = self.neighbour(state, side)
        if neighbour is None:
            return False
        if neighbour.reads[1 - side]:
            return neighbour.may_add(state, side, lane)
        written = (inner for inner in state.inside if inner.level.at_border(inner, 1 - side))
        return any(inner.level.owner.may_lead(inner, side) for inner in written)

    def may_extend(self, state: State, side: int) -> bool:
        """Whether a child may still extend paths from the state towards `side`, within the state's lane."""
        seen, waiting = {state}, [state]
        while waiting:
            here = waiting.pop()
            if self._may_add(here, side, state.lane):
                return True
            for edge in here.edges[side]:
                far = edge.end if side == RIGHT else edge.start
                if far is not None and far not in seen and meet(far.lane, state.lane):
                    seen.add(far)
                    waiting.append(far)
        return False

    def delivers(self, position: int, side: int) -> bool:
        """Whether new states may still come to a position between the children from `side`."""
        k, step = (position, 1) if side == RIGHT else (position - 1, -1)
        while 0 <= k < len(self.children):
            child = self.children[k]
            if child.reads[1 - side]:
                return False
            if child.busy():
                return True
            if not child.reads[side]:
                return False
            k += step
        return self.owner.border_delivers(side)
