"""Nodes: the stages of one planning run, each with its queue of jobs [T 3.6].

A stage is structure and never changes; its node holds what one run knows about it: which states wait, which jobs
were asked how often, what failed. A job runs if the side that it does not compute is alive. Of the jobs that wait,
those asked less often come first, then those on longer, then on cheaper paths.
"""

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from heapq import heappop, heappush
from typing import TYPE_CHECKING, Any

from kabo.tasks.core.errors import UndefinedProperty
from kabo.tasks.core.flow import Flow
from kabo.tasks.core.graph import Level
from kabo.tasks.core.jobs import Job, job_seed, stage_seed
from kabo.tasks.core.properties import Resolver
from kabo.tasks.core.results import Answer, Answers, Failure, Result
from kabo.tasks.core.solutions import LEFT, RIGHT, Solution, State
from kabo.tasks.core.stages import Stage

if TYPE_CHECKING:
    from kabo.tasks.core.planning import Planning

KEPT = 100  # failures that a stage keeps; all are counted
INFINITE = float("inf")
Ended = list[tuple[State, int]]  # states, and the side on which something may have died


@dataclass
class StageStatistics:
    """What a stage did in one run: jobs, their seconds, successes with their costs, failures by reason."""

    calls: int = 0
    seconds: float = 0.0
    successes: int = 0
    failures: Counter[str] = field(default_factory=Counter)
    mismatches: Counter[str] = field(default_factory=Counter)
    costs: list[float] = field(default_factory=list)


class Node:
    """A stage in one planning run."""

    def __init__(
        self, stage: Stage, planning: "Planning", parent: "Node | None", level: Level, index: int
    ) -> None:
        self.stage = stage
        self.planning = planning
        self.parent = parent
        self.level = level  # where its solutions are edges
        self.index = index
        self.flow: Flow = planning.flows[stage]
        self.reads = (self.flow.reads_start, self.flow.reads_end)  # whether states come to it, by side
        self.children: list[Node] = []
        self.statistics = StageStatistics()
        self.failures: list[Solution] = []
        self.solutions: list[Solution] = []
        self.monitors: list[Node] = []
        self.closed = False  # a limit is reached: nothing more is wanted of it
        self.heap: list[tuple[tuple[Any, ...], int, Job]] = []  # jobs that wait, or are no more; of leaves
        self.kept = False  # a monitor waits for its successes, of use otherwise or not
        self._resolver = Resolver(stage.properties)
        self._seed = stage_seed(planning.seed, stage.path)
        self._jobs = 0

    # ---------------------------------------------------------------------------- what a run asks of a node
    def start(self) -> None:
        """May begin: generators have their first job."""

    def take(self, state: State, side: int, lane: object) -> None:
        """A state came to one side of it."""
        raise NotImplementedError

    def rekey(self, state: State, side: int) -> None:
        """The best path to a state at that side became better."""

    def works_on(self, state: State, side: int) -> bool:
        """Whether something may still lead from the state through this node to `side`."""
        raise NotImplementedError

    def may_add(self, state: State, side: int) -> bool:
        """Whether new solutions may still come of the state; what was found already does not count."""
        return self.works_on(state, side)

    def may_lead(self, inner: State, side: int) -> bool:
        """The same of a state inside, at its border."""
        return False

    def partners(self, state: State, side: int) -> Iterable[State]:
        """The states on the other side with which it might be joined."""
        return ()

    def busy(self) -> bool:
        """Whether there are jobs left in it."""
        raise NotImplementedError

    def pick(self) -> Job | None:
        """Its best job, taken out of the queue; None if there is none that may run."""
        return None

    def put_back(self, job: Job) -> None:
        """Queues a job again that was taken out and not run to an end."""
        raise NotImplementedError

    def cause(self, job: Job) -> Solution | None:
        """The success of another stage for which a job generates, if it is for one in particular."""
        return None

    def absorb(self, job: Job, found: list[Answer], finished: bool) -> Ended:
        """Takes in what a job found."""
        raise NotImplementedError

    def function(self) -> Callable[..., Answers]:
        """The stage function that its jobs call."""
        raise NotImplementedError

    # -------------------------------------------------------------------------------- what it says to others
    def may_solve(self) -> bool:
        """Whether it may still have successes: it is busy, or states may still come to it."""
        if self.busy():
            return True
        from_left = self.reads[LEFT] and self.level.delivers(self.index, LEFT, None)
        return from_left or (self.reads[RIGHT] and self.level.delivers(self.index + 1, RIGHT, None))

    def finished(self, state: State, side: int, lane: object) -> Ended:
        """Its work on a state towards `side` is done; says what may have died of it."""
        return [] if self.parent is None else self.parent.child_finished(self, state, side, lane)

    def child_finished(self, child: "Node", state: State, side: int, lane: object) -> Ended:
        """The same, of a child."""
        return [(state, side)]

    def child_solved(self, child: "Node", solution: Solution) -> None:
        """A child had a success."""
        raise NotImplementedError

    def works_at_border(self, state: State) -> bool:
        """Whether something may still leave it from a state at its inner border."""
        return False

    def border_delivers(self, side: int, lane: object) -> bool:
        """Whether new states may still come in at its border."""
        if self.parent is None or not self.reads[side]:
            return False
        return self.parent.delivers_to(self, side, lane)

    def delivers_to(self, child: "Node", side: int, lane: object) -> bool:
        """Whether new states may still come to that side of a child that shares its interfaces, or has its own."""
        return child.level.delivers(child.index if side == LEFT else child.index + 1, side, lane)

    def report(self, solution: Solution) -> bool:
        """Counts a solution after its cost term had its say, and hands a success to the parent; False: a failure."""
        term = self.stage.cost
        if term is not None and not solution.failed:
            answer = term(solution)
            cost, comment = answer if isinstance(answer, tuple) else (answer, "")
            solution.cost = float(cost)
            solution.comment = ", ".join(text for text in (solution.comment, comment) if text)
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

    def fail(self, start: State | None, end: State | None, failure: Failure) -> None:
        """Counts a failure, and keeps it while there are few."""
        self.statistics.failures[failure.reason] += 1
        if self.planning.observe is not None:
            self.planning.observe(self.stage, failure)
        if len(self.failures) < KEPT:
            self.failures.append(
                Solution(
                    self.stage,
                    start,
                    end,
                    INFINITE,
                    failure.comment,
                    reason=failure.reason,
                    details=failure.details,
                )
            )

    def keep(self) -> None:
        """Nothing that leads to its successes may be pruned: a monitor waits for them."""
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
            node.keep()

    # -------------------------------------------------------------------------------------------- for all
    def new_state(self, scene: Any, properties: Any, lane: object = None) -> State:
        """A state that nobody knows yet."""
        return State(scene, properties, self.planning.count(), lane)

    def arguments(self, scenes: tuple[Any, ...], *interfaces: Any) -> tuple[Any, ...] | UndefinedProperty:
        """The arguments of a new job; or the error, if an interface state lacks a property."""
        try:
            values = self._resolver.values(*interfaces)
        except UndefinedProperty as error:
            return error
        self._jobs += 1
        return (*scenes, values, job_seed(self._seed, self._jobs))

    def solution(
        self, start: State | None, end: State | None, result: Result, parts: tuple[Solution, ...] = ()
    ) -> Solution:
        """A solution of its stage."""
        number = self.planning.count()
        return Solution(self.stage, start, end, result.cost, result.comment, result.motion, parts, number)


class Leaf(Node):
    """A node with jobs of its own, for one subject each, in a heap."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.jobs: dict[Any, Job] = {}

    def busy(self) -> bool:
        """Whether a job waits or runs."""
        return not self.closed and bool(self.jobs)

    def queue(self, job: Job) -> None:
        """Puts a job in, at its present priority."""
        self.jobs[job.subject] = job
        self.push(job)

    def push(self, job: Job) -> None:
        """Puts a job in its place, at its present priority; entries of former ones are passed over."""
        job.key = self.key(job)
        heappush(self.heap, (job.key, self.planning.count(), job))

    def key(self, job: Job) -> tuple[Any, ...]:
        """What orders jobs; less is better, and it only gets less with time (but for being asked again)."""
        raise NotImplementedError

    def runnable(self, job: Job) -> bool:
        """Whether the side that the job does not compute is alive."""
        raise NotImplementedError

    def pick(self) -> Job | None:
        """The best job that may run; those that no longer may are dropped for good."""
        if self.closed:
            return None
        while self.heap:
            key, _, job = heappop(self.heap)
            if job.key is not key or self.jobs.get(job.subject) is not job:
                continue  # queued again at a better priority, or done meanwhile
            if self.planning.pruning and not self.kept and not self.runnable(job):
                del self.jobs[job.subject]
                self.planning.ended(self.dropped(job))
                continue
            return job
        return None

    def put_back(self, job: Job) -> None:
        """Queues it again; what it had given is passed over when its function is called anew."""
        job.source = None
        self.push(job)

    def dropped(self, job: Job) -> Ended:
        """What may have died with a job that will not be run, or is done."""
        raise NotImplementedError

    def absorb(self, job: Job, found: list[Answer], finished: bool) -> Ended:
        """Takes in what a job found; what has more to give is queued again, after those asked less often."""
        for answer in found:
            if isinstance(answer, Failure):
                self.fail(*self.ends(job), answer)
            else:
                self.solve(job, answer)
        if not finished:
            job.asked += 1
            self.queue(job)
            return []
        self.jobs.pop(job.subject, None)
        return self.dropped(job)

    def ends(self, job: Job) -> tuple[State | None, State | None]:
        """The states of a job that a failure is shown with."""
        return None, None

    def solve(self, job: Job, result: Result) -> None:
        """Makes a solution of a job's result."""
        raise NotImplementedError
