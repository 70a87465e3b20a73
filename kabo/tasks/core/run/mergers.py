"""The node of mergers: solutions of all children from the same state are combined [T 3.3]."""

from collections.abc import Callable
from itertools import product
from typing import Any

from kabo.tasks.core.model.containers import Merger
from kabo.tasks.core.model.flow import Flow
from kabo.tasks.core.model.results import Answers, Result
from kabo.tasks.core.model.solutions import LEFT, RIGHT, Solution, State
from kabo.tasks.core.run.groups import ParallelNode
from kabo.tasks.core.run.job_queues import Leaf
from kabo.tasks.core.run.jobs import StageJob
from kabo.tasks.core.run.nodes import StageNode


class MergerNode(Leaf):
    """The node of a merger: one job for each combination of one solution of every child from the same state."""

    stage: Merger

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._near, self._far = (LEFT, RIGHT) if self.flow is Flow.FORWARD else (RIGHT, LEFT)
        self._found: dict[State, dict[StageNode, list[Solution]]] = {}

    take, start, partners, delivers_to = (
        ParallelNode.take,
        ParallelNode.start,
        ParallelNode.partners,
        ParallelNode.delivers_to,
    )

    def rekey(self, state: State, side: int) -> None:
        """Passes the state's improved priority to the children, and requeues its combinations."""
        for child in self.children:
            child.rekey(state, side)
        self.rekey_jobs([job for subject, job in self.jobs.items() if subject[0] is state])

    def revived(self, state: State) -> None:
        """Notifies the children that the state is alive again, and requeues its parked combinations."""
        for child in self.children:
            child.revived(state)
        self.unpark([job for subject, job in self.parked.items() if subject[0] is state])

    def works_on(self, state: State, side: int) -> bool:
        """Whether a combination of solutions from the state waits, or further ones may still become complete."""
        return self._combines(state, lambda child: child.works_on(state, side))

    def may_add(self, state: State, side: int, lane: object) -> bool:
        """Whether a combination of solutions from the state waits, or runnable jobs may complete another."""
        return self._combines(state, lambda child: child.may_add(state, side, lane))

    def _combines(self, state: State, works: Callable[[StageNode], bool]) -> bool:
        if self.closed:
            return False
        if any(subject[0] is state for subject in self.jobs):
            return True
        found, working = self._found.get(state, {}), [works(child) for child in self.children]
        return any(working) and all(w or found.get(c) for w, c in zip(working, self.children, strict=True))

    def busy(self) -> bool:
        """Whether combinations of solutions wait to be merged, or a child is busy."""
        return super().busy() or (not self.closed and any(child.busy() for child in self.children))

    def child_solved(self, child: StageNode, solution: Solution) -> None:
        """Queues a job for each combination of the new solution with solutions of all other children."""
        state = solution.start if self._near == LEFT else solution.end
        if state is None:
            raise ValueError("a success has a state on both sides")
        found = self._found.setdefault(state, {})
        found.setdefault(child, []).append(solution)
        choices = [[solution] if other is child else found.get(other, []) for other in self.children]
        for chosen in product(*choices):
            self.queue(StageJob((state, *chosen), self.arguments((state.scene, chosen), state.properties)))
        self.planning.recheck(state, self._far)

    def key(self, job: StageJob) -> tuple[Any, ...]:
        """The sort key: the job's number of runs, the best path's length, its cost with the solutions."""
        state, *chosen = job.subject
        depth, cost = state.order[self._near]
        return job.asked, depth, cost + sum(s.cost for s in chosen)

    def runnable(self, job: StageJob) -> bool:
        """Whether the job's state is alive on the side from which the merger reads it."""
        state: State = job.subject[0]
        return state.alive[self._near]

    def lane(self, job: StageJob) -> object:
        """The lane of the state from which the job's solutions start."""
        return job.subject[0].lane

    def done(self, job: StageJob) -> None:
        """Requests a recheck of the job's state, since this job adds no more solutions from it."""
        self.planning.recheck(job.subject[0], self._far)

    def function(self) -> Callable[..., Answers]:
        """The stage function of a merger: its `merge` method."""
        return self.stage.merge

    def solve(self, job: StageJob, result: Result) -> None:
        """Makes a new state of the merged result, on the side that the merger writes."""
        near, *chosen = job.subject
        far = self.new_state(result.scene, {**near.properties, **result.properties}, near.lane)
        start, end = (near, far) if self._near == LEFT else (far, near)
        self.report(self.solution(start, end, result, tuple(chosen)))
