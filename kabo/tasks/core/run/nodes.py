"""Nodes: the stages of one planning run, each with its queue of jobs [T 3.6].

A stage is structure and never changes; its node holds what one run knows about it: which states wait, which jobs
were asked how often, what failed. A job runs if the side that it does not compute is alive; else it is parked, until
that side revives. Of the jobs that wait, those asked less often come first, then those on longer, then on cheaper paths.
"""

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from heapq import heappop, heappush
from typing import TYPE_CHECKING, Any

from kabo.tasks.core.model.errors import UndefinedProperty
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.properties import Resolver
from kabo.tasks.core.model.results import Answer, Answers, Failure, Result
from kabo.tasks.core.model.solutions import LEFT, RIGHT, Solution, State
from kabo.tasks.core.model.stages import Stage
from kabo.tasks.core.run.graph import Level
from kabo.tasks.core.run.jobs import Job, job_seed, stage_seed

if TYPE_CHECKING:
    from kabo.tasks.core.run.planning import Planning

KEPT = 100  # failures that a stage keeps; all are counted
INFINITE = float("inf")


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
        self.kept = False  # a monitor waits for its successes, of use otherwise or not
        self._resolver = Resolver(stage.properties)
        self._seed = stage_seed(planning.seed, stage.path)
        self._jobs = 0

    # ---------------------------------------------------------------------------- what a run asks of a node
    def start(self) -> None:
        """Queues the first jobs, those of generators."""

    def take(self, state: State, side: int, lane: object) -> None:
        """A state came to one side of it."""
        raise NotImplementedError

    def rekey(self, state: State, side: int) -> None:
        """The best path to a state at that side became better."""

    def revived(self, state: State) -> None:
        """A state beside it is alive again on its far side."""

    def revived_inside(self, inner: State) -> None:
        """The same, of a state at its inner border."""

    def works_on(self, state: State, side: int) -> bool:
        """Whether something may still lead from the state through this node to `side`."""
        raise NotImplementedError

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether jobs that can run may add solutions from the state; what was found already does not count."""
        raise NotImplementedError

    def may_lead(self, inner: State, side: int) -> bool:
        """The same of a state inside, at its border."""
        return False

    def may_join(self, start: State, end: State, lane: object) -> bool:
        """The same of a pair of states; connecting."""
        raise NotImplementedError

    def partners(self, state: State, side: int) -> Iterable[State]:
        """The states on the other side with which it might be joined."""
        return ()

    def busy(self) -> bool:
        """Whether there are jobs in it that can run."""
        raise NotImplementedError

    def absorb(self, job: Job, found: list[Answer], finished: bool) -> None:
        """Takes in what a job found."""
        raise NotImplementedError

    def function(self) -> Callable[..., Answers]:
        """The stage function that its jobs call."""
        raise NotImplementedError

    # -------------------------------------------------------------------------------- what it says to others
    def may_solve(self) -> bool:
        """Whether it may still have successes: it is busy, or states, or pairs of them, may still come to it."""
        if self.busy():
            return True
        here = self
        while here.parent is not None:
            if here.parent.hands_on(here):
                return True
            here = here.parent
        return self.may_receive()

    def may_receive(self) -> bool:
        """Whether new states may still come to it; of pairs one, where the other one is there or may come too."""
        if self.closed:
            return False
        left = self.reads[LEFT] and self._delivered(LEFT)
        right = self.reads[RIGHT] and self._delivered(RIGHT)
        if self.flow is not Flow.CONNECT or left is right:
            return left or right
        return any(True for _ in self.came(RIGHT if left else LEFT))

    def _delivered(self, side: int) -> bool:
        if self.parent is not None and self.parent.level is self.level:
            return self.parent.delivers_to(self, side)
        return self.level.delivers(self.index if side == LEFT else self.index + 1, side)

    def came(self, side: int) -> Iterable[State]:
        """The states that came to that side so far; connecting."""
        raise NotImplementedError

    def hands_on(self, child: "Node") -> bool:
        """Whether it may still have a child begin, or try a pair, where another one gave nothing."""
        return False

    def child_solved(self, child: "Node", solution: Solution) -> None:
        """A child had a success."""
        raise NotImplementedError

    def works_at_border(self, state: State) -> bool:
        """Whether something may still leave it from a state at its inner border."""
        return False

    def border_delivers(self, side: int) -> bool:
        """Whether new states may still come in at its border."""
        return self.parent is not None and self.reads[side] and self.parent.delivers_to(self, side)

    def delivers_to(self, child: "Node", side: int) -> bool:
        """Whether new states may still come to that side of a child that shares its interfaces, or has its own."""
        return child.level.delivers(child.index if side == LEFT else child.index + 1, side)

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
    """A node with jobs of its own, for one subject each: in a heap those that wait, parked those that cannot run."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.jobs: dict[Any, Job] = {}
        self.heap: list[tuple[tuple[Any, ...], int, Job]] = []  # of jobs that wait, or are no more
        self.parked: dict[Any, Job] = {}

    def busy(self) -> bool:
        """Whether a job waits or runs."""
        return not self.closed and len(self.jobs) > len(self.parked)

    def queue(self, job: Job) -> None:
        """Puts a job in, at its present priority."""
        if len(self.jobs) == len(self.parked):
            self.planning.woken(self)
        self.jobs[job.subject] = job
        self.planning.changes += 1
        self.push(job)

    def push(self, job: Job) -> None:
        """Puts a job in its place, at its present priority; entries of former ones are passed over."""
        job.key = self.key(job)
        heappush(self.heap, (job.key, self.planning.count(), job))

    def rekey_jobs(self, jobs: Iterable[Job]) -> None:
        """Queues jobs again, at a better priority; parked ones have none."""
        for job in jobs:
            if job.subject not in self.parked:
                self.push(job)

    def unpark(self, jobs: Iterable[Job]) -> None:
        """Queues those of the jobs that were parked and can run again."""
        for job in jobs:
            if job.subject in self.parked and self.runnable(job):
                del self.parked[job.subject]
                self.planning.woken(self)
                self.push(job)

    def key(self, job: Job) -> tuple[Any, ...]:
        """What orders jobs; less is better, and it only gets less with time (but for being asked again)."""
        raise NotImplementedError

    def runnable(self, job: Job) -> bool:
        """Whether the side that the job does not compute is alive."""
        raise NotImplementedError

    def lane(self, job: Job) -> object:
        """The lane of a job: whose solutions it may add to."""
        raise NotImplementedError

    def cause(self, job: Job) -> Solution | None:
        """The success of another stage for which a job generates, if it is for one in particular."""
        return None

    def best(self) -> Job | None:
        """The best job that can run; those before it that cannot are parked."""
        while self.heap and not self.closed:
            key, _, job = self.heap[0]
            if job.key is key and self.jobs.get(job.subject) is job:
                if self.kept or not self.planning.pruning or self.runnable(job):
                    return job
                self.parked[job.subject] = job
                job.key = ()
                self.planning.rested(self, self.lane(job))
            heappop(self.heap)  # parked; or queued again at a better priority, or done meanwhile
        return None

    def pick(self) -> Job | None:
        """The same, taken out of the queue."""
        job = self.best()
        if job is not None:
            heappop(self.heap)
        return job

    def peek(self, place: int) -> Job | None:
        """A job that will be picked soon, as it seems, if all goes on as it is."""
        if place < len(self.heap):
            key, _, job = self.heap[place]
            if job.key is key and self.jobs.get(job.subject) is job and (self.kept or self.runnable(job)):
                return job
        return None

    def put_back(self, job: Job) -> None:
        """Queues a job again that was broken off; what it had given is passed over when it is called anew."""
        job.source = None
        self.planning.changes += 1
        self.push(job)

    def done(self, job: Job) -> None:
        """Nothing more comes of a job; looks again at the states that it kept alive."""
        raise NotImplementedError

    def absorb(self, job: Job, found: list[Answer], finished: bool) -> None:
        """Takes in what a job found; what has more to give is queued again, after those asked less often."""
        for answer in found:
            if isinstance(answer, Failure):
                self.fail(*self.ends(job), answer)
            else:
                self.solve(job, answer)
        if finished:
            self.jobs.pop(job.subject, None)
            self.done(job)
        elif not self.closed:
            job.asked += 1
            self.queue(job)
        self.planning.rested(self, self.lane(job))

    def ends(self, job: Job) -> tuple[State | None, State | None]:
        """The states of a job that a failure is shown with."""
        return None, None

    def solve(self, job: Job, result: Result) -> None:
        """Makes a solution of a job's result."""
        raise NotImplementedError
