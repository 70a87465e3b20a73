"""Nodes with jobs of their own: a queue of those that wait, and those that are parked while they cannot run [T 3.6]."""

from collections.abc import Iterable
from heapq import heappop, heappush
from typing import Any

from kabo.tasks.core.model.results import Answer, Result
from kabo.tasks.core.model.solutions import Solution, State
from kabo.tasks.core.run.jobs import StageJob
from kabo.tasks.core.run.nodes import StageNode


class Leaf(StageNode):
    """A node with jobs of its own, one for each subject; `heap` is the queue, `parked` holds those that cannot run now."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.jobs: dict[Any, StageJob] = {}
        # (key, number, job); some entries are outdated.
        self.heap: list[tuple[tuple[Any, ...], int, StageJob]] = []
        self.parked: dict[Any, StageJob] = {}

    def busy(self) -> bool:
        """Whether this node has a job that is not parked."""
        return not self.closed and len(self.jobs) > len(self.parked)

    def queue(self, job: StageJob) -> None:
        """Adds a job, or puts one back, at its present priority."""
        if len(self.jobs) == len(self.parked):
            self.planning.has_work_again(self)
        self.jobs[job.subject] = job
        self.planning.changes += 1
        self.push(job)

    def push(self, job: StageJob) -> None:
        """Pushes a job at its present priority; older entries of the same job become invalid."""
        job.key = self.key(job)
        heappush(self.heap, (job.key, self.planning.count(), job))

    def rekey_jobs(self, jobs: Iterable[StageJob]) -> None:
        """Pushes jobs again after their priority has become better; parked jobs are left out."""
        for job in jobs:
            if job.subject not in self.parked:
                self.push(job)

    def unpark(self, jobs: Iterable[StageJob]) -> None:
        """Queues those of the jobs that are parked and can run again."""
        for job in jobs:
            if job.subject in self.parked and self.runnable(job):
                del self.parked[job.subject]
                self.planning.has_work_again(self)
                self.push(job)

    def key(self, job: StageJob) -> tuple[Any, ...]:
        """The sort key of a job, less is better; it only decreases, unless the job was run."""
        raise NotImplementedError

    def runnable(self, job: StageJob) -> bool:
        """Whether the state that the job starts from is alive on the side that the job does not compute."""
        raise NotImplementedError

    def lane(self, job: StageJob) -> object:
        """The lane whose solutions the job may add to; None: all lanes."""
        raise NotImplementedError

    def cause(self, job: StageJob) -> Solution | None:
        """The solution of a monitored stage that triggered the job; None if nothing did."""
        return None

    def best(self) -> StageJob | None:
        """The best runnable job, left in the queue; better jobs that cannot run are parked."""
        while self.heap and not self.closed:
            key, _, job = self.heap[0]
            if job.key is key and self.jobs.get(job.subject) is job:
                if self.kept or not self.planning.pruning or self.runnable(job):
                    return job
                self.parked[job.subject] = job
                job.key = ()
                self.planning.work_changed(self, self.lane(job))
            heappop(self.heap)  # the job was parked, or the entry is outdated
        return None

    def pick(self) -> StageJob | None:
        """The best runnable job, taken out of the queue."""
        job = self.best()
        if job is not None:
            heappop(self.heap)
        return job

    def peek(self, place: int) -> StageJob | None:
        """A job near the front of the queue that will probably be picked soon; None if there is none at that place."""
        if place < len(self.heap):
            key, _, job = self.heap[place]
            if job.key is key and self.jobs.get(job.subject) is job and (self.kept or self.runnable(job)):
                return job
        return None

    def put_back(self, job: StageJob) -> None:
        """Queues a job again that an error broke off; when called anew it skips the answers that it has given already."""
        job.source = None
        self.planning.changes += 1
        self.push(job)

    def done(self, job: StageJob) -> None:
        """Ends a job that has no more answers, and has the states rechecked that it kept alive."""
        raise NotImplementedError

    def absorb(self, job: StageJob, found: list[Answer], finished: bool) -> None:
        """Records the answers of a job; a job with more to give is queued again, after those that have run less often."""
        for answer in found:
            if isinstance(answer, Result):
                self.solve(job, answer)
            else:
                self.fail(*self.ends(job), answer)
        if finished:
            self.jobs.pop(job.subject, None)
            self.done(job)
        elif not self.closed:
            job.asked += 1
            self.queue(job)
        self.planning.work_changed(self, self.lane(job))

    def ends(self, job: StageJob) -> tuple[State | None, State | None]:
        """The states between which a failure of the job is recorded; None for a side that the job would have computed."""
        return None, None

    def solve(self, job: StageJob, result: Result) -> None:
        """Makes a solution of a result."""
        raise NotImplementedError
