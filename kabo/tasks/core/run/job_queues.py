"""Nodes that run jobs of their own: the queue of those that wait, and those parked until a state is alive again [T 3.6]."""

from collections.abc import Iterable
from heapq import heappop, heappush
from typing import Any

from kabo.tasks.core.model.results import Answer, Failure, Result
from kabo.tasks.core.model.solutions import Solution, State
from kabo.tasks.core.run.jobs import StageJob
from kabo.tasks.core.run.nodes import StageNode


class Leaf(StageNode):
    """A node with jobs of its own, for one subject each: in a heap those that wait, parked those that cannot run."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.jobs: dict[Any, StageJob] = {}
        self.heap: list[tuple[tuple[Any, ...], int, StageJob]] = []  # of jobs that wait, or are no more
        self.parked: dict[Any, StageJob] = {}

    def busy(self) -> bool:
        """Whether a job waits or runs."""
        return not self.closed and len(self.jobs) > len(self.parked)

    def queue(self, job: StageJob) -> None:
        """Puts a job in, at its present priority."""
        if len(self.jobs) == len(self.parked):
            self.planning.woken(self)
        self.jobs[job.subject] = job
        self.planning.changes += 1
        self.push(job)

    def push(self, job: StageJob) -> None:
        """Puts a job in its place, at its present priority; entries of former ones are passed over."""
        job.key = self.key(job)
        heappush(self.heap, (job.key, self.planning.count(), job))

    def rekey_jobs(self, jobs: Iterable[StageJob]) -> None:
        """Queues jobs again, at a better priority; parked ones have none."""
        for job in jobs:
            if job.subject not in self.parked:
                self.push(job)

    def unpark(self, jobs: Iterable[StageJob]) -> None:
        """Queues those of the jobs that were parked and can run again."""
        for job in jobs:
            if job.subject in self.parked and self.runnable(job):
                del self.parked[job.subject]
                self.planning.woken(self)
                self.push(job)

    def key(self, job: StageJob) -> tuple[Any, ...]:
        """What orders jobs; less is better, and it only gets less with time (but for being asked again)."""
        raise NotImplementedError

    def runnable(self, job: StageJob) -> bool:
        """Whether the side that the job does not compute is alive."""
        raise NotImplementedError

    def lane(self, job: StageJob) -> object:
        """The lane of a job: whose solutions it may add to."""
        raise NotImplementedError

    def cause(self, job: StageJob) -> Solution | None:
        """The success of another stage for which a job generates, if it is for one in particular."""
        return None

    def best(self) -> StageJob | None:
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

    def pick(self) -> StageJob | None:
        """The same, taken out of the queue."""
        job = self.best()
        if job is not None:
            heappop(self.heap)
        return job

    def peek(self, place: int) -> StageJob | None:
        """A job that will be picked soon, as it seems, if all goes on as it is."""
        if place < len(self.heap):
            key, _, job = self.heap[place]
            if job.key is key and self.jobs.get(job.subject) is job and (self.kept or self.runnable(job)):
                return job
        return None

    def put_back(self, job: StageJob) -> None:
        """Queues a job again that was broken off; what it had given is passed over when it is called anew."""
        job.source = None
        self.planning.changes += 1
        self.push(job)

    def done(self, job: StageJob) -> None:
        """Nothing more comes of a job; looks again at the states that it kept alive."""
        raise NotImplementedError

    def absorb(self, job: StageJob, found: list[Answer], finished: bool) -> None:
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

    def ends(self, job: StageJob) -> tuple[State | None, State | None]:
        """The states of a job that a failure is shown with."""
        return None, None

    def solve(self, job: StageJob, result: Result) -> None:
        """Makes a solution of a job's result."""
        raise NotImplementedError
