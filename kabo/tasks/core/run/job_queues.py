"""Nodes with jobs of their own: a queue of waiting jobs, and parked jobs, which cannot run at present [T 3.6]."""

from collections.abc import Iterable
from heapq import heappop, heappush
from typing import Any

from kabo.tasks.core.model.results import Answer, Result
from kabo.tasks.core.model.solutions import Solution, State
from kabo.tasks.core.run.jobs import StageJob
from kabo.tasks.core.run.nodes import StageNode


class Leaf(StageNode):
    """A node with jobs of its own, one for each subject.

    `heap` is their queue, `parked` has the jobs that cannot run now.
    """

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
        """Adds a job to the queue, or puts it back into the queue, at its present priority."""
        if len(self.jobs) == len(self.parked):
            self.planning.has_work_again(self)
        self.jobs[job.subject] = job
        self.planning.changes += 1
        self.push(job)

    def push(self, job: StageJob) -> None:
        """Pushes a job onto the heap at its present priority.

        Older heap entries of the same job become invalid.
        """
        job.key = self.key(job)
        heappush(self.heap, (job.key, self.planning.count(), job))

    def rekey_jobs(self, jobs: Iterable[StageJob]) -> None:
        """Pushes jobs onto the heap again after their priority has improved; parked jobs are skipped."""
        for job in jobs:
            if job.subject not in self.parked:
                self.push(job)

    def unpark(self, jobs: Iterable[StageJob]) -> None:
        """Queues those of the given jobs again that were parked and can now run."""
        for job in jobs:
            if job.subject in self.parked and self.runnable(job):
                del self.parked[job.subject]
                self.planning.has_work_again(self)
                self.push(job)

    def key(self, job: StageJob) -> tuple[Any, ...]:
        """The sort key of a job; jobs with smaller keys run first.

        A job's key increases only when the job has run.
        """
        raise NotImplementedError

    def runnable(self, job: StageJob) -> bool:
        """Whether the job can run: the states that it reads are alive on the sides that it does not compute."""
        raise NotImplementedError

    def lane(self, job: StageJob) -> object:
        """The lane to whose solutions the job may add; None if the job may add to those of all lanes."""
        raise NotImplementedError

    def cause(self, job: StageJob) -> Solution | None:
        """The solution of a monitored stage that triggered the job; None if no solution did."""
        return None

    def best(self) -> StageJob | None:
        """The best runnable job, which stays in the queue; better jobs that cannot run are parked.

        The result is None if none can run.
        """
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
        """The best runnable job, removed from the queue; None if no job can run."""
        job = self.best()
        if job is not None:
            heappop(self.heap)
        return job

    def peek(self, place: int) -> StageJob | None:
        """The job at a place in the heap, near the front of the queue.

        The result is None if there is no runnable job at that place.
        """
        if place < len(self.heap):
            key, _, job = self.heap[place]
            if job.key is key and self.jobs.get(job.subject) is job and (self.kept or self.runnable(job)):
                return job
        return None

    def put_back(self, job: StageJob) -> None:
        """Requeues a job that an error interrupted; its next run skips the answers that were already recorded."""
        job.source = None
        self.planning.changes += 1
        self.push(job)

    def done(self, job: StageJob) -> None:
        """Ends a job that has no more answers, and requests a recheck of the states that the job kept alive."""
        raise NotImplementedError

    def absorb(self, job: StageJob, found: list[Answer], finished: bool) -> None:
        """Records the answers of a job.

        A job that may have more is queued again, behind jobs that have run less often.
        """
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
        """The start and end states of a recorded failure of the job.

        A state is None on a side that the job would have computed.
        """
        return None, None

    def solve(self, job: StageJob, result: Result) -> None:
        """Turns a job's result into a solution."""
        raise NotImplementedError
